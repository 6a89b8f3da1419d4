//! The static files of the page, embedded in the program: markup, styles, scripts.

use std::sync::LazyLock;

use isomend_files::report::html::STYLE;
use isomend_files::report::scripts::{Script, bundle};

const HTML: &str = include_str!("../web/page.html");
/// The start page of a folder.
#[cfg(not(target_family = "wasm"))]
const START: &str = include_str!("../web/start.html");
/// The page's additions to the style of the report.
const OWN_STYLE: &str = include_str!("../web/page.css");
/// The page's layout.
const LAYOUT: &str = include_str!("../web/layout.css");
const WORKER: Script = ("worker.js", include_str!("../web/worker.js"));
/// The page's own modules, in no order: `main.js` imports what it needs.
const OWN: [Script; 51] = [
    ("aspects.js", include_str!("../web/aspects.js")),
    ("band.js", include_str!("../web/band.js")),
    ("bottom.js", include_str!("../web/bottom.js")),
    ("choices.js", include_str!("../web/choices.js")),
    ("components.js", include_str!("../web/components.js")),
    ("creases.js", include_str!("../web/creases.js")),
    ("defects.js", include_str!("../web/defects.js")),
    ("deliver.js", include_str!("../web/deliver.js")),
    (
        "deliver_strings.js",
        include_str!("../web/deliver_strings.js"),
    ),
    ("display.js", include_str!("../web/display.js")),
    ("faces.js", include_str!("../web/faces.js")),
    ("fields.js", include_str!("../web/fields.js")),
    ("folder.js", include_str!("../web/folder.js")),
    ("folds.js", include_str!("../web/folds.js")),
    ("hole_card.js", include_str!("../web/hole_card.js")),
    ("holes.js", include_str!("../web/holes.js")),
    ("icons.js", include_str!("../web/icons.js")),
    ("job_strings.js", include_str!("../web/job_strings.js")),
    ("keys.js", include_str!("../web/keys.js")),
    ("layout.js", include_str!("../web/layout.js")),
    ("like.js", include_str!("../web/like.js")),
    ("like_strings.js", include_str!("../web/like_strings.js")),
    ("main.js", include_str!("../web/main.js")),
    ("mask.js", include_str!("../web/mask.js")),
    ("masks.js", include_str!("../web/masks.js")),
    ("rims.js", include_str!("../web/rims.js")),
    ("measure.js", include_str!("../web/measure.js")),
    ("memory.js", include_str!("../web/memory.js")),
    ("model.js", include_str!("../web/model.js")),
    ("net.js", include_str!("../web/net.js")),
    ("opener.js", include_str!("../web/opener.js")),
    ("outline.js", include_str!("../web/outline.js")),
    ("overhangs.js", include_str!("../web/overhangs.js")),
    ("paint.js", include_str!("../web/paint.js")),
    ("paint_strings.js", include_str!("../web/paint_strings.js")),
    (
        "parameter_strings.js",
        include_str!("../web/parameter_strings.js"),
    ),
    ("plane.js", include_str!("../web/plane.js")),
    ("presets.js", include_str!("../web/presets.js")),
    ("print_strings.js", include_str!("../web/print_strings.js")),
    ("result.js", include_str!("../web/result.js")),
    ("save.js", include_str!("../web/save.js")),
    ("settings.js", include_str!("../web/settings.js")),
    ("smoother.js", include_str!("../web/smoother.js")),
    ("start.js", include_str!("../web/start.js")),
    ("steps.js", include_str!("../web/steps.js")),
    ("strings.js", include_str!("../web/strings.js")),
    ("tabs.js", include_str!("../web/tabs.js")),
    ("topology.js", include_str!("../web/topology.js")),
    ("verdict.js", include_str!("../web/verdict.js")),
    ("views.js", include_str!("../web/views.js")),
    ("walls.js", include_str!("../web/walls.js")),
];
/// The modules of the viewer and the page, bundled into one script.
static SCRIPT: LazyLock<String> = LazyLock::new(|| bundle("main.js", &OWN));

/// The modules of the start page, bundled into one script.
#[cfg(not(target_family = "wasm"))]
static START_SCRIPT: LazyLock<String> = LazyLock::new(|| bundle("start.js", &OWN));

/// The worker with the modules that it shares with the viewer.
static WORKER_SCRIPT: LazyLock<String> = LazyLock::new(|| bundle(WORKER.0, &[WORKER]));

/// The content of a file of the page, with its media type.
pub fn asset(name: &str) -> Option<(&'static str, String)> {
    let (kind, text) = match name {
        "" => ("text/html; charset=utf-8", HTML.to_owned()),
        "page.css" => (
            "text/css; charset=utf-8",
            [STYLE, OWN_STYLE, LAYOUT].join("\n"),
        ),
        "page.js" => ("text/javascript; charset=utf-8", SCRIPT.clone()),
        "worker.js" => ("text/javascript; charset=utf-8", WORKER_SCRIPT.clone()),
        _ => return None,
    };
    Some((kind, text))
}

/// The content of a file of the start page of a folder, with its media type.
#[cfg(not(target_family = "wasm"))]
pub fn start_asset(name: &str) -> Option<(&'static str, String)> {
    match name {
        "" => Some(("text/html; charset=utf-8", START.to_owned())),
        "start.js" => Some(("text/javascript; charset=utf-8", START_SCRIPT.clone())),
        "page.css" => asset(name),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_script_contains_all_its_imports() {
        for main in ["main.js", "start.js"] {
            isomend_files::report::scripts::check(main, &super::OWN);
        }
        isomend_files::report::scripts::check("worker.js", &[super::WORKER]);
    }
}
