//! Parsers of single command-line arguments. clap shows their messages after the name of the option.

use isomend::io::Format;

/// A positive whole number.
pub fn count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) | Err(_) => Err("a whole number from 1 is needed".to_owned()),
        Ok(n) => Ok(n),
    }
}

/// A positive whole number up to `most`.
pub fn count_to(text: &str, most: usize) -> Result<usize, String> {
    match count(text) {
        Ok(n) if n <= most => Ok(n),
        _ => Err(format!("a whole number from 1 to {most} is needed")),
    }
}

/// A number of threads.
pub fn threads(text: &str) -> Result<usize, String> {
    count_to(text, isomend::Control::MOST_THREADS)
}

/// A finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("a number is needed".to_owned()),
    }
}

/// A positive finite number.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a positive number is needed".to_owned()),
    }
}

/// A file format by its extension.
pub fn format(text: &str) -> Result<Format, String> {
    text.parse()
        .map_err(|error: isomend::io::IoError| error.to_string())
}

/// Hole numbers with commas between them.
pub fn ids(text: &str) -> Result<Vec<usize>, String> {
    separated(text, ',', HOLES)
}

/// Two or more hole numbers with plus signs between them.
pub fn bridge(text: &str) -> Result<Vec<usize>, String> {
    let ids = separated(text, '+', HOLES)?;
    let mut distinct = ids.clone();
    distinct.sort_unstable();
    distinct.dedup();
    if distinct.len() < 2 {
        return Err("two different holes are needed, such as 3+7".to_owned());
    }
    Ok(ids)
}

/// The numbers of two crease ends with a plus sign between them.
pub fn crease(text: &str) -> Result<Vec<usize>, String> {
    let ends = separated(text, '+', CREASE_ENDS)?;
    match ends[..] {
        [a, b] if a != b => Ok(ends),
        _ => Err("two different crease ends are needed, such as 1+2".to_owned()),
    }
}

/// The objects that numbers stand for, and the command that lists them.
type Numbered = [&'static str; 2];
const HOLES: Numbered = ["hole", "isomend inspect"];
const CREASE_ENDS: Numbered = ["crease end", "isomend inspect -v"];

/// Numbers from 1, with a separator between them.
fn separated(text: &str, separator: char, [what, list]: Numbered) -> Result<Vec<usize>, String> {
    text.split(separator)
        .map(|part| {
            count(part.trim()).map_err(|_| {
                format!(
                    "'{part}' is not a {what} number; use whole numbers from 1 with '{separator}' between them \
                     (`{list}` lists them)"
                )
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_are_lists_of_numbers() {
        assert_eq!(ids("3, 1"), Ok(vec![3, 1]));
        assert_eq!(ids("2"), Ok(vec![2]));
        assert_eq!(bridge("3+7+9"), Ok(vec![3, 7, 9]));
        for wrong in ["", "0", "1,,2", "-1", "1;2", "x"] {
            assert!(ids(wrong).is_err(), "{wrong}");
        }
        assert!(bridge("3").is_err() && bridge("3+3").is_err());
        assert_eq!(crease("4+2"), Ok(vec![4, 2]));
        for wrong in ["4", "4+4", "4+2+1", "4,2", "0+1"] {
            assert!(crease(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn counts_are_bounded() {
        assert_eq!(threads("8"), Ok(8));
        for wrong in [
            "0",
            "-1",
            "1.5",
            "18446744073709551615",
            "99999999999999999999",
        ] {
            assert!(
                threads(wrong).is_err_and(|e| e.contains("from 1 to")),
                "{wrong}"
            );
        }
        assert!(threads("1024").is_ok() && threads("1025").is_err());
    }

    #[test]
    fn lengths_are_positive_and_finite() {
        assert_eq!(positive("0.5"), Ok(0.5));
        for wrong in ["0", "-1", "nan", "inf", "1mm"] {
            assert!(positive(wrong).is_err(), "{wrong}");
        }
    }
}
