//! Reads the thresholds of an experimental build from the environment variable `ISOMEND_TUNING`.

use std::process;
use std::sync::OnceLock;

use super::Tuning;

const VARIABLE: &str = "ISOMEND_TUNING";

/// The thresholds, with the values that `ISOMEND_TUNING` changes. If it cannot be parsed the process ends, so that no experiment
/// runs with other values than it asked for.
pub fn tuning() -> &'static Tuning {
    static READ: OnceLock<Tuning> = OnceLock::new();
    READ.get_or_init(|| {
        let text = std::env::var(VARIABLE).unwrap_or_default();
        changed(&text).unwrap_or_else(|error| {
            eprintln!("{VARIABLE}: {error}");
            process::exit(2)
        })
    })
}

/// The chosen thresholds, with the values of a flat JSON object of numbers replaced.
fn changed(text: &str) -> Result<Tuning, String> {
    let mut tuning = Tuning::CHOSEN;
    let text = text.trim();
    if text.is_empty() {
        return Ok(tuning);
    }
    let inner = text.strip_prefix('{').and_then(|t| t.strip_suffix('}'));
    let inner = inner.ok_or("not a JSON object such as {\"fill.bent\": 5.6}")?;
    for entry in inner.split(',').filter(|e| !e.trim().is_empty()) {
        let (name, value) = entry
            .split_once(':')
            .ok_or_else(|| format!("no value in {entry}"))?;
        let name = name.trim().trim_matches('"');
        let value: f64 = value.trim().parse().map_err(|e| format!("{name}: {e}"))?;
        if !tuning.set(name, value) {
            return Err(format!("no threshold has the name {name}"));
        }
    }
    Ok(tuning)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_values_are_checked() {
        let tuning = changed("{\"fill.bent\": 5.6, \"fill.most_attempts\": 3}").unwrap();
        assert_eq!((tuning.fill.bent, tuning.fill.most_attempts), (5.6, 3));
        for text in [
            "fill.bent",
            "{\"fill.bend\": 1}",
            "{\"fill.bent\": x}",
            "{\"bent\": 1}",
        ] {
            assert!(changed(text).is_err(), "{text}");
        }
        assert!(changed("").is_ok() && changed("{}").is_ok());
    }
}
