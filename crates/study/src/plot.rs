//! Draws the charts and level lines of a report as one SVG.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axis::ChartAxis;
use super::report::{Chart, Curve, Levels, Panel, StudyReport};

/// Size of a panel, in pixels.
const PANEL: (u32, u32) = (560, 380);
/// Width of a chart's legend, in pixels.
const LEGEND: u32 = 165;
/// Number of panels in a row.
const COLUMNS: usize = 3;
/// Colours that can be distinguished in print and by colour-blind readers (Okabe and Ito).
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(120, 120, 120),
    RGBColor(0, 0, 0),
];

/// Most points of a curve that get markers.
const MOST_MARKERS: usize = 16;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn Error>>;

/// Draws a report's panels into one SVG.
///
/// # Errors
/// When there is nothing to draw, or the drawing library refuses the values.
pub fn to_svg(report: &StudyReport) -> Result<String, Box<dyn Error>> {
    if report.panels.is_empty() {
        return Err("the experiment has nothing to draw".into());
    }
    let columns = report.panels.len().min(COLUMNS);
    let rows = report.panels.len().div_ceil(columns);
    let mut svg = String::new();
    {
        let size = (PANEL.0 * columns as u32, PANEL.1 * rows as u32);
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        for (area, panel) in root
            .split_evenly((rows, columns))
            .iter()
            .zip(&report.panels)
        {
            match panel {
                Panel::Chart(chart) => draw_chart(area, chart)?,
                Panel::Levels(levels) => draw_levels(area, levels)?,
            }
        }
        root.present()?;
    }
    Ok(svg)
}

/// The coordinate of a value along an axis; none if a logarithmic axis cannot show it.
fn coordinate(value: f64, logarithmic: bool) -> Option<f64> {
    let v = if logarithmic { value.log10() } else { value };
    v.is_finite().then_some(v)
}

fn drawn_points(chart: &Chart, curve: &Curve) -> Vec<(f64, f64)> {
    let [lx, ly] = chart.logarithmic;
    let points = curve.points.iter();
    points
        .filter_map(|&(x, y)| Some((coordinate(x, lx)?, coordinate(y, ly)?)))
        .collect()
}

/// The range of values with a margin; 0 to 1 if there are none.
fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return 0.0..1.0;
    }
    let margin = if high > low {
        0.05 * (high - low)
    } else {
        0.5 * high.abs().max(1e-3)
    };
    low - margin..high + margin
}

fn draw_chart(area: &Area, chart: &Chart) -> Drawn {
    let curves: Vec<Vec<(f64, f64)>> = chart
        .curves
        .iter()
        .map(|c| drawn_points(chart, c))
        .collect();
    let xs = range(curves.iter().flatten().map(|p| p.0));
    let ys = range(curves.iter().flatten().map(|p| p.1));
    let [lx, ly] = chart.logarithmic;
    let mut context = ChartBuilder::on(area)
        .caption(&chart.title, ("sans-serif", 18))
        .margin(12)
        .margin_right(if chart.curves.len() > 1 {
            LEGEND + 12
        } else {
            12
        })
        .x_label_area_size(42)
        .y_label_area_size(72)
        .build_cartesian_2d(
            ChartAxis::new(xs.clone(), lx),
            ChartAxis::new(ys.clone(), ly),
        )?;
    context
        .configure_mesh()
        .light_line_style(WHITE)
        .x_labels(6)
        .y_labels(7)
        .x_desc(chart.axes[0])
        .y_desc(chart.axes[1])
        .label_style(("sans-serif", 13))
        .axis_desc_style(("sans-serif", 14))
        .draw()?;
    for (k, (curve, points)) in chart.curves.iter().zip(curves).enumerate() {
        let colour = COLOURS[k % COLOURS.len()];
        if curve.dots {
            let dots = points.into_iter();
            context.draw_series(dots.map(|p| Circle::new(p, 3, colour.stroke_width(1))))?;
        } else {
            if points.len() <= MOST_MARKERS {
                let markers = points.iter().map(|p| Circle::new(*p, 3, colour.filled()));
                context.draw_series(markers)?;
            }
            context.draw_series(LineSeries::new(points, colour.stroke_width(2)))?;
        }
    }
    if let Some(order) = chart.order {
        let (corners, place) = slope(&xs, &ys, order);
        context.draw_series([PathElement::new(corners, BLACK.mix(0.6).stroke_width(1))])?;
        let style = ("sans-serif", 13).into_text_style(area);
        context.draw_series([Text::new(format!("order {order}"), place, style)])?;
    }
    draw_legend(area, chart)
}

/// The triangle that shows the slope of an order, at the lower right of a chart with logarithmic axes, and the place of its name.
fn slope(xs: &Range<f64>, ys: &Range<f64>, order: f64) -> (Vec<(f64, f64)>, (f64, f64)) {
    let (width, height) = (xs.end - xs.start, ys.end - ys.start);
    // At most a quarter of the chart's height.
    let run = (0.18 * width).min(0.25 * height / order);
    let (left, low) = (xs.start + 0.64 * width, ys.start + 0.06 * height);
    let (right, high) = (left + run, low + order * run);
    let corners = vec![(left, low), (right, low), (right, high), (left, low)];
    (corners, (right + 0.015 * width, low + 0.5 * (high - low)))
}

/// Draws the names of the curves to the right of the chart.
fn draw_legend(area: &Area, chart: &Chart) -> Drawn {
    if chart.curves.len() < 2 {
        return Ok(());
    }
    let left = area.dim_in_pixel().0 as i32 - LEGEND as i32;
    let style = ("sans-serif", 12).into_text_style(area);
    for (k, curve) in chart.curves.iter().enumerate() {
        let y = 52 + 20 * k as i32;
        let colour = COLOURS[k % COLOURS.len()];
        if curve.dots {
            area.draw(&Circle::new((left + 9, y), 3, colour.stroke_width(1)))?;
        } else {
            area.draw(&PathElement::new(
                [(left, y), (left + 18, y)],
                colour.stroke_width(2),
            ))?;
        }
        area.draw_text(&curve.name, &style, (left + 24, y - 6))?;
    }
    Ok(())
}

fn draw_levels(area: &Area, levels: &Levels) -> Drawn {
    let ([x, y], side) = levels.square;
    // Centre a square picture in a panel that is wider than high.
    let (width, height) = area.dim_in_pixel();
    let spare = width.saturating_sub(height) / 2;
    let mut context = ChartBuilder::on(area)
        .caption(&levels.title, ("sans-serif", 18))
        .margin(12)
        .margin_left(12 + spare)
        .margin_right(12 + spare)
        .build_cartesian_2d(x..x + side, y..y + side)?;
    let frame = [
        (x, y),
        (x + side, y),
        (x + side, y + side),
        (x, y + side),
        (x, y),
    ];
    context.draw_series(LineSeries::new(frame, BLACK.mix(0.4)))?;
    let path = |s: &[[f64; 2]; 2], style: ShapeStyle| {
        PathElement::new(s.map(|[x, y]| (x, y)).to_vec(), style)
    };
    let thin = BLACK.mix(0.35).stroke_width(1);
    context.draw_series(levels.thin.iter().map(|s| path(s, thin)))?;
    let bold = COLOURS[1].stroke_width(2);
    context.draw_series(levels.bold.iter().map(|s| path(s, bold)))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_and_level_lines_are_drawn() {
        let mut report = StudyReport::new("x", "x");
        assert!(to_svg(&report).is_err());
        report.panels.push(Panel::Chart(Chart {
            title: "A chart".to_owned(),
            axes: ["h", "error"],
            logarithmic: [true, true],
            order: Some(2.0),
            curves: vec![
                Curve {
                    name: "a curve".to_owned(),
                    points: vec![(0.1, 1e-2), (0.05, 2.5e-3), (0.0, 0.0)],
                    dots: false,
                },
                Curve {
                    name: "dots".to_owned(),
                    points: vec![(0.1, 1e-2)],
                    dots: true,
                },
            ],
        }));
        report.panels.push(Panel::Levels(Levels {
            title: "A square".to_owned(),
            square: ([0.0; 2], 1.0),
            thin: vec![[[0.1, 0.1], [0.9, 0.9]]],
            bold: vec![],
        }));
        let svg = to_svg(&report).expect("a plate");
        for text in [
            "A chart",
            "A square",
            "a curve",
            "<circle",
            "<polyline",
            "order 2",
        ] {
            assert!(svg.contains(text), "{text}");
        }
        // A marker for each point of the curve that a logarithmic axis can show, and one dot.
        assert_eq!(
            svg.matches("<circle").count(),
            2 + 1 + 1,
            "with the legend's dot"
        );
    }
}
