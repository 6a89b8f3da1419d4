//! Messages on jobs: the plan of a dry run, lines on regions while a job runs, and the summary after it.

use isomend::io::{Format, Precision};
use isomend::job::{JobPlan, JobResult, OperationReport, Work, WorkPlan};
use isomend::report::{
    Standing, counted, cut_out, faired_measures, faired_part, joined_holes, kept_object,
    left_holes, length_beside, level_lines, number, plan_lines, point, reason_lines,
    repair_lines_in, tally_line, timed,
};
use isomend::{
    FairPlan, FairReport, FillReport, HoleOutcome, RegionReport, RepairReport, RestoreReport, Unit,
};

use super::console::{self, Console};
use super::outcome;

/// Most open holes that get a line each.
const MOST_OPEN: usize = 30;
/// Most positions of a kind of defect in a line.
const MOST_PLACES: usize = 20;

/// The plan of a job as text.
pub fn plan(plan: &JobPlan) -> String {
    let unit = plan.spec.deliverables.unit;
    match &plan.plan {
        WorkPlan::Fair(plan) => fair_plan(plan, unit),
        WorkPlan::Copy => format!(
            "{} and {} would be written unchanged\n",
            counted(plan.size[0], "vertex"),
            counted(plan.size[1], "face")
        ),
        WorkPlan::Restore(plan) => cut_plan(&plan.cut) + &lines(plan_lines(&plan.fill, unit)),
        WorkPlan::Repair { before, fill } => before.line() + "\n" + &lines(plan_lines(fill, unit)),
        WorkPlan::Fill(fill) => lines(plan_lines(fill, unit)),
    }
}

fn lines(lines: Vec<String>) -> String {
    lines.join("\n") + "\n"
}

fn cut_plan(cut: &RestoreReport) -> String {
    let [marked, removed] = [cut.marked_faces, cut.removed_faces];
    let cut_out = format!(
        "{} marked, {removed} would be cut out",
        counted(marked, "face")
    );
    lines([cut_out].into_iter().chain(joined_holes(cut)).collect())
}

fn fair_plan(report: &FairPlan, unit: Option<Unit>) -> String {
    let what = match report.whole {
        true => "the whole surface would be replaced".to_owned(),
        false => format!(
            "{} marked, {} would be cut out and replaced",
            counted(report.marked_faces, "face"),
            report.removed_faces
        ),
    };
    let measures = format!(
        "features narrower than {} would be removed, time {}, voxel {}",
        Unit::text(unit, report.strength),
        number(report.time),
        Unit::text(unit, report.voxel)
    );
    let kept = report.kept_objects.iter().map(kept_object);
    lines([measures, what].into_iter().chain(kept).collect())
}

/// Prints the result of a job, the summary line last. `name` is put in front of warnings.
pub fn done(done: &JobResult, name: &str, console: &Console) {
    match &done.extent {
        OperationReport::Faired(report) => return faired(report, done, console),
        OperationReport::Copied => {
            let [vertices, faces] = done.size;
            let file = written(done);
            let [vertices, faces] = [counted(vertices, "vertex"), counted(faces, "face")];
            return console.say(&format!("{file}{vertices}, {faces} written"));
        }
        OperationReport::Region(cut) => {
            console.say(&cut_out(cut.marked_faces, cut.removed_faces));
            joined_holes(cut).iter().for_each(|line| console.note(line));
        }
        _ => {}
    }
    let report = &done.report;
    let unit = done.spec.deliverables.unit;
    // Holes with higher numbers were opened by the repair, so options cannot name them.
    let chosen = match &done.extent {
        OperationReport::Repaired(report) => report.before.as_ref().map_or(0, |v| v.holes),
        _ => usize::MAX,
    };
    let is_verbose = console.is_verbose();
    for line in outcome::remarks(report) {
        console.note(&line);
    }
    for line in outcome::lines(done, chosen, is_verbose, console::error_width()) {
        console.say(&line);
    }
    // What is left open is said above, with the option that changes it.
    let said = left_holes(report).len();
    let reasons = reason_lines(report).into_iter();
    let reasons = reasons.filter(|line| said == 0 || !line.contains(" left open: "));
    let levels = report.regions.iter().flat_map(|r| level_lines(r, unit));
    for line in reasons.chain(levels) {
        console.detail(&line);
    }
    for line in done.delivery_lines() {
        console.say(&line);
    }
    for line in done.delivery_warnings() {
        console.warn(&format!("{name}{line}"));
    }
    still_open(report, name, console);
    let file = written(done);
    let verdict = console::verdict(Standing::of_fill(report), &tally_line(report));
    match &done.extent {
        OperationReport::Repaired(report) => {
            console.say(&verdict);
            repaired(report, &file, unit, console);
        }
        OperationReport::Holes
            if report.holes.is_empty() && report.input.open_chains.is_empty() =>
        {
            let what = match is_rounded(done) {
                true => "no holes: only the positions are rounded",
                false => "no holes: vertices and faces are copied unchanged",
            };
            console.say(&(file + what));
        }
        _ => console.say(&(file + &verdict)),
    }
}

/// Warns of the holes that could not be closed; without `-v` at most [`MOST_OPEN`].
fn still_open(report: &FillReport, name: &str, console: &Console) {
    let failed = report.holes.iter().filter_map(|hole| match &hole.outcome {
        HoleOutcome::Open(why) => Some((hole.hole.id, why)),
        _ => None,
    });
    let most = if console.is_verbose() {
        usize::MAX
    } else {
        MOST_OPEN
    };
    for (id, why) in failed.clone().take(most) {
        let why = super::as_options(&why.to_string());
        console.warn(&format!("{name}hole {id} is still open: {why}"));
    }
    let more = failed.count().saturating_sub(most);
    if more > 0 {
        let holes = counted(more, "more hole");
        console.warn(&format!("{name}{holes} still open (-v lists them)"));
    }
}

/// Whether the positions were rounded to the 32-bit floats of the output's format.
fn is_rounded(done: &JobResult) -> bool {
    let output = done.spec.output.as_ref();
    output.is_some_and(|o| o.format.is_single() && !(o.ascii && o.format == Format::Stl))
        && Precision::of(&done.mesh) == Precision::F64
}

/// The name of the written file, as the start of a line.
fn written(done: &JobResult) -> String {
    let output = done.spec.output.as_ref();
    output.map_or(String::new(), |o| format!("{}: ", o.place.name()))
}

/// Advice if walls that a repair made are too thin.
const FOIL: &str = "walls are too thin: --flat-base puts a sheet on a flat base, --wall makes walls thicker where there is room, and \
                    --min-wall sets how thin they may be";

/// Prints the report of a repair and the verdict on the written file.
fn repaired(report: &RepairReport, file: &str, unit: Option<Unit>, console: &Console) {
    if let Some(before) = &report.before {
        console.detail(&format!("before: {}", before.line()));
    }
    for line in repair_lines_in(report, unit) {
        console.say(&line);
    }
    let lost = lost_components(report);
    console.say(&match report.lost_faces {
        0 => "no face of the input was removed".to_owned(),
        1 => format!("1 face of the input was removed{lost}"),
        n => format!("{n} faces of the input were removed{lost}"),
    });
    if let Some(after) = &report.after {
        for defect in &after.defects {
            let places = defect.places.iter().take(MOST_PLACES);
            let places: Vec<String> = places.map(|p| point(*p, p.abs().max_element())).collect();
            let kind = defect.kind.text(defect.count);
            console.detail(&format!("{kind}: {}", places.join("; ")));
        }
        if !after.foils.is_empty() {
            console.say(FOIL);
        }
        let answer = Standing::of_verdict(after);
        let line = format!("{file}{}", console::verdict(answer, &after.line()));
        match answer {
            Standing::Yes => console.say(&line),
            _ => console.warn(&line),
        }
    }
}

/// The components of the input that were removed completely: their number and the range of their sizes.
fn lost_components(report: &RepairReport) -> String {
    let lost = report.lost_components;
    let (count, least, most) = (lost.count, lost.fewest_faces, lost.most_faces);
    match count {
        0 => String::new(),
        _ if least == most => format!(
            ", including {} of {}",
            counted(count, "component"),
            counted(most, "face")
        ),
        _ => format!(", including {count} components of {least} to {most} faces"),
    }
}

/// Prints the report of a fairing.
fn faired(report: &FairReport, done: &JobResult, console: &Console) {
    let unit = done.spec.deliverables.unit;
    let moved = |x: f64| {
        let text = length_beside(x, report.strength);
        unit.map_or(text.clone(), |unit| format!("{text} {unit}"))
    };
    match &report.objects[..] {
        [] => console.say(&faired_measures(report, unit)),
        objects => objects.iter().for_each(|object| {
            let measures = faired_measures(&object.report, unit);
            console.say(&format!("{}: {measures}", object.name));
        }),
    }
    let marks = matches!(done.spec.work, Work::Fair(Some(_), _));
    if let Some(line) = faired_part(report, marks) {
        console.say(&line);
    }
    if report.components_left > 0 {
        console.warn(&format!(
            "{} left unchanged, because the mesh also has open ones; mark to fair too",
            counted(report.components_left, "closed component")
        ));
    }
    for region in &done.report.regions {
        for line in level_lines(region, unit) {
            console.detail(&line);
        }
    }
    let mut line = format!(
        "{}moved by at most {}, root mean square {}",
        written(done),
        moved(report.moved_max),
        moved(report.moved_rms)
    );
    let intersecting: usize = done
        .report
        .regions
        .iter()
        .map(|r| r.intersecting_faces)
        .sum();
    if intersecting > 0 {
        line += &format!(
            "; {} intersecting others",
            counted(intersecting, "new face")
        );
    }
    if let Some(drift) = report.volume_drift() {
        line += &format!("; the volume changed by {:+.3} %", 100.0 * drift);
    }
    console.say(&line);
}

/// One line for a region that was faired.
pub fn faired_region_line(region: &RegionReport) -> String {
    let steps: usize = region.levels.iter().map(|l| l.flow.steps.len()).sum();
    let rims: Vec<String> = region.holes.iter().map(ToString::to_string).collect();
    let name = match rims.is_empty() {
        true => "whole surface".to_owned(),
        false => format!("inside rim {}", rims.join("+")),
    };
    let mut line = format!(
        "{name}: {}, {}, {}{}",
        counted(steps, "step"),
        counted(region.new_vertices, "vertex"),
        counted(region.new_faces, "face"),
        timed(region.seconds)
    );
    if region.intersecting_faces > 0 {
        line += &format!("; {} faces intersect others", region.intersecting_faces);
    }
    line
}
