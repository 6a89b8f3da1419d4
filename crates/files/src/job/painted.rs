//! Patches of regions that were marked by a colour: no new face is marked again.
//!
//! Vertices of the cut's rim may have the colour, since kept faces use them. A new face between three such vertices would still be
//! selected by the colour. It is divided at its centre, where the patch has another colour; its shape stays.

use crate::io::Loaded;
use isomend_core::attributes::UnwantedColour;
use isomend_core::mend::FillReport;
use isomend_core::mesh::Mesh;
use isomend_core::mesh::attributes::Role;
use isomend_core::mesh::mask::is_near;

/// Marks the kept vertices that have one of the colours.
fn painted(kept: &Loaded, colours: &[UnwantedColour]) -> Option<Vec<bool>> {
    let values = kept.attributes.vertex_role(Role::Colour);
    let values = values.filter(|c| c.components >= 3 && !colours.is_empty())?;
    let is_painted = |v: usize| {
        let mut all = colours.iter();
        all.any(|c| is_near(values, v, c.rgb, c.tolerance))
    };
    Some((0..kept.mesh.positions.len()).map(is_painted).collect())
}

/// Divides the new faces whose vertices all have one of the colours. `mesh` begins with the vertices and faces of `kept`; the new faces of
/// the regions follow, in the order of the report.
pub(super) fn divide(
    mesh: &mut Mesh,
    expected_error: &mut Vec<Option<f64>>,
    report: &mut FillReport,
    kept: &Loaded,
    colours: &[UnwantedColour],
) {
    let Some(painted) = painted(kept, colours) else {
        return;
    };
    let is_painted = |v: &u32| painted.get(*v as usize).is_some_and(|p| *p);
    let mut rest = mesh.faces.split_off(kept.mesh.faces.len()).into_iter();
    for region in &mut report.regions {
        let own: Vec<[u32; 3]> = rest.by_ref().take(region.new_faces).collect();
        let mut divided = Vec::new();
        for &face in &own {
            if !face.iter().all(is_painted) {
                mesh.faces.push(face);
                continue;
            }
            let [a, b, c] = face;
            let corners = face.map(|v| mesh.positions[v as usize]);
            let centre = mesh.positions.len() as u32;
            mesh.positions
                .push((corners[0] + corners[1] + corners[2]) / 3.0);
            if !expected_error.is_empty() {
                let largest = largest_beside(&own, face, painted.len(), expected_error);
                expected_error.push(largest);
            }
            mesh.faces.push([a, b, centre]);
            divided.extend([[b, c, centre], [c, a, centre]]);
            region.new_vertices += 1;
        }
        region.new_faces += divided.len();
        mesh.faces.append(&mut divided);
    }
    mesh.faces.extend(rest);
}

/// The largest expected error of the new vertices in faces that share a vertex with one of the faces; none if none is known. The first
/// `kept` vertices are not new.
fn largest_beside(
    faces: &[[u32; 3]],
    face: [u32; 3],
    kept: usize,
    errors: &[Option<f64>],
) -> Option<f64> {
    let beside = faces.iter().filter(|f| f.iter().any(|v| face.contains(v)));
    let error = |v: &u32| *errors.get((*v as usize).checked_sub(kept)?)?;
    beside.flatten().filter_map(error).reduce(f64::max)
}

/// A remark on kept vertices at the rim that have one of the colours.
pub(super) fn note(mesh: &Mesh, kept: &Loaded, colours: &[UnwantedColour]) -> Option<String> {
    let painted = painted(kept, colours)?;
    let new = mesh.faces.get(kept.mesh.faces.len()..)?;
    let of_new = new
        .iter()
        .flatten()
        .filter(|v| (**v as usize) < painted.len());
    let mut at_rim: Vec<u32> = of_new.copied().filter(|v| painted[*v as usize]).collect();
    at_rim.sort_unstable();
    at_rim.dedup();
    (!at_rim.is_empty()).then(|| {
        format!(
            "vertices at the rim that keep the colour of the mask, because faces outside of it use them: {}; a mask that is grown takes \
             them in",
            at_rim.len()
        )
    })
}
