//! Axes of charts: linear, or logarithmic with ticks at powers of ten and, on short axes, at 2 and 5 times these.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;

use super::report::short_number;

/// Most decades of a logarithmic axis that has ticks between powers of ten.
const FEW_DECADES: f64 = 2.5;

/// An axis of a chart. Values of a logarithmic axis are decimal logarithms.
pub struct ChartAxis {
    /// The values at its ends.
    range: Range<f64>,
    /// Whether its values are decimal logarithms.
    logarithmic: bool,
}

impl ChartAxis {
    /// An axis over a range of values.
    pub fn new(range: Range<f64>, logarithmic: bool) -> Self {
        Self { range, logarithmic }
    }

    /// The ticks of a logarithmic axis, as decimal logarithms.
    fn decades(&self) -> Vec<f64> {
        let short = self.range.end - self.range.start < FEW_DECADES;
        let steps: &[f64] = if short { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let powers = self.range.start.floor() as i32..=self.range.end.ceil() as i32;
        let ticks =
            powers.flat_map(|power| steps.iter().map(move |s| f64::from(power) + s.log10()));
        ticks.filter(|tick| self.range.contains(tick)).collect()
    }
}

impl Ranged for ChartAxis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        RangedCoordf64::from(self.range.clone()).map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match self.logarithmic {
            true => self.decades(),
            false => RangedCoordf64::from(self.range.clone()).key_points(hint),
        }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for ChartAxis {
    fn format_ext(&self, value: &f64) -> String {
        match self.logarithmic {
            true => power(10f64.powf(*value)),
            false => plain(*value),
        }
    }
}

/// A tick of a logarithmic axis: one digit, with its power of ten where it is far from 1.
fn power(value: f64) -> String {
    match (0.000_99..9_999.0).contains(&value) {
        // One digit, wherever it stands.
        true => format!("{}", (value * 1e6).round() / 1e6),
        false => format!("{value:.0e}"),
    }
}

/// A tick of a linear axis, without zeros at its end.
fn plain(value: f64) -> String {
    let text = short_number(if value.abs() < 1e-12 { 0.0 } else { value });
    let (digits, exponent) = match text.split_once('e') {
        Some((digits, exponent)) => (digits, format!("e{exponent}")),
        None => (text.as_str(), String::new()),
    };
    let digits = match digits.contains('.') {
        true => digits.trim_end_matches('0').trim_end_matches('.'),
        false => digits,
    };
    format!("{digits}{exponent}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_of_logarithmic_axes_are_powers_of_ten() {
        let labels = |low: f64, high: f64| -> Vec<String> {
            let axis = ChartAxis::new(low.log10()..high.log10(), true);
            let ticks = axis.key_points(7);
            ticks.iter().map(|tick| axis.format_ext(tick)).collect()
        };
        assert_eq!(
            labels(9e-7, 2e-2),
            ["1e-6", "1e-5", "1e-4", "0.001", "0.01"]
        );
        assert_eq!(
            labels(0.0035, 0.14),
            ["0.005", "0.01", "0.02", "0.05", "0.1"]
        );
        assert_eq!(labels(15.0, 70.0), ["20", "50"]);
    }

    #[test]
    fn ticks_of_linear_axes_have_no_zeros_at_their_end() {
        let axis = ChartAxis::new(0.0..0.5, false);
        assert_eq!(axis.format_ext(&0.25), "0.25");
        assert_eq!(axis.format_ext(&0.0), "0");
        assert_eq!(axis.map(&0.25, (0, 100)), 50);
    }
}
