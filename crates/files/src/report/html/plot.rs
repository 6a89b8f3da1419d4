//! Plots of the energy and the update of each step of a region's flow, as SVG with colours from the page's style sheet.

use std::fmt::Write;

use super::{add, listed, number};
use isomend_core::fill::RegionReport;
use isomend_core::flow::StepRecord;

/// Width and height of a plot, in SVG units.
const SIZE: (f64, f64) = (460.0, 220.0);
/// Left margin, with the labels of the vertical axis.
const LEFT: f64 = 58.0;
const RIGHT: f64 = 12.0;
/// Top margin, with the title.
const TOP: f64 = 22.0;
/// Bottom margin, with the labels of the horizontal axis.
const BOTTOM: f64 = 34.0;
/// If the largest value exceeds the smallest positive one by this factor, the vertical axis is logarithmic.
const WIDE: f64 = 20.0;

/// A block of plots for each region that a flow was run for; only the first block is open.
pub fn plots(regions: &[RegionReport]) -> String {
    let mut out = String::new();
    let flowed = regions
        .iter()
        .filter(|r| r.levels.iter().any(|l| !l.flow.steps.is_empty()));
    for region in flowed {
        let noun = if region.holes.len() == 1 {
            "hole"
        } else {
            "holes"
        };
        add!(
            out,
            "<details class=\"plots\" data-region=\"{id}\"><summary>Region {id}: {noun} {}</summary><div class=\"pair\">",
            listed(&region.holes),
            id = region.id
        );
        let energy: Curve = ("energy", "line", |s: &StepRecord| s.energy);
        plot(&mut out, region, "Energy before each step", &[energy]);
        let largest: Curve = ("largest", "line", |s: &StepRecord| s.update);
        let mean: Curve = ("rms", "line second", |s: &StepRecord| s.rms_update);
        plot(
            &mut out,
            region,
            "Residual: update of each step in voxels",
            &[largest, mean],
        );
        out.push_str("</div></details>");
    }
    out
}

/// A curve: its name, its class in the style sheet, and the value of a step.
type Curve = (&'static str, &'static str, fn(&StepRecord) -> f64);

/// Draws a plot of curves over the steps of all levels, with a vertical line where a level starts.
fn plot(out: &mut String, region: &RegionReport, title: &str, curves: &[Curve]) {
    let steps = region.levels.iter().flat_map(|l| &l.flow.steps);
    let values = steps.flat_map(|s| curves.iter().map(|c| c.2(s)));
    let axis = Axis::new(values);
    let count: usize = region.levels.iter().map(|l| l.flow.steps.len()).sum();
    let x = |step: usize| LEFT + (step as f64 + 0.5) / count as f64 * (SIZE.0 - LEFT - RIGHT);
    add!(
        out,
        "<figure><svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{title}\"><text class=\"title\" x=\"{LEFT}\" \
         y=\"13\">{title}</text>",
        SIZE.0,
        SIZE.1
    );
    for (value, label) in axis.ticks() {
        let y = axis.place(value);
        add!(
            out,
            "<line class=\"grid\" x1=\"{LEFT}\" x2=\"{}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/><text class=\"y\" x=\"{}\" \
             y=\"{:.1}\">{label}</text>",
            SIZE.0 - RIGHT,
            LEFT - 6.0,
            y + 3.5
        );
    }
    let mut first = 0;
    for level in &region.levels {
        let steps = &level.flow.steps;
        let start = x(first) - 0.5 * (x(1) - x(0));
        add!(
            out,
            "<line class=\"level\" x1=\"{start:.1}\" x2=\"{start:.1}\" y1=\"{TOP}\" y2=\"{}\"/><text class=\"x\" \
             x=\"{:.1}\" y=\"{}\">voxel {}</text>",
            SIZE.1 - BOTTOM + 4.0,
            start + 3.0,
            SIZE.1 - BOTTOM + 15.0,
            number(level.voxel)
        );
        for (name, class, value) in curves {
            let points: Vec<(usize, f64)> = (first..).zip(steps.iter().map(value)).collect();
            curve(out, &points, class, name, first, &axis, &x);
        }
        first += steps.len();
    }
    legend(out, curves);
    out.push_str("</svg></figure>");
}

/// Draws the curve of one level, with a dot and a tooltip at each step. `first` is the number of the level's first step.
fn curve(
    out: &mut String,
    points: &[(usize, f64)],
    class: &str,
    name: &str,
    first: usize,
    axis: &Axis,
    x: &dyn Fn(usize) -> f64,
) {
    let drawn = || points.iter().filter(|(_, v)| axis.shows(*v));
    let line: Vec<String> = drawn()
        .map(|(i, v)| format!("{:.1},{:.1}", x(*i), axis.place(*v)))
        .collect();
    add!(
        out,
        "<polyline class=\"{class}\" points=\"{}\"/>",
        line.join(" ")
    );
    for (i, v) in drawn() {
        add!(
            out,
            "<circle class=\"{class}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"2.4\"><title>step {} on this grid: {name} {}</title>\
             </circle>",
            x(*i),
            axis.place(*v),
            i - first + 1,
            number(*v)
        );
    }
}

/// Writes the name of the horizontal axis, and the names of the curves if there are several.
fn legend(out: &mut String, curves: &[Curve]) {
    add!(
        out,
        "<text class=\"axis\" x=\"{}\" y=\"{}\">steps of the flow</text>",
        SIZE.0 - RIGHT,
        SIZE.1 - 4.0
    );
    if curves.len() < 2 {
        return;
    }
    let mut x = SIZE.0 - RIGHT;
    for (name, class, _) in curves.iter().rev() {
        add!(out, "<text class=\"axis\" x=\"{x}\" y=\"13\">{name}</text>");
        x -= 5.5 * name.len() as f64 + 6.0;
        add!(
            out,
            "<polyline class=\"{class}\" points=\"{},9 {x},9\"/>",
            x - 18.0
        );
        x -= 30.0;
    }
}

/// The vertical axis. `low` and `high` are its ends, or their decimal logarithms if it is logarithmic.
struct Axis {
    low: f64,
    high: f64,
    logarithmic: bool,
}

impl Axis {
    fn new(values: impl Iterator<Item = f64>) -> Self {
        let (mut low, mut high, mut positive) = (f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY);
        for v in values.filter(|v| v.is_finite()) {
            (low, high) = (low.min(v), high.max(v));
            if v > 0.0 {
                positive = positive.min(v);
            }
        }
        if !low.is_finite() {
            return Self {
                low: 0.0,
                high: 1.0,
                logarithmic: false,
            };
        }
        let logarithmic = high > 0.0 && high > WIDE * positive;
        if logarithmic {
            let low = positive.log10().floor();
            let high = high.log10().ceil().max(low + 1.0);
            return Self {
                low,
                high,
                logarithmic,
            };
        }
        let margin = (0.08 * (high - low))
            .max(1e-3 * high.abs())
            .max(f64::MIN_POSITIVE);
        Self {
            low: low - margin,
            high: high + margin,
            logarithmic,
        }
    }

    /// Whether a value can be drawn.
    fn shows(&self, value: f64) -> bool {
        value.is_finite() && (!self.logarithmic || value > 0.0)
    }

    /// The vertical position of a value in the plot.
    fn place(&self, value: f64) -> f64 {
        let at = if self.logarithmic {
            value.log10()
        } else {
            value
        };
        let part = (at - self.low) / (self.high - self.low);
        SIZE.1 - BOTTOM - part * (SIZE.1 - BOTTOM - TOP)
    }

    /// Values and labels of the grid lines: powers of ten, or multiples of 1, 2 or 5 times a power of ten.
    fn ticks(&self) -> Vec<(f64, String)> {
        let span = self.high - self.low;
        if self.logarithmic {
            let every = (span / 5.0).ceil().max(1.0);
            let marks = (0..).map(|i| self.low + f64::from(i) * every);
            return marks
                .take_while(|e| *e <= self.high + 1e-9)
                .map(|e| (10f64.powf(e), power(e)))
                .collect();
        }
        let rough = span / 4.0;
        let unit = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .map(|m| m * unit)
            .into_iter()
            .find(|s| *s >= rough)
            .unwrap_or(10.0 * unit);
        let first = (self.low / step).ceil();
        let marks = (0..12).map(|i| (first + f64::from(i)) * step);
        marks
            .take_while(|v| *v <= self.high)
            .map(|v| (v, short(v)))
            .collect()
    }
}

/// A number without trailing zeros.
fn short(value: f64) -> String {
    let text = number(value);
    if text.contains('.') && !text.contains('e') {
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    text
}

/// A power of ten, with its exponent raised if it is not one of 1, 10 and 100.
fn power(exponent: f64) -> String {
    let e = exponent as i32;
    if (0..3).contains(&e) {
        return 10i32.pow(e as u32).to_string();
    }
    let sign = if e < 0 { "−" } else { "" };
    format!(
        "10<tspan dy=\"-4\" font-size=\"8\">{sign}{}</tspan>",
        e.abs()
    )
}
