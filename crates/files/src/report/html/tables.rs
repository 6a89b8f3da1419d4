//! Lists and tables of an HTML report: facts, remarks, holes and regions.

use std::cmp::Reverse;
use std::fmt::Write;

use super::super::counterpart::{counterpart_text, grain_text};
use super::super::counts::counted;
use super::super::scene::Scene;
use super::super::significant;
use super::super::text::lost_creases;
use super::{Badge, MOST_PLACES, MarkedDefect, add, escaped, listed, number, number_beside};
use isomend_core::fill::{Closure, HoleOutcome, RegionReport};
use isomend_core::mend::HoleReport;

/// What a page says of each hole, after a change or for a mesh that was only inspected.
pub struct OutcomeLabels {
    /// Whether the mesh was only inspected.
    single: bool,
    /// The largest expected error in each region, from region 1; 0 if it is unknown.
    errors: Vec<f32>,
}

impl OutcomeLabels {
    /// The labels of a page that shows `scene`, whose expected errors they name.
    pub fn new(scene: &Scene, single: bool) -> Self {
        let mut errors = Vec::new();
        for (face, region) in scene.faces[scene.kept..].iter().zip(&scene.regions) {
            let at = *region as usize;
            if errors.len() < at {
                errors.resize(at, 0.0);
            }
            let known = face.iter().map(|&v| scene.error[v as usize]);
            if let Some(own) = at.checked_sub(1).and_then(|at| errors.get_mut(at)) {
                // Unknown errors are NaN, which `f32::max` ignores.
                *own = known.fold(*own, f32::max);
            }
        }
        Self { single, errors }
    }

    /// The largest expected error of the patch of a hole, if one is known.
    fn error(&self, hole: &HoleReport) -> Option<f64> {
        let found = self.errors.get(hole.region.checked_sub(1)?);
        found.map(|e| f64::from(*e)).filter(|e| *e > 0.0)
    }

    /// The name of an outcome.
    fn of(&self, outcome: &HoleOutcome) -> &'static str {
        match outcome {
            HoleOutcome::Left(_) if self.single => "open",
            other => other.name(),
        }
    }

    /// The reason for a hole's outcome; empty if there is none.
    fn why(&self, hole: &HoleReport) -> String {
        let why = hole.outcome.reason().filter(|_| !self.single);
        escaped(&why.unwrap_or_default())
    }

    /// Numbers of holes by outcome, as list items.
    pub fn status(&self, holes: &[HoleReport]) -> String {
        let mut out = String::new();
        let mut counts: Vec<(String, &str, usize)> = Vec::new();
        for hole in holes {
            let (class, word) = (class(&hole.outcome), self.of(&hole.outcome));
            match counts.iter_mut().find(|(known, ..)| *known == class) {
                Some((.., count)) => *count += 1,
                None => counts.push((class, word, 1)),
            }
        }
        counts.sort_by_key(|(class, _, count)| (!class.starts_with("closed"), Reverse(*count)));
        for (class, word, count) in counts {
            add!(out, "<li class=\"{class}\">{count} {word}</li>");
        }
        out
    }

    /// A button for each hole.
    pub fn hole_list(&self, holes: &[HoleReport]) -> String {
        let mut out = String::new();
        for h in holes {
            let (class, why) = (class(&h.outcome), self.why(h));
            add!(
                out,
                "<li><button type=\"button\" class=\"hole {class}\" data-hole=\"{id}\" aria-pressed=\"false\">\
             <span class=\"name\">{what} {id}</span><span class=\"outcome\">{}</span>\
             <span class=\"size\">{} across, {} edges</span>",
                self.of(&h.outcome),
                number(h.hole.diameter),
                h.hole.edges,
                id = h.hole.id,
                what = if h.hole.outer_boundary {
                    "Border"
                } else {
                    "Hole"
                },
            );
            if let Some(error) = self.error(h) {
                add!(
                    out,
                    "<span class=\"why\">expected error up to {}</span>",
                    error_number(error)
                );
            }
            if let Some(object) = &h.hole.object {
                add!(out, "<span class=\"why\">in {}</span>", escaped(object));
            }
            if !why.is_empty() {
                add!(out, "<span class=\"why\">{}</span>", why);
            }
            out.push_str("</button></li>");
        }
        out
    }

    /// The rows of the table of holes.
    pub fn hole_table(&self, holes: &[HoleReport]) -> String {
        let mut out = String::new();
        let names = names_objects(holes);
        for h in holes {
            let (class, why) = (class(&h.outcome), self.why(h));
            let [x, y, z] = h.hole.centre.to_array().map(number);
            let normal = h.hole.normal.to_array().map(|x| format!("{x:.3}"));
            let normal = normal.join(", ").replace('-', "−");
            let object = match names {
                true => format!(
                    "<td class=\"text\">{}</td>",
                    escaped(h.hole.object.as_deref().unwrap_or_default())
                ),
                false => String::new(),
            };
            add!(
                out,
                "<tr><th scope=\"row\"><a href=\"#hole-{id}\" data-hole=\"{id}\">{id}</a></th>{object}<td>{}</td><td>{}</td><td>{}</td>\
             <td>{}</td><td>{}</td><td>{}</td><td>{x}, {y}, {z}</td><td>{normal}</td><td>{}</td><td class=\"change\">{}</td><td class=\"text\"><span class=\"tag {class}\">{}\
             </span> {}</td></tr>",
                h.hole.edges,
                number(h.hole.length),
                number(h.hole.diameter),
                number(h.hole.width),
                number_beside(h.hole.height, h.hole.diameter),
                number(h.hole.planarity),
                if h.region == 0 {
                    "–".to_owned()
                } else {
                    h.region.to_string()
                },
                self.error(h).map_or_else(|| "–".to_owned(), error_number),
                self.of(&h.outcome),
                why,
                id = h.hole.id,
            );
        }
        out
    }
}

/// The classes of an outcome in the style sheet: closed or open, and how it was closed.
fn class(outcome: &HoleOutcome) -> String {
    let how = outcome.closure().map_or("", Closure::key);
    format!("{} {how}", outcome.key()).trim_end().to_owned()
}

/// Whether the holes belong to several objects of a 3MF file, which the table and the list then name.
fn names_objects(holes: &[HoleReport]) -> bool {
    holes.iter().any(|h| h.hole.object.is_some())
}

/// The heading of the column of objects in the table of holes; empty where there is one object.
pub fn object_heading(holes: &[HoleReport]) -> &'static str {
    match names_objects(holes) {
        true => "<th class=\"text\">object</th>",
        false => "",
    }
}

/// The verdict in the header; empty if there is none.
pub fn badge(badge: Option<&Badge>) -> String {
    badge.map_or(String::new(), |badge| {
        let (class, text) = (badge.class, escaped(&badge.text));
        format!("<p class=\"badge {class}\" role=\"status\">{text}</p>")
    })
}

/// How many places a button leads to, and of how many.
fn places(all: usize) -> String {
    match all > MOST_PLACES {
        true => format!("{MOST_PLACES} of {}", counted(all, "place")),
        false => counted(all, "place"),
    }
}

/// A heading and a button for each kind of defect, with its colour in the view; empty if there are none.
pub fn defect_list(defects: &[MarkedDefect]) -> String {
    let mut out = String::new();
    for (number, defect) in defects.iter().enumerate() {
        let [r, g, b] = defect.rgb;
        add!(
            out,
            "<li><button type=\"button\" class=\"hole\" data-defect=\"{number}\"><span class=\"name\"><i class=\"swatch\" \
             style=\"background:rgb({r},{g},{b})\"></i>{}</span><span class=\"size\">at {}</span></button></li>",
            escaped(&defect.text),
            places(defect.places.len()),
        );
    }
    match out.is_empty() {
        true => out,
        false => format!("<h2>Defects</h2><ol id=\"faults\">{out}</ol>"),
    }
}

/// Facts, as names and values.
pub fn facts(facts: &[(&str, String)]) -> String {
    let mut out = String::new();
    for (name, value) in facts {
        add!(
            out,
            "<div><dt>{}</dt><dd>{}</dd></div>",
            escaped(name),
            escaped(value)
        );
    }
    out
}

/// Remarks, with one more if the view does not show all faces.
pub fn notes(notes: &[String], scene: &Scene) -> String {
    let mut out = String::new();
    for note in notes {
        add!(out, "<li>{}</li>", escaped(note));
    }
    if scene.faces.len() < scene.all_faces {
        add!(
            out,
            "<li>To limit the size of this page, the view shows {} of {} faces: far from the patches the surface is drawn \
             coarser. The written mesh has all faces.</li>",
            scene.faces.len(),
            scene.all_faces
        );
    }
    out
}

/// An expected error: it is known to two digits.
fn error_number(error: f64) -> String {
    significant(error, 2).replace('-', "−")
}

/// The rows of the table of regions; regions for which no level set was solved share a row for each way in which they were
/// closed.
pub fn region_table(regions: &[RegionReport]) -> String {
    let mut out = String::new();
    let plain = |r: &RegionReport| r.levels.is_empty() && r.failed_attempts.is_empty();
    for r in regions.iter().filter(|r| !plain(r)) {
        region_row(&mut out, r);
    }
    let mut kinds: Vec<&str> = Vec::new();
    let small = || regions.iter().filter(|r| plain(r));
    let name = |r: &RegionReport| r.closure.as_ref().map(Closure::name);
    for kind in small().filter_map(name) {
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    for kind in kinds {
        let own = || small().filter(|r| name(r) == Some(kind));
        add!(
            out,
            "<tr class=\"more\"><td colspan=\"12\">{}: closed by {kind}, {}</td></tr>",
            counted(own().count(), "more region"),
            counted(own().map(|r| r.new_faces).sum(), "face")
        );
    }
    out
}

/// The parts of a patch that its surroundings do not predict: its counterpart and its grain.
fn invented_rows(out: &mut String, r: &RegionReport) {
    let invented = [counterpart_text(r, None), grain_text(r, None)];
    for text in invented.into_iter().flatten() {
        let (id, text) = (r.id, escaped(&text));
        add!(
            out,
            "<tr class=\"more\"><td colspan=\"12\">region {id}: {text}</td></tr>"
        );
    }
}

/// The row of a region, with one more row if sharp edges were not continued, and one if there were earlier attempts.
fn region_row(out: &mut String, r: &RegionReport) {
    let steps: usize = r.levels.iter().map(|l| l.flow.steps.len()).sum();
    let last = r.levels.last();
    let energies = last.map_or("–".to_owned(), |l| {
        format!(
            "{} → {}",
            number(l.flow.energy_before),
            number(l.flow.energy_after)
        )
    });
    let state = match last {
        None => "no flow",
        Some(_) if r.converged => "converged",
        Some(_) => "not converged",
    };
    let across = r.voxel.map(|voxel| format!("{:.0}", r.diameter / voxel));
    let across = across.unwrap_or_else(|| "–".to_owned());
    add!(
        out,
        "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{across}</td><td>{steps}</td><td>{state}</td>\
         <td>{energies}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
        r.id,
        listed(&r.holes),
        number(r.diameter),
        match (r.seam_angle_mean, r.seam_angle_max) {
            (Some(mean), Some(largest)) => format!("{mean:.1}° / {largest:.1}°"),
            _ => "–".to_owned(),
        },
        r.new_faces,
        if r.quality_mean > 0.0 {
            format!("{:.3}", r.quality_mean)
        } else {
            "–".to_owned()
        },
        r.intersecting_faces,
        match r.seconds {
            0.0 => "–".to_owned(),
            seconds => format!("{seconds:.2}"),
        },
    );
    if let Some(lost) = lost_creases(r) {
        let (id, lost) = (r.id, escaped(&lost));
        add!(
            out,
            "<tr class=\"more\"><td colspan=\"12\">region {id}: {lost}</td></tr>"
        );
    }
    invented_rows(out, r);
    if !r.failed_attempts.is_empty() {
        let attempts: Vec<String> = r
            .failed_attempts
            .iter()
            .map(|t| escaped(&t.to_string()))
            .collect();
        add!(
            out,
            "<tr class=\"more\"><td colspan=\"12\">region {}: earlier attempts failed: {}</td></tr>",
            r.id,
            attempts.join("; ")
        );
    }
}
