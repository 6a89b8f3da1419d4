//! Reads the thresholds of an experimental build from the environment variable `ISOMEND_TUNING`.

use std::process;
use std::sync::OnceLock;

use super::Tunable;

const VARIABLE: &str = "ISOMEND_TUNING";

/// The kinds of numbers that a threshold may be.
pub trait TunedNumber: Copy {
    /// The number nearest to a value of an experiment.
    fn of(value: f64) -> Self;
}

macro_rules! numbers {
    ($($kind:ty)*) => {
        $(impl TunedNumber for $kind {
            #[allow(trivial_numeric_casts, clippy::unnecessary_cast)]
            fn of(value: f64) -> Self {
                value as Self
            }
        })*
    };
}

numbers!(f64 i32 u32 u64 usize);

impl<T: TunedNumber> Tunable<T> {
    /// The value of `ISOMEND_TUNING`, else the chosen one. If the variable cannot be parsed the process ends, so that no experiment
    /// runs with other values than it asked for. Names are checked by `scripts/sweep.py`, which finds them in the sources.
    pub fn get(self) -> T {
        static READ: OnceLock<Vec<(String, f64)>> = OnceLock::new();
        let values = READ.get_or_init(|| {
            let text = std::env::var(VARIABLE).unwrap_or_default();
            parsed(&text).unwrap_or_else(|error| {
                eprintln!("{VARIABLE}: {error}");
                process::exit(2)
            })
        });
        let asked = values.iter().find(|(name, _)| name == self.name);
        asked.map_or(self.chosen, |(_, value)| T::of(*value))
    }
}

/// The values of a flat JSON object of numbers.
fn parsed(text: &str) -> Result<Vec<(String, f64)>, String> {
    let text = text.trim();
    if text.is_empty() {
        return Ok(Vec::new());
    }
    let inner = text.strip_prefix('{').and_then(|t| t.strip_suffix('}'));
    let inner = inner.ok_or("not a JSON object such as {\"fill.bent\": 5.6}")?;
    let entries = inner.split(',').filter(|e| !e.trim().is_empty());
    let value_of = |entry: &str| {
        let (name, value) =
            (entry.split_once(':')).ok_or_else(|| format!("no value in {entry}"))?;
        let name = name.trim().trim_matches('"');
        let value: f64 = value.trim().parse().map_err(|e| format!("{name}: {e}"))?;
        Ok((name.to_string(), value))
    };
    entries.map(value_of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_checked() {
        let values = parsed("{\"fill.bent\": 5.6, \"fill.most_attempts\": 3}").unwrap();
        let expected = [("fill.bent", 5.6), ("fill.most_attempts", 3.0)];
        assert_eq!(
            values,
            expected.map(|(name, value)| (name.to_owned(), value))
        );
        for text in ["fill.bent", "{\"fill.bent\": x}", "{\"fill.bent\"}"] {
            assert!(parsed(text).is_err(), "{text}");
        }
        assert!(parsed("").unwrap().is_empty() && parsed("{}").unwrap().is_empty());
    }
}
