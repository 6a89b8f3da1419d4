//! HTML reports: a single self-contained page that needs no network and no other file.
//!
//! Tables and plots are written here; the page's script draws the 3D view from data packed into the page. The same input gives the same
//! page at any number of threads, except for run times.

mod pack;
mod plot;
mod tables;

use std::fmt::Write;

use glam::DVec3;
use serde::Serialize;

use super::scene::Scene;
use super::scripts::{Script, bundle};
use isomend_core::fill::RegionReport;
use isomend_core::mend::HoleReport;
use isomend_core::mesh::HoleId;

/// Most places of a kind of defect to which a page leads.
const MOST_PLACES: usize = 200;
const TEMPLATE: &str = include_str!("page.html");
/// The style sheet of a report; the style sheet of the interactive view starts with it.
#[doc(hidden)]
pub const STYLE: &str = include_str!("page.css");
/// The script of a report.
const SCRIPT: [Script; 1] = [("page.js", include_str!("page.js"))];

/// The content of a page. All text is escaped when it is written.
pub struct HtmlPage<'a> {
    /// The heading, such as the name of the file.
    pub title: &'a str,
    /// The command, such as `fill`.
    pub command: &'a str,
    /// The command line, as the user gave it.
    pub command_line: &'a str,
    /// The version of the program.
    pub version: &'a str,
    /// Facts of the run, as names and values.
    pub facts: &'a [(&'a str, String)],
    /// Remarks, one sentence each.
    pub notes: &'a [String],
    /// The holes.
    pub holes: &'a [HoleReport],
    /// The regions.
    pub regions: &'a [RegionReport],
    /// The meshes.
    pub scene: &'a Scene,
    /// The mesh was only inspected: there is no mesh after, and holes have no outcome.
    pub single: bool,
    /// The verdict in the header; `None` where there is none.
    pub badge: Option<Badge>,
    /// The kinds of defects that the view marks.
    pub defects: &'a [MarkedDefect],
}

/// A verdict in the header of a page, in a colour.
#[doc(hidden)]
pub struct Badge {
    /// Its class in the style sheet: `good`, `fair` or `bad`.
    pub class: &'static str,
    /// The verdict in a few words.
    pub text: String,
}

/// A kind of defect, in the colour that its faces have in the view.
#[doc(hidden)]
pub struct MarkedDefect {
    /// The defect in words, with its count.
    pub text: String,
    /// Its colour: red, green and blue (sRGB).
    pub rgb: [u8; 3],
    /// The centres of its groups of faces, in the mesh's coordinates.
    pub places: Vec<DVec3>,
}

/// A hole, as data for the page's script. `centre` is relative to the scene's origin.
#[derive(Serialize)]
struct HoleItem {
    id: usize,
    region: usize,
    centre: [f32; 3],
    diameter: f64,
    open: bool,
}

/// Writes a page as HTML.
pub fn page(page: &HtmlPage) -> String {
    let scene = page.scene;
    let (geometry, header) = pack::packed(scene);
    let holes: Vec<HoleItem> = page
        .holes
        .iter()
        .map(|h| HoleItem {
            id: h.hole.id.get(),
            region: h.region,
            centre: (h.hole.centre - scene.origin).as_vec3().to_array(),
            diameter: h.hole.diameter,
            open: h.outcome.closure().is_none(),
        })
        .collect();
    let of_defect = |defect: &MarkedDefect| -> Vec<[f32; 3]> {
        let places = defect.places.iter().take(MOST_PLACES);
        places
            .map(|p| (*p - scene.origin).as_vec3().to_array())
            .collect()
    };
    let defects: Vec<_> = page.defects.iter().map(of_defect).collect();
    let ends: Vec<[f32; 3]> = scene.points.iter().map(|p| p.to_array()).collect();
    let data = serde_json::json!({
        "scene": header, "holes": holes, "ends": ends, "single": page.single, "defects": defects
    });
    let labels = tables::OutcomeLabels::new(scene, page.single);
    filled(TEMPLATE, |name| match name {
        "title" => escaped(page.title),
        "command" => escaped(page.command),
        "version" => escaped(page.version),
        "command-line" => escaped(page.command_line),
        "style" => STYLE.to_owned(),
        "script" => bundle("page.js", &SCRIPT),
        "kind" => if page.single { "inspect" } else { "changed" }.to_owned(),
        "plain" => if page.single { "Surface" } else { "Patches" }.to_owned(),
        "badge" => tables::badge(page.badge.as_ref()),
        "defect-list" => tables::defect_list(page.defects),
        "status" => labels.status(page.holes),
        "facts" => tables::facts(page.facts),
        "notes" => tables::notes(page.notes, scene),
        "hole-list" => labels.hole_list(page.holes),
        "hole-object" => tables::object_heading(page.holes).to_owned(),
        "hole-table" => labels.hole_table(page.holes),
        "regions" => tables::region_table(page.regions),
        "plots" => plot::plots(page.regions),
        "data" => data.to_string().replace('<', "\\u003c"),
        "geometry" => geometry.clone(),
        _ => String::new(),
    })
}

/// Replaces each `{{name}}` of a template by its value. Values are not searched for names again.
fn filled(template: &str, value: impl Fn(&str) -> String) -> String {
    let mut out = String::new();
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        let Some((name, after)) = after.split_once("}}") else {
            break;
        };
        out.push_str(before);
        out.push_str(&value(name));
        rest = after;
    }
    out.push_str(rest);
    out
}

/// Escapes text for HTML elements and quoted attributes.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // Control characters are not allowed in HTML, and marks of text direction would reorder the text around them.
            c if c.is_control() && c != '\n' && c != '\t' => out.push('\u{fffd}'),
            '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// A number as text reports have it, with a minus sign instead of a hyphen; a dash if it is not finite.
fn number(x: f64) -> String {
    match x.is_finite() {
        true => isomend_core::mesh::number(x).replace('-', "−"),
        false => "–".to_owned(),
    }
}

/// As [`number`], for a length measured on an object of a size: a length that is only rounding error at that size becomes 0.
fn number_beside(x: f64, size: f64) -> String {
    number(isomend_core::mesh::beside(x, size))
}

/// Appends formatted text to a string, which never fails.
macro_rules! add {
    ($out:expr, $($rest:tt)*) => {
        let _ = write!($out, $($rest)*);
    };
}
use add;

/// Hole numbers, joined by ` + `.
fn listed(ids: &[HoleId]) -> String {
    let mut out = String::new();
    for (i, id) in ids.iter().enumerate() {
        add!(out, "{}{id}", if i == 0 { "" } else { " + " });
    }
    out
}

#[cfg(test)]
mod tests {
    use super::{escaped, filled, number};

    #[test]
    fn the_script_has_all_that_it_imports() {
        crate::report::scripts::check("page.js", &super::SCRIPT);
    }

    #[test]
    fn markup_in_text_is_harmless() {
        let text = escaped("</script><img src=x onerror='a' title=\"b\">&\u{7}\u{202e}");
        assert!(!text.contains(['<', '>', '"', '\'', '\u{7}', '\u{202e}']));
        assert!(text.starts_with("&lt;/script&gt;"));
    }

    #[test]
    fn values_are_not_taken_for_templates() {
        let value = |name: &str| match name {
            "a" => "{{b}}".to_owned(),
            other => format!("[{other}]"),
        };
        assert_eq!(filled("x {{a}} {{b}} {{", value), "x {{b}} [b] {{");
    }

    #[test]
    fn numbers_have_four_digits() {
        let cases = [
            (0.0, "0"),
            (1.0, "1"),
            (-12.3456, "−12.35"),
            (123_456.7, "123457"),
            (0.001_234_5, "0.001234"),
            (1.5e-9, "1.500e−9"),
            (f64::NAN, "–"),
        ];
        for (x, text) in cases {
            assert_eq!(number(x), text);
        }
    }
}
