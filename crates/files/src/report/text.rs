//! Reports of fills as plain text: defects, regions, levels, reasons and the summary line.

use std::collections::HashMap;

use super::counterpart::{self, counterpart_text, grain_text};
use super::counts::{counted, counted_as, error_text, open_chains, timed};
use isomend_core::fill::{
    Closure, FinishReport, HoleOutcome, NotSmooth, PatchInitialisation, RegionReport,
};
use isomend_core::finish::{FinishRecord, FinishResult};
use isomend_core::flow::Energy;
use isomend_core::mend::FillReport;
use isomend_core::mesh::{Defects, HoleId, OpenChain, Unit, number, point, significant};
use isomend_core::region::LevelReport;

/// Most hole numbers of a region in a line.
const MOST_JOINED: usize = 12;
/// Most ranges of hole numbers in a line.
const MOST_RANGES: usize = 24;
/// Most boundary chains that get a line each.
const MOST_CHAINS: usize = 12;
/// Most reasons that get a line each.
const MOST_REASONS: usize = 50;

/// The defects of a mesh, one line for each kind that it has.
#[doc(hidden)]
pub fn defect_lines(d: &Defects) -> Vec<String> {
    let all = [
        (d.degenerate_faces, "degenerate faces"),
        (d.non_manifold_edges, "edges with more than two faces"),
        (
            d.misoriented_edges,
            "edges whose two faces have opposite orientations",
        ),
        (
            d.reoriented_faces,
            "faces turned the other way than their component",
        ),
        (
            d.non_manifold_boundary_vertices,
            "vertices where the boundary passes more than once",
        ),
        (
            d.duplicate_vertices,
            "vertices at the position of an earlier one",
        ),
        (d.small_components, "components of one or two triangles"),
    ];
    all.iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, what)| counted_as(*n, what))
        .collect()
}

/// How a region was closed by continued sides: the sharp edges in which they meet.
fn sharp(r: &RegionReport, unit: Option<Unit>) -> String {
    let total: f64 = r.creases.iter().map(|c| c.length).sum();
    match &r.creases[..] {
        [] => "closed by continuing the smooth surface round its rim".to_owned(),
        [one] => format!(
            "closed by two continued sides that meet in a sharp edge of {:.0}°, {} long",
            one.angle,
            Unit::text(unit, total)
        ),
        all => format!(
            "closed by continued sides that meet in {} sharp edges, {} long in total",
            all.len(),
            Unit::text(unit, total)
        ),
    }
}

/// What closed a hole, to follow `closed by`.
pub(super) fn with_article(how: &Closure) -> String {
    let article = match how {
        Closure::Flat | Closure::Base | Closure::Counterpart => "a ",
        Closure::OffsetShell(_) => "an ",
        Closure::LevelSet => "the ",
        _ => "",
    };
    format!("{article}{}", how.name())
}

/// One line for a region: the surface that closed it, its expected error, its faces, and warnings.
#[doc(hidden)]
pub fn region_lines(r: &RegionReport) -> String {
    region_lines_in(r, None)
}

/// [`region_lines`] with the unit of lengths.
#[doc(hidden)]
pub fn region_lines_in(r: &RegionReport, unit: Option<Unit>) -> String {
    let mut line = format!(
        "hole {}: diameter {}, ",
        joined(&r.holes),
        Unit::text(unit, r.diameter)
    );
    line += &match &r.closure {
        Some(Closure::LevelSet) => solved(r),
        Some(Closure::Sides) => sharp(r, unit),
        Some(Closure::Counterpart) => counterpart::like(r, unit),
        Some(how) => format!("closed by {}", with_article(how)),
        None => "not closed".to_owned(),
    };
    if let Some(finish) = &r.finish {
        line += &finished(finish, r.largest_expected_error, unit);
    }
    line += &format!(", {}{}", counted(r.new_faces, "face"), timed(r.seconds));
    if r.closure == Some(Closure::LevelSet) && !r.levels.is_empty() && !r.converged {
        let update = r.levels.last().map_or(f64::NAN, |l| l.flow.update);
        line += &format!(
            "; not converged: the last step moved it by {} voxels",
            significant(update, 2)
        );
    }
    if r.other_energy {
        line +=
            "; solved with the Willmore energy, since the variation of curvature gave no surface";
    }
    if r.intersecting_faces > 0 {
        let verb = if r.intersecting_faces == 1 {
            "intersects"
        } else {
            "intersect"
        };
        line += &format!("; {} {verb} others", counted(r.intersecting_faces, "face"));
    }
    line += &lost_creases(r).map_or_else(String::new, |text| format!("; {text}"));
    line += &counterpart::refused(r, unit).map_or_else(String::new, |text| format!("; {text}"));
    line += &grain_text(r, unit).map_or_else(String::new, |text| format!("; {text}"));
    if r.balloons() {
        let percent = 100.0 * r.rise.unwrap_or_default();
        line += &format!("; it rises {percent:.0} % of its diameter above the rim");
    }
    if r.bridge && r.components > 1 {
        line += &format!("; its holes were closed by {} separate caps", r.components);
    }
    line
}

/// The number of sharp edges that end at a rim and were not continued, with the reason; `None` if there are none.
#[doc(hidden)]
pub fn lost_creases(r: &RegionReport) -> Option<String> {
    let why = r.not_continued.as_ref()?;
    Some(match r.crease_ends {
        0 => format!("the requested sharp edges were not made: {why}"),
        1 => format!("1 sharp edge ends at its rim and was not continued: {why}"),
        n => format!("{n} sharp edges end at its rim and were not continued: {why}"),
    })
}

/// How the triangles of a patch were smoothed at the end, and its largest expected error.
fn finished(finish: &FinishReport, error: Option<f64>, unit: Option<Unit>) -> String {
    let blended = |p: &FinishRecord| p.result == FinishResult::Blend;
    let mut text = match finish.components.iter().any(blended) {
        true => ", smoothed and blended with the continued surroundings",
        false
            if finish
                .components
                .iter()
                .all(|p| p.result == FinishResult::Unchanged) =>
        {
            ", not smoothed"
        }
        false => ", smoothed",
    }
    .to_owned();
    if finish.initialisation == PatchInitialisation::Triangulation {
        text += " starting from a triangulation";
    }
    if let Some(error) = error {
        text += &format!(", expected error up to {}", error_text(unit, error));
    }
    text
}

/// How the level set closed a region: resolution, steps and energy of the last level, and the angle at the seam.
fn solved(r: &RegionReport) -> String {
    let steps: usize = r.levels.iter().map(|l| l.flow.steps.len()).sum();
    let (before, after) = r
        .levels
        .last()
        .map_or((0.0, 0.0), |l| (l.flow.energy_before, l.flow.energy_after));
    let mut text = format!(
        "closed by the level set: {:.0} voxels across, {}, energy {} -> {}",
        r.diameter / r.voxel.unwrap_or(f64::NAN),
        counted(steps, "step"),
        number(before),
        number(after)
    );
    if let Some(seam) = r.seam_angle_mean {
        text += &format!(", seam {seam:.1} degrees");
    }
    text
}

/// The line of a level of a solve.
fn level_line(level: &LevelReport, unit: Option<Unit>) -> String {
    let flow = &level.flow;
    let iterations: usize = flow.steps.iter().map(|s| s.iterations).sum();
    format!(
        "  voxel {}{}: {} nodes, {} unknowns, {}, {}, last update {} voxels{}{}",
        Unit::text(unit, level.voxel),
        match flow.energy {
            Energy::Willmore => "",
            Energy::CurvatureVariation => ", variation of curvature",
            Energy::Own => ", the caller's energy",
        },
        level.nodes,
        flow.unknowns,
        counted(flow.steps.len(), "step"),
        counted(iterations, "iteration"),
        significant(flow.update, 2),
        if flow.converged {
            ""
        } else {
            " (not converged)"
        },
        match level.seconds {
            [0.0, 0.0] => String::new(),
            [sampled, solved] => format!(", sampled in {sampled:.2} s, solved in {solved:.2} s"),
        },
    )
}

/// Details of a region: earlier attempts, the levels of the solve from coarse to fine, and the patch.
#[doc(hidden)]
pub fn level_lines(r: &RegionReport, unit: Option<Unit>) -> Vec<String> {
    let mut lines = vec![format!("region {} (hole {}):", r.id, joined(&r.holes))];
    for why in &r.failed_attempts {
        lines.push(format!("  earlier attempt failed: {why}"));
    }
    lines.extend(r.levels.iter().map(|level| level_line(level, unit)));
    let mut patch = format!(
        "  patch: {}, {}, {}",
        counted(r.new_vertices, "vertex"),
        counted(r.new_faces, "face"),
        counted(r.components, "component")
    );
    if r.quality_mean > 0.0 {
        patch += &format!(", quality {}", significant(r.quality_mean, 3));
    }
    if let (Some(mean), Some(largest)) = (r.seam_angle_mean, r.seam_angle_max) {
        patch += &format!(", seam angle mean {mean:.2} and largest {largest:.2} degrees");
    }
    if let Some(quality) = r.quality {
        if quality.folds > 0 {
            patch += &format!(", {}", counted(quality.folds, "folded face"));
        }
        if quality.is_unconverged {
            patch += ", energy not at a minimum";
        }
    }
    lines.push(patch);
    lines.extend(lost_creases(r).map(|text| format!("  {text}")));
    let invented = [counterpart_text(r, None), grain_text(r, None)];
    lines.extend(
        invented
            .into_iter()
            .flatten()
            .map(|text| format!("  {text}")),
    );
    lines
}

/// Numbers of holes that are filled together, such as `3+7`; of many holes only the first.
pub(super) fn joined(holes: &[HoleId]) -> String {
    let shown = &holes[..holes.len().min(MOST_JOINED)];
    let numbers: Vec<String> = shown.iter().map(ToString::to_string).collect();
    match holes.len() - shown.len() {
        0 => numbers.join("+"),
        more => format!("{} and {more} more", numbers.join("+")),
    }
}

/// `hole 3`, or `holes 3, 5-7`.
#[doc(hidden)]
pub fn named_holes(ids: &[HoleId]) -> String {
    let noun = if ids.len() == 1 { "hole" } else { "holes" };
    format!("{noun} {}", ranges(ids))
}

/// Says something of all of at least one hole, with a verb for one and for several.
pub(crate) fn every_hole(count: usize, [one, several]: [&str; 2], what: &str) -> String {
    match count {
        1 => format!("the hole {one} {what}"),
        2 => format!("both holes {several} {what}"),
        all => format!("all {all} holes {several} {what}"),
    }
}

/// Numbers as a list of ranges, such as `1, 4-9, 12`; of many ranges only the first.
#[doc(hidden)]
pub fn ranges<N: Copy + Into<usize>>(numbers: &[N]) -> String {
    let mut sorted: Vec<usize> = numbers.iter().map(|&n| n.into()).collect();
    sorted.sort_unstable();
    let mut parts: Vec<(usize, usize)> = Vec::new();
    for n in sorted {
        match parts.last_mut() {
            Some(last) if n <= last.1 + 1 => last.1 = n,
            _ => parts.push((n, n)),
        }
    }
    let shown = &parts[..parts.len().min(MOST_RANGES)];
    let text = |&(a, b): &(usize, usize)| match b - a {
        0 => a.to_string(),
        1 => format!("{a}, {b}"),
        _ => format!("{a}-{b}"),
    };
    let mut line = shown.iter().map(text).collect::<Vec<_>>().join(", ");
    let more: usize = parts[shown.len()..].iter().map(|(a, b)| b - a + 1).sum();
    if more > 0 {
        line += &format!(" and {more} more");
    }
    line
}

/// One line for each boundary chain that does not close; of many chains only the first.
#[doc(hidden)]
pub fn chain_lines(chains: &[OpenChain]) -> Vec<String> {
    let line = |c: &OpenChain| {
        let [a, b] = c.ends.map(|p| point(p, c.length));
        format!(
            "a boundary chain of {} does not close, from {a} to {b}: {}",
            counted(c.edges, "edge"),
            c.reason.text()
        )
    };
    let mut lines: Vec<String> = chains.iter().take(MOST_CHAINS).map(line).collect();
    if chains.len() > MOST_CHAINS {
        lines.push(format!(
            "{} more boundary chains do not close",
            chains.len() - MOST_CHAINS
        ));
    }
    lines
}

/// The summary of a fill: defects, a line for each region if `with_regions`, the holes that were not closed by a level set, and numbers of
/// holes by outcome.
pub fn summary_lines(report: &FillReport, with_regions: bool) -> Vec<String> {
    let mut lines = defect_lines(&report.input.defects);
    lines.extend(chain_lines(&report.input.open_chains));
    let (small, solved): (Vec<_>, Vec<_>) = report.regions.iter().partition(|r| !r.has_surface());
    if with_regions {
        lines.extend(solved.into_iter().map(region_lines));
    }
    if !small.is_empty() {
        let holes: usize = small.iter().map(|r| r.holes.len()).sum();
        let faces: usize = small.iter().map(|r| r.new_faces).sum();
        lines.push(format!(
            "{holes} small holes and sides of seams: closed with {faces} faces between rim vertices"
        ));
    }
    lines.extend(reason_lines(report));
    if !with_regions {
        lines.extend(weighed_lines(report, None));
    }
    lines.push(tally_line(report));
    lines
}

/// The holes that were not closed by a level set, grouped by outcome and reason.
#[doc(hidden)]
pub fn reason_lines(report: &FillReport) -> Vec<String> {
    let mut reasons: Vec<(String, String, Vec<HoleId>)> = Vec::new();
    let mut places: HashMap<(String, String), usize> = HashMap::new();
    let few_edges = HoleOutcome::Closed(Closure::RimTriangles(NotSmooth::FewEdges));
    let wanted = report.holes.iter().filter(|h| h.outcome != few_edges);
    for h in wanted {
        let Some(why) = h.outcome.reason() else {
            continue;
        };
        let what = match &h.outcome {
            HoleOutcome::Closed(how) => format!("closed by {}", with_article(how)),
            open => open.name().to_owned(),
        };
        let place = *places
            .entry((what.clone(), why.clone()))
            .or_insert_with(|| {
                reasons.push((what, why, Vec::new()));
                reasons.len() - 1
            });
        reasons[place].2.push(h.hole.id);
    }
    let mut lines: Vec<String> = reasons
        .iter()
        .take(MOST_REASONS)
        .map(|(what, why, ids)| format!("{} {what}: {why}", named_holes(ids)))
        .collect();
    if reasons.len() > MOST_REASONS {
        let more: usize = reasons[MOST_REASONS..].iter().map(|r| r.2.len()).sum();
        lines.push(format!(
            "{more} more holes without a smooth surface, or open"
        ));
    }
    lines
}

/// The patches that were weighed with the mirror image of the mesh, one line for each.
#[doc(hidden)]
pub fn weighed_lines(report: &FillReport, unit: Option<Unit>) -> Vec<String> {
    let is_weighed = |r: &&RegionReport| r.counterpart.as_ref().is_some_and(|c| c.weight.is_some());
    let regions = report.regions.iter().filter(is_weighed);
    let line = |r: &RegionReport| {
        let text = counterpart_text(r, unit)?;
        Some(format!("{} {text}", named_holes(&r.holes)))
    };
    regions.filter_map(line).collect()
}

/// Numbers of holes by outcome, in one line.
pub fn tally_line(report: &FillReport) -> String {
    let tally = report.tally();
    let (all, closed) = (report.holes.len(), tally.closed);
    let mut line = match all {
        0 => "no holes".to_owned(),
        _ if closed == all => every_hole(all, ["is", "are"], "closed"),
        _ => format!("{closed} of {} closed", counted(all, "hole")),
    };
    let ways = tally.ways();
    if !ways.is_empty() {
        line += &format!(" ({})", ways.join(", "));
    }
    for (count, what) in [
        (tally.left, "left open"),
        (tally.open, "could not be closed"),
    ] {
        if count > 0 {
            line += &format!(", {count} {what}");
        }
    }
    line += &match tally.open_chains {
        0 => String::new(),
        n => format!(", {}", open_chains(n)),
    };
    line += &match (closed, tally.intersecting_patches) {
        (0, _) => String::new(),
        (_, 0) => "; no patch intersects other faces".to_owned(),
        (_, 1) => "; 1 patch intersects other faces".to_owned(),
        (_, n) => format!("; {n} patches intersect other faces"),
    };
    // Archived reports have no run times.
    match report.seconds {
        0.0 => line,
        seconds => line + &format!("; {seconds:.2} s"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::counts::singular;
    use super::*;

    #[test]
    fn long_lists_of_numbers_are_ranges_and_end() {
        assert_eq!(ranges(&[1_usize, 2, 4, 5, 6, 9]), "1, 2, 4-6, 9");
        assert_eq!(ranges(&(1..=20_000_usize).collect::<Vec<_>>()), "1-20000");
        let odd: Vec<usize> = (0..100).map(|i| 2 * i + 1).collect();
        assert!(ranges(&odd).ends_with("47 and 76 more"), "{}", ranges(&odd));
        assert_eq!(joined(&[3, 7].map(HoleId::from)), "3+7");
        let odd: Vec<HoleId> = odd.into_iter().map(HoleId::from).collect();
        assert!(joined(&odd).ends_with("+23 and 88 more"));
    }

    #[test]
    fn nouns_agree_with_their_numbers() {
        assert_eq!(counted(1, "step"), "1 step");
        assert_eq!(counted(0, "step"), "0 steps");
        assert_eq!(counted(2, "new vertex"), "2 new vertices");
        let of = |small_components, duplicate_vertices| Defects {
            small_components,
            duplicate_vertices,
            ..Defects::default()
        };
        let one = [
            "1 vertex at the position of an earlier one",
            "1 component of one or two triangles",
        ];
        assert_eq!(defect_lines(&of(1, 1)), one);
        assert_eq!(
            defect_lines(&of(2, 0)),
            ["2 components of one or two triangles"]
        );
        let turned = singular("edges whose two faces have opposite orientations");
        assert!(turned.starts_with("edge whose two faces"));
    }
}
