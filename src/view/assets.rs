//! The files of the page.

use crate::report::html::VIEWER;

/// The page's own scripts, after those of the viewer, in their order.
const OWN: [&str; 0] = [];

/// A file of the page and its type.
pub fn asset(name: &str) -> Option<(&'static str, String)> {
    let javascript = "text/javascript; charset=utf-8";
    match name {
        "page.js" => Some((javascript, [&VIEWER[..], &OWN[..]].concat().join("\n"))),
        _ => None,
    }
}
