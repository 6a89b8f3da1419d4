//! Remarks on units of length: if the output format cannot store one, or if two contradict each other.

use crate::io::Format;
use isomend_core::mesh::Unit;

/// Remarks on writing coordinates in a format, given the unit that the input names and the unit that the caller gives.
pub(super) fn unit_notes(input: Option<Unit>, given: Option<Unit>, format: Format) -> Vec<String> {
    let mut notes: Vec<String> = contradiction(input, given).into_iter().collect();
    let Some(unit) = given.or(input) else {
        return notes;
    };
    match format {
        format if holds_unit(format) => {}
        Format::Gltf | Format::Glb if unit == Unit::Metre => {}
        Format::Gltf | Format::Glb => notes.push(format!(
            "{format} has lengths in metres by definition, but the coordinates are written as they are, in {unit}"
        )),
        _ => notes.push(format!(
            "{format} has no place for a unit: that its coordinates are in {unit} is not in the file"
        )),
    }
    notes
}

/// Whether files of a format say what their unit is.
pub(super) fn holds_unit(format: Format) -> bool {
    matches!(format, Format::ThreeMf | Format::Usda | Format::Usdz)
}

/// A remark if the caller gives another unit than the input names.
#[doc(hidden)]
pub fn contradiction(input: Option<Unit>, given: Option<Unit>) -> Option<String> {
    let (own, given) = (input?, given?);
    (own != given).then(|| {
        format!(
            "the input gives its coordinates in {own}, but {given} was asked for: they are taken for {given} and not converted"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_that_are_lost_or_contradict_each_other_are_named() {
        let (mm, inch) = (Some(Unit::Millimetre), Some(Unit::Inch));
        let notes = |input, given, format| unit_notes(input, given, format).join("; ");
        assert_eq!(notes(None, None, Format::Ply), "");
        assert_eq!(notes(mm, mm, Format::ThreeMf), "");
        assert_eq!(notes(None, mm, Format::Usdz), "");
        assert_eq!(notes(None, Some(Unit::Metre), Format::Glb), "");
        assert!(notes(None, mm, Format::Glb).contains("metres by definition"));
        assert!(notes(mm, None, Format::Stl).contains("in mm is not in the file"));
        let both = notes(mm, inch, Format::ThreeMf);
        assert!(both.contains("in mm, but in was asked for"), "{both}");
    }
}
