//! Parsers of single arguments. Their messages are shown by clap after the name of the option.

use isomend::io::Format;
use isomend::{HoleId, VoxelSize};

/// Numbers of holes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ids(pub Vec<HoleId>);

/// A width about the surface; none where all is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band(pub Option<f64>);

/// Which holes to fill.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// All of them.
    All,
    /// Those with these numbers.
    Some(Vec<HoleId>),
}

/// A positive whole number.
pub fn count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) | Err(_) => Err("a whole number from 1 is needed".to_owned()),
        Ok(n) => Ok(n),
    }
}

/// A positive whole number with a largest value.
fn count_to(text: &str, most: usize) -> Result<usize, String> {
    match count(text) {
        Ok(n) if n <= most => Ok(n),
        _ => Err(format!("a whole number from 1 to {most} is needed")),
    }
}

/// A number of threads.
pub fn threads(text: &str) -> Result<usize, String> {
    count_to(text, isomend::Control::MOST_THREADS)
}

/// A number of steps.
pub fn steps(text: &str) -> Result<usize, String> {
    count_to(text, isomend::FillParams::MOST_STEPS)
}

/// A number of samples of a surface.
pub fn samples(text: &str) -> Result<usize, String> {
    count_to(text, isomend::compare::MOST_SAMPLES)
}

/// A finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("a number is needed".to_owned()),
    }
}

/// `full` or a length.
pub fn band(text: &str) -> Result<Band, String> {
    if text == "full" {
        return Ok(Band(None));
    }
    positive(text)
        .map(|length| Band(Some(length)))
        .map_err(|_| "a positive length in the mesh's units is needed, or full".to_owned())
}

/// A positive finite number.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a positive number is needed".to_owned()),
    }
}

/// A number from 0 to 1.
pub fn part(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=1.0).contains(&value) => Ok(value),
        _ => Err("a number from 0 to 1 is needed".to_owned()),
    }
}

/// A ratio of edge lengths that meshes can have.
pub fn edge_ratio(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.05 && value < 20.0 => Ok(value),
        _ => Err("a number between 0.05 and 20 is needed".to_owned()),
    }
}

/// A file format by its extension.
pub fn format(text: &str) -> Result<Format, String> {
    text.parse()
        .map_err(|error: isomend::io::IoError| error.to_string())
}

/// `auto` or a length.
pub fn voxel(text: &str) -> Result<VoxelSize, String> {
    if text == "auto" {
        return Ok(VoxelSize::Auto);
    }
    positive(text)
        .map(VoxelSize::Length)
        .map_err(|_| "a positive length in the mesh's units is needed, or auto".to_owned())
}

/// Hole numbers with commas between them.
pub fn ids(text: &str) -> Result<Ids, String> {
    separated(text, ',').map(Ids)
}

/// `all` or hole numbers with commas between them.
pub fn choice(text: &str) -> Result<Choice, String> {
    if text == "all" {
        return Ok(Choice::All);
    }
    separated(text, ',').map(Choice::Some)
}

/// Two or more hole numbers with plus signs between them.
pub fn bridge(text: &str) -> Result<Ids, String> {
    let ids = separated(text, '+')?;
    let mut distinct = ids.clone();
    distinct.sort_unstable();
    distinct.dedup();
    if distinct.len() < 2 {
        return Err("two different holes are needed, such as 3+7".to_owned());
    }
    Ok(Ids(ids))
}

fn separated(text: &str, separator: char) -> Result<Vec<HoleId>, String> {
    text.split(separator)
        .map(|part| {
            count(part.trim()).map(HoleId::from).map_err(|_| {
                format!(
                    "'{part}' is not the number of a hole; numbers count from 1, with '{separator}' between them \
                     (`isomend inspect` lists them)"
                )
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_are_lists_of_numbers_or_all() {
        assert_eq!(choice("all"), Ok(Choice::All));
        assert_eq!(choice("3, 1"), Ok(Choice::Some(vec![3.into(), 1.into()])));
        assert_eq!(ids("2"), Ok(Ids(vec![2.into()])));
        assert_eq!(
            bridge("3+7+9"),
            Ok(Ids([3, 7, 9].map(HoleId::from).to_vec()))
        );
        for wrong in ["", "0", "1,,2", "-1", "1;2", "x"] {
            assert!(ids(wrong).is_err(), "{wrong}");
        }
        assert!(bridge("3").is_err() && bridge("3+3").is_err());
    }

    #[test]
    fn counts_are_bounded() {
        for parse in [threads, steps, samples] {
            assert_eq!(parse("8"), Ok(8));
            for wrong in [
                "0",
                "-1",
                "1.5",
                "18446744073709551615",
                "99999999999999999999",
            ] {
                assert!(
                    parse(wrong).is_err_and(|e| e.contains("from 1 to")),
                    "{wrong}"
                );
            }
        }
        assert!(threads("1024").is_ok() && threads("1025").is_err());
    }

    #[test]
    fn lengths_are_positive_and_finite() {
        assert_eq!(voxel("auto"), Ok(VoxelSize::Auto));
        assert_eq!(voxel("0.5"), Ok(VoxelSize::Length(0.5)));
        for wrong in ["0", "-1", "nan", "inf", "1mm"] {
            assert!(voxel(wrong).is_err() && positive(wrong).is_err(), "{wrong}");
        }
    }
}
