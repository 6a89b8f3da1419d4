//! The files of the page.

use crate::report::html::{STYLE, VIEWER};

const HTML: &str = include_str!("page/page.html");
/// What it has beside the looks of the report.
const OWN_STYLE: &str = include_str!("page/page.css");
const WORKER: &str = include_str!("page/worker.js");
/// The page's own scripts, after those of the viewer, in the order of `page/order.txt`.
const OWN: [(&str, &str); 12] = [
    ("net.js", include_str!("page/net.js")),
    ("model.js", include_str!("page/model.js")),
    ("topology.js", include_str!("page/topology.js")),
    ("mask.js", include_str!("page/mask.js")),
    ("choices.js", include_str!("page/choices.js")),
    ("paint.js", include_str!("page/paint.js")),
    ("fields.js", include_str!("page/fields.js")),
    ("display.js", include_str!("page/display.js")),
    ("holes.js", include_str!("page/holes.js")),
    ("steps.js", include_str!("page/steps.js")),
    ("save.js", include_str!("page/save.js")),
    ("main.js", include_str!("page/main.js")),
];

/// A file of the page and its type.
pub fn asset(name: &str) -> Option<(&'static str, String)> {
    let (kind, text) = match name {
        "" => ("text/html; charset=utf-8", HTML.to_owned()),
        "page.css" => ("text/css; charset=utf-8", [STYLE, OWN_STYLE].join("\n")),
        "page.js" => ("text/javascript; charset=utf-8", script()),
        "worker.js" => ("text/javascript; charset=utf-8", WORKER.to_owned()),
        _ => return None,
    };
    Some((kind, text))
}

/// The scripts of the viewer and the page in one.
fn script() -> String {
    let own = OWN.iter().map(|(_, text)| *text);
    let parts: Vec<&str> = VIEWER.into_iter().chain(own).collect();
    parts.join("\n")
}

#[cfg(test)]
mod tests {
    use super::OWN;

    #[test]
    fn the_scripts_stand_in_the_order_of_the_list() {
        let listed: Vec<&str> = include_str!("page/order.txt").lines().collect();
        assert_eq!(OWN.map(|(name, _)| name).to_vec(), listed);
    }
}
