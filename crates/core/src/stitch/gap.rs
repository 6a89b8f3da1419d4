//! Filling of the gaps between rims and the kept part with triangles.

use glam::DVec3;

use super::half_edge::PatchMesh;
use super::matching::Gap;
use super::rim::Rims;
use super::sector::{Outline, nearest_pair};
use super::zip::ring;
use super::{StitchError, StitchInput, StitchReport};
use crate::mesh::triangulate::{Ground, Polygon, cut_ears, triangulate};
use crate::tuning::{Tunable, tunable};

/// Least mean cosine between the faces of a gap and the surface; below it the loops were matched wrongly.
const LEAST_AGREEMENT: Tunable<f64> = tunable("stitch.least_agreement", 0.3);

/// Loops of patch vertices, each with the gap on its left.
pub(super) struct Loops {
    /// Rim corners.
    pub(super) rim: Vec<Vec<u32>>,
    /// Boundary loops of the kept part.
    pub(super) inner: Vec<Vec<u32>>,
}

/// Adds faces that fill the gap.
pub(super) fn fill(
    input: &StitchInput,
    rims: &Rims,
    gap: &Gap,
    loops: &Loops,
    mesh: &mut PatchMesh,
    report: &mut StitchReport,
) -> Result<(), StitchError> {
    let faces = match (&gap.rims[..], &gap.inner[..]) {
        ([], _) => Vec::new(),
        // The surface does not reach this rim: if the rim is thin, triangulate it without new vertices.
        (&[rim], []) => {
            report.filled_directly += 1;
            direct(input, rims, &loops.rim[rim], mesh).ok_or(StitchError::RimNotReached {
                rim: rims.source[rim],
            })?
        }
        // The common case: a ring of triangles between the rim and one boundary loop of the kept part.
        (&[rim], &[inner]) => {
            let loops = [&loops.rim[rim][..], &loops.inner[inner]];
            let [outer, kept] = loops.map(|lp| outline(mesh, lp));
            let faces = ring(loops, [&outer, &kept]);
            if agreement(mesh, &faces) < 0.0 {
                return Err(StitchError::Orientation {
                    rim: rims.source[rim],
                });
            }
            faces
        }
        // Several loops are merged to one polygon, which is triangulated by ear cutting; without any boundary loop of the kept
        // part, only if it is thin.
        _ => {
            report.bridged += gap.rims.len() + gap.inner.len() - 2;
            let polygon = merge(mesh, gap, loops);
            let missing = gap.inner.is_empty() && !outline(mesh, &polygon).is_thin(input.voxel);
            let faces = if missing {
                None
            } else {
                by_ears(mesh, rims, &polygon)
            };
            faces
                .filter(|faces| agreement(mesh, faces) > LEAST_AGREEMENT.get())
                .ok_or(StitchError::RimNotReached {
                    rim: rims.source[gap.rims[0]],
                })?
        }
    };
    mesh.faces.extend(faces);
    Ok(())
}

fn outline(mesh: &PatchMesh, lp: &[u32]) -> Outline {
    Outline::new(
        lp.iter()
            .map(|&v| (mesh.position[v as usize], mesh.normal[v as usize])),
    )
}

/// Mean cosine between the normals of faces and surface, weighted by area.
fn agreement(mesh: &PatchMesh, faces: &[[u32; 3]]) -> f64 {
    let (mut area, mut agreement) = (0.0, 0.0);
    for &f in faces {
        let cross = mesh.area_vector(f);
        let normal: DVec3 = f.iter().map(|&v| mesh.normal[v as usize]).sum();
        area += cross.length();
        agreement += cross.dot(normal.normalize_or_zero());
    }
    if area > 0.0 { agreement / area } else { 0.0 }
}

/// Merges all loops of the gap to one: each is joined to the ones before by the shortest edge, along which the merged loop then
/// runs in both directions. Shortest edges do not intersect.
fn merge(mesh: &PatchMesh, gap: &Gap, loops: &Loops) -> Vec<u32> {
    let mut left: Vec<&Vec<u32>> = gap
        .rims
        .iter()
        .map(|&r| &loops.rim[r])
        .chain(gap.inner.iter().map(|&l| &loops.inner[l]))
        .collect();
    let mut merged = left.remove(0).clone();
    let mut outlines: Vec<Outline> = left.iter().map(|lp| outline(mesh, lp)).collect();
    while !left.is_empty() {
        let whole = outline(mesh, &merged);
        let mut best = (f64::INFINITY, 0, 0, 0);
        for (k, o) in outlines.iter().enumerate() {
            if let Some((d, i, j)) = nearest_pair(&whole, o, best.0) {
                best = (d, k, i, j);
            }
        }
        let (_, k, i, j) = best;
        outlines.remove(k);
        let mut other = left.remove(k).clone();
        other.rotate_left(j);
        other.extend([other[0], merged[i]]);
        merged.splice(i + 1..i + 1, other);
    }
    merged
}

/// Triangulates a polygon of patch vertices by ear cutting; new vertices that it needs are added to the patch.
fn by_ears(mesh: &mut PatchMesh, rims: &Rims, polygon: &[u32]) -> Option<Vec<[u32; 3]>> {
    let rim = |v: u32| mesh.is_rim(v).then(|| mesh.origin[v as usize]);
    let taken = |a: u32, b: u32| match (rim(a), rim(b)) {
        (Some(u), Some(v)) => u == v || rims.has_edge(u, v),
        _ => false,
    };
    let cut = cut_ears(
        &Ground {
            position: &mesh.position,
            normal: &mesh.normal,
            faces: &mesh.faces,
            taken: &taken,
        },
        polygon,
    )?;
    for vertex in cut.new {
        mesh.position.push(vertex.position);
        mesh.normal.push(vertex.normal);
        mesh.size.push(mesh.size[vertex.neighbour as usize]);
    }
    Some(cut.faces)
}

/// A triangulation of one rim loop without new vertices, if the loop is thin and the faces agree with the surface.
fn direct(
    input: &StitchInput,
    rims: &Rims,
    rim: &[u32],
    mesh: &mut PatchMesh,
) -> Option<Vec<[u32; 3]>> {
    let n = rim.len();
    let origin = |i: usize| mesh.origin[rim[i % n] as usize];
    let position: Vec<DVec3> = rim.iter().map(|&v| mesh.position[v as usize]).collect();
    let beyond: Vec<_> = (0..n)
        .map(|i| {
            rims.beyond
                .get(&(origin(i), origin(i + 1)))
                .map(|f| f.normal)
        })
        .collect();
    let blocked =
        |i: usize, j: usize| origin(i) == origin(j) || rims.has_edge(origin(i), origin(j));
    if !outline(mesh, rim).is_thin(input.voxel) {
        return None;
    }
    let polygon = Polygon {
        position: &position,
        beyond: &beyond,
        blocked: &blocked,
    };
    let faces: Option<Vec<[u32; 3]>> =
        triangulate(&polygon).map(|faces| faces.into_iter().map(|f| f.map(|i| rim[i])).collect());
    match faces.filter(|faces| agreement(mesh, faces) > LEAST_AGREEMENT.get()) {
        None => {
            by_ears(mesh, rims, rim).filter(|faces| agreement(mesh, faces) > LEAST_AGREEMENT.get())
        }
        found => found,
    }
}
