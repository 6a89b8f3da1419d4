//! A remark on new faces that rounding to the format's floats leaves without area.

use glam::DVec3;

use isomend_core::check::is_flat;
use isomend_core::mesh::{Mesh, number, significant};

/// A remark on the faces after the first `kept` that have an area in full precision, but none in the positions that are written;
/// none if there are no such faces. `full` gives the position of a vertex in full precision.
pub(super) fn collapse_note(
    full: impl Fn(u32) -> DVec3,
    written: &Mesh,
    kept: usize,
) -> Option<String> {
    let was_flat = |f: &u32| is_flat(written.faces[*f as usize].map(&full));
    let is_lost = |f: &u32| is_flat(written.corners(*f)) && !was_flat(f);
    let new = kept as u32..written.faces.len() as u32;
    let lost: Vec<u32> = new.clone().filter(is_lost).collect();
    let corners = lost.iter().flat_map(|f| written.corners(*f));
    let largest = corners
        .map(|p| p.abs().max_element() as f32)
        .reduce(f32::max)?;
    let spacing = f64::from(largest.next_up()) - f64::from(largest);
    Some(format!(
        "{} of {} new faces have no area in the file: its 32-bit floats are {} apart there, at coordinates of \
         {}; move the model towards the origin, or use larger faces (a larger edge ratio)",
        lost.len(),
        new.len(),
        significant(spacing, 2),
        number(f64::from(largest))
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use isomend_core::mesh::shapes::icosphere;

    #[test]
    fn faces_smaller_than_the_resolution_are_named_with_it() {
        let far = |radius: f64| {
            let ball = icosphere(2);
            let at = |p: &DVec3| DVec3::splat(1e6) + radius * *p;
            Mesh::new(ball.positions.iter().map(at).collect(), ball.faces)
        };
        let rounded = |mesh: &Mesh| {
            let round = |p: &DVec3| p.as_vec3().as_dvec3();
            Mesh::new(
                mesh.positions.iter().map(round).collect(),
                mesh.faces.clone(),
            )
        };
        let note = |radius: f64, kept: usize| {
            let full = far(radius);
            collapse_note(|v| full.positions[v as usize], &rounded(&full), kept)
        };
        assert_eq!(note(1e3, 0), None);
        let said = note(0.1, 0).unwrap();
        assert!(
            said.contains("are 0.062 apart there, at coordinates of 1000000;"),
            "{said}"
        );
        // Faces of the input do not count.
        assert_eq!(note(0.1, far(0.1).faces.len()), None);
    }
}
