//! The static files of the page, embedded in the program: markup, styles, scripts.

use std::sync::LazyLock;

use crate::report::html::STYLE;
use crate::report::scripts::{Script, bundle};

const HTML: &str = include_str!("page/page.html");
/// The page's additions to the style of the report.
const OWN_STYLE: &str = include_str!("page/page.css");
/// The page's layout.
const LAYOUT: &str = include_str!("page/layout.css");
const WORKER: &str = include_str!("page/worker.js");
/// The page's own modules, in no order: `main.js` imports what it needs.
const OWN: [Script; 32] = [
    ("band.js", include_str!("page/band.js")),
    ("choices.js", include_str!("page/choices.js")),
    ("creases.js", include_str!("page/creases.js")),
    ("defects.js", include_str!("page/defects.js")),
    ("deliver.js", include_str!("page/deliver.js")),
    (
        "deliver_strings.js",
        include_str!("page/deliver_strings.js"),
    ),
    ("display.js", include_str!("page/display.js")),
    ("fields.js", include_str!("page/fields.js")),
    ("folder.js", include_str!("page/folder.js")),
    ("folds.js", include_str!("page/folds.js")),
    ("holes.js", include_str!("page/holes.js")),
    ("keys.js", include_str!("page/keys.js")),
    ("layout.js", include_str!("page/layout.js")),
    ("like.js", include_str!("page/like.js")),
    ("like_strings.js", include_str!("page/like_strings.js")),
    ("main.js", include_str!("page/main.js")),
    ("mask.js", include_str!("page/mask.js")),
    ("masks.js", include_str!("page/masks.js")),
    ("measure.js", include_str!("page/measure.js")),
    ("model.js", include_str!("page/model.js")),
    ("net.js", include_str!("page/net.js")),
    ("outline.js", include_str!("page/outline.js")),
    ("paint.js", include_str!("page/paint.js")),
    ("paint_strings.js", include_str!("page/paint_strings.js")),
    ("plane.js", include_str!("page/plane.js")),
    ("presets.js", include_str!("page/presets.js")),
    ("save.js", include_str!("page/save.js")),
    ("smoother.js", include_str!("page/smoother.js")),
    ("steps.js", include_str!("page/steps.js")),
    ("strings.js", include_str!("page/strings.js")),
    ("topology.js", include_str!("page/topology.js")),
    ("views.js", include_str!("page/views.js")),
];
/// The modules of the viewer and the page, bundled into one script.
static SCRIPT: LazyLock<String> = LazyLock::new(|| bundle("main.js", &OWN));

/// The content of a file of the page, with its media type.
pub fn asset(name: &str) -> Option<(&'static str, String)> {
    let (kind, text) = match name {
        "" => ("text/html; charset=utf-8", HTML.to_owned()),
        "page.css" => (
            "text/css; charset=utf-8",
            [STYLE, OWN_STYLE, LAYOUT].join("\n"),
        ),
        "page.js" => ("text/javascript; charset=utf-8", SCRIPT.clone()),
        "worker.js" => ("text/javascript; charset=utf-8", WORKER.to_owned()),
        _ => return None,
    };
    Some((kind, text))
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_script_contains_all_its_imports() {
        crate::report::scripts::check("main.js", &super::OWN);
    }
}
