//! The missing piece as a printable solid: the volume between the faces that a restoration cut out and its patches.

use glam::{DMat4, DVec3};

use isomend_core::check::{CheckParams, Defect, DefectKind, Verdict};
use isomend_core::mend::{Control, Inspection};
use isomend_core::mesh::topology::{end, start};
use isomend_core::mesh::{Mesh, Topology, VertexFaces, face_normal, vertex_normal, weld_map};
use isomend_core::repair::{Carried, RepairParams, RepairStep, repair};
use isomend_core::tuning::{Tunable, tunable};

/// Fraction of the volume of the part's largest component. Smaller components are left out: where a patch and the removed
/// faces are the same surface up to noise, there are thin slivers between them.
const PIECE_PART: Tunable<f64> = tunable("deliver.piece_part", 1e-3);

/// Message if other work than a restoration is asked for a piece.
pub(super) const ONLY_RESTORED: &str = "only a restoration makes a piece: the solid between the faces that it cuts out and the patches";

/// The solid between two surfaces with a common rim.
pub(in crate::job) struct Piece {
    /// Closed and oriented outward.
    pub(in crate::job) mesh: Mesh,
    /// Remarks.
    pub(in crate::job) notes: Vec<String>,
}

/// Builds the solid between `patches`, the new faces of a mesh, and `cut`, the faces that they replace. The two surfaces have the same
/// vertex positions along the common rim. `stored` is as in [`Carried::stored`].
///
/// The solid is bounded by the patches on the outside and by the flipped cut faces on the inside. Where the two surfaces intersect, only
/// the volume that the patches add is kept: a point belongs to the solid if its winding number is positive. Holes in the cut faces are
/// filled. The cut faces are first moved by `clearance` into the solid, except at the rim.
///
/// # Errors
/// A message that says why there is no solid.
pub(in crate::job) fn piece(
    patches: &Mesh,
    cut: &Mesh,
    clearance: f64,
    stored: Option<DMat4>,
    control: &Control,
) -> Result<Piece, String> {
    let tight = || between(joined(patches, cut), stored, control);
    if clearance <= 0.0 {
        return tight()?.ok_or_else(|| BELOW.to_owned());
    }
    let moved = moved(cut, patches, clearance);
    let Some(mut made) = between(joined(patches, &moved), stored, control)? else {
        let is_thin = matches!(tight(), Ok(Some(_)));
        return Err(if is_thin { THIN } else { BELOW }.to_owned());
    };
    let count = |made: &Piece| judged(&made.mesh).map(|(verdict, _)| verdict.components.len());
    let left = count(&made)?;
    // Each damage has its own component of faces that were cut out. As many solids as that: none is lost.
    if Topology::without_orienting(cut).component_faces.len() > left
        && let Some(tight) = tight()?
    {
        let all = count(&tight)?;
        if left < all {
            made.notes.push(format!(
                "of {all} pieces {left} are thicker than the clearance; the others are left out"
            ));
        }
    }
    Ok(made)
}

/// The solid of the volume that a closed surface, or one with holes, encloses with a positive winding number; none where there is
/// no such volume. `stored` is as in [`Carried::stored`].
fn between(
    mut surface: Mesh,
    stored: Option<DMat4>,
    control: &Control,
) -> Result<Option<Piece>, String> {
    if surface.faces.is_empty() {
        return Err(
            "there is no volume between the patch and the faces that were cut out".to_owned(),
        );
    }
    let (verdict, topology) = judged(&surface)?;
    let open = verdict.holes;
    let plain = verdict
        .defects
        .iter()
        .all(|d| d.kind == DefectKind::InsideOut);
    if plain {
        let mesh = outward(&surface, &verdict, &topology);
        return mesh.map(|mesh| finished(mesh, Vec::new())).transpose();
    }
    if verdict.is_watertight() {
        // A repair would flip components that are inside out, so these are removed first.
        let Some(rest) = not_inside_out(&surface, &verdict, &topology) else {
            return Ok(None);
        };
        surface = rest;
    }
    let carried = Carried {
        stored,
        ..Carried::default()
    };
    // Where the patch is below, the volume is negative and goes.
    let params = RepairParams::default().with_skip([RepairStep::Orientation]);
    let repaired =
        repair(&surface, &params, &carried, control).map_err(|error| error.to_string())?;
    let mut notes = Vec::new();
    if open > 0 {
        notes.push(format!(
            "holes in the faces that were cut out were filled for the piece: {open}"
        ));
    }
    if repaired.report.steps.united_bodies > 0 {
        notes.push(
            "in places the patch is below the faces that were cut out; the piece contains only the volume where it is above them"
                .to_owned(),
        );
    }
    let (verdict, topology) = judged(&repaired.mesh)?;
    let mesh = outward(&repaired.mesh, &verdict, &topology);
    mesh.map(|mesh| finished(mesh, notes)).transpose()
}

/// Message if the patch adds no volume.
const BELOW: &str =
    "the patch is below the faces that were cut out, so nothing is missing and there is no piece";

/// Message if the clearance leaves nothing.
const THIN: &str =
    "nothing is left of the piece, which is thinner than the clearance; lower the clearance";

/// Longest displacement of a vertex in a clearance, in clearances: at edges sharper than 60° the faces come closer than the clearance.
const LONGEST_MOVE: f64 = 2.0;

/// The cut faces, moved outward by the clearance. A vertex moves along its normal until it is at the clearance from the planes of its faces;
/// vertices at the rim of the patches stay.
fn moved(cut: &Mesh, patches: &Mesh, clearance: f64) -> Mesh {
    // Both surfaces on the same welded vertices.
    let positions = [&cut.positions[..], &patches.positions[..]].concat();
    let weld = weld_map(&Mesh::new(positions.clone(), Vec::new()));
    let on_welded = |mesh: &Mesh, base: usize| {
        let faces = (mesh.faces.iter()).map(|f| f.map(|v| weld[base + v as usize]));
        Mesh::new(positions.clone(), faces.collect())
    };
    let (surface, patches) = (on_welded(cut, 0), on_welded(patches, cut.positions.len()));
    let mut on_rim = vec![false; positions.len()];
    let boundary = Topology::without_orienting(&patches).boundary;
    for (half_edge, _) in (0..).zip(boundary).filter(|(_, is_single)| *is_single) {
        for v in [start(&patches, half_edge), end(&patches, half_edge)] {
            on_rim[v as usize] = true;
        }
    }
    let around = VertexFaces::new(&surface);
    let displacement = |v: u32| {
        let normal = vertex_normal(&surface, &around, v);
        let normals = around.of(v).iter().map(|&f| face_normal(&surface, f));
        // Faces without area have no plane.
        let cosines = normals.filter(|n| *n != DVec3::ZERO).map(|n| n.dot(normal));
        let least = cosines.fold(1.0, f64::min).max(1.0 / LONGEST_MOVE);
        normal * (clearance / least)
    };
    let moved = cut.positions.iter().zip(&weld);
    let moved = moved.map(|(p, &v)| match on_rim[v as usize] {
        true => *p,
        false => *p + displacement(v),
    });
    Mesh::new(moved.collect(), cut.faces.clone())
}

/// The patches and the flipped cut faces as one mesh, with vertices at equal positions merged.
fn joined(patches: &Mesh, cut: &Mesh) -> Mesh {
    let base = patches.positions.len() as u32;
    let positions = [&patches.positions[..], &cut.positions[..]].concat();
    let turned = cut
        .faces
        .iter()
        .map(|[a, b, c]| [a + base, c + base, b + base]);
    let faces = patches.faces.iter().copied().chain(turned).collect();
    let mut all = Mesh::new(positions, faces);
    let weld = weld_map(&all);
    for face in &mut all.faces {
        *face = face.map(|v| weld[v as usize]);
    }
    // Remove degenerate faces, and faces that patches and cut have in common: there is no volume between them.
    all.faces.retain(|[a, b, c]| a != b && b != c && a != c);
    without_pairs(&mut all);
    compact(&all, |_| true)
}

/// Removes pairs of faces with the same vertices and opposite orientations.
fn without_pairs(mesh: &mut Mesh) {
    let sorted = |face: &[u32; 3]| {
        let mut corners = *face;
        corners.sort_unstable();
        corners
    };
    let mut order: Vec<u32> = (0..mesh.faces.len() as u32).collect();
    order.sort_by_key(|f| (sorted(&mesh.faces[*f as usize]), *f));
    let mut gone = vec![false; mesh.faces.len()];
    let is_same_way =
        |a: [u32; 3], b: [u32; 3]| (0..3).any(|k| [b[k], b[(k + 1) % 3]] == [a[0], a[1]]);
    for pair in order.windows(2) {
        let [a, b] = [pair[0] as usize, pair[1] as usize];
        let (f, g) = (mesh.faces[a], mesh.faces[b]);
        if !gone[a] && sorted(&f) == sorted(&g) && !is_same_way(f, g) {
            gone[a] = true;
            gone[b] = true;
        }
    }
    let mut f = 0;
    mesh.faces.retain(|_| {
        f += 1;
        !gone[f - 1]
    });
}

/// The faces for which `keep` is true, with the vertices that they use.
fn compact(mesh: &Mesh, keep: impl Fn(usize) -> bool) -> Mesh {
    let mut number = vec![u32::MAX; mesh.positions.len()];
    let mut out = Mesh::default();
    for (_, face) in mesh.faces.iter().enumerate().filter(|(f, _)| keep(*f)) {
        let face = face.map(|v| {
            let new = &mut number[v as usize];
            if *new == u32::MAX {
                *new = out.positions.len() as u32;
                out.positions.push(mesh.positions[v as usize]);
            }
            *new
        });
        out.faces.push(face);
    }
    out
}

/// Checks a mesh with default parameters.
fn judged(mesh: &Mesh) -> Result<(Verdict, Topology), String> {
    let found = Inspection::new(mesh).map_err(|error| error.to_string())?;
    let verdict = found.check(&CheckParams::default());
    Ok((verdict, found.topology))
}

/// The components that enclose a positive volume larger than the fraction `PIECE_PART.get()` of the largest component's;
/// `None` if there are none.
fn outward(mesh: &Mesh, verdict: &Verdict, topology: &Topology) -> Option<Mesh> {
    let volumes = || verdict.components.iter().map(|c| c.volume);
    let least = volumes().fold(0.0, f64::max) * PIECE_PART.get();
    let stays: Vec<bool> = volumes().map(|v| v > least).collect();
    of_components(mesh, topology, &stays)
}

/// The components without intersections that enclose a positive volume, and those with intersections: of these a part may, whatever
/// the sum is. `None` if there are none.
fn not_inside_out(mesh: &Mesh, verdict: &Verdict, topology: &Topology) -> Option<Mesh> {
    let mut stays: Vec<bool> = verdict.components.iter().map(|c| c.volume > 0.0).collect();
    let of_kind = |d: &&Defect| d.kind == DefectKind::SelfIntersection;
    let crossing = verdict.defects.iter().filter(of_kind);
    for f in crossing.flat_map(|d| &d.faces) {
        if let Some(stays) = stays.get_mut(topology.component[*f as usize] as usize) {
            *stays = true;
        }
    }
    of_components(mesh, topology, &stays)
}

/// The faces of the components that stay; `None` if there are none.
fn of_components(mesh: &Mesh, topology: &Topology, stays: &[bool]) -> Option<Mesh> {
    let is_in = |f: usize| stays.get(topology.component[f] as usize) == Some(&true);
    let out = compact(mesh, is_in);
    (!out.faces.is_empty()).then_some(out)
}

/// The piece, if it passes the check of a mesh.
fn finished(mesh: Mesh, notes: Vec<String>) -> Result<Piece, String> {
    let (verdict, _) = judged(&mesh)?;
    match verdict.is_sound() {
        true => Ok(Piece { mesh, notes }),
        false => Err(format!(
            "the solid between the patch and the faces that were cut out is not sound: {}",
            verdict.reasons().join(", ")
        )),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    /// A square of `2 n²` faces over [0, 1]², with height 0 on its outer border.
    fn sheet(n: usize, height: impl Fn(f64, f64) -> f64) -> Mesh {
        let mut mesh = Mesh::default();
        for j in 0..=n {
            for i in 0..=n {
                let [x, y] = [i, j].map(|k| k as f64 / n as f64);
                let inside = i > 0 && j > 0 && i < n && j < n;
                let z = if inside { height(x, y) } else { 0.0 };
                mesh.positions.push(DVec3::new(x, y, z));
            }
        }
        let at = |i: usize, j: usize| (j * (n + 1) + i) as u32;
        for j in 0..n {
            for i in 0..n {
                let [a, b] = [at(i, j), at(i + 1, j)];
                let [c, d] = [at(i, j + 1), at(i + 1, j + 1)];
                mesh.faces.extend([[a, b, c], [b, d, c]]);
            }
        }
        mesh
    }

    /// The volume that a closed mesh encloses, negative where it is inside out.
    fn volume(mesh: &Mesh) -> f64 {
        let Some(&origin) = mesh.positions.first() else {
            return 0.0;
        };
        let part = |f: u32| {
            let [a, b, c] = mesh.corners(f).map(|p| p - origin);
            a.dot(b.cross(c)) / 6.0
        };
        (0..mesh.faces.len() as u32).map(part).sum()
    }

    fn made(patch: &Mesh, cut: &Mesh) -> Result<Piece, String> {
        piece(patch, cut, 0.0, None, &Control::new())
    }

    #[test]
    fn a_clearance_moves_the_lower_sheet_into_the_piece_and_keeps_the_rim() {
        let (upper, lower) = (sheet(16, |_, _| 0.3), sheet(16, |_, _| -0.1));
        let with = |clearance| piece(&upper, &lower, clearance, None, &Control::new());
        let (tight, loose) = (with(0.0).unwrap().mesh, with(0.05).unwrap().mesh);
        assert!(judged(&loose).unwrap().0.is_sound());
        let between = volume(&tight) - volume(&loose);
        assert!((between - 0.05 * 0.875).abs() < 0.006, "{between}");
        let inner = |p: &&DVec3| p.x.min(p.y).min(1.0 - p.x).min(1.0 - p.y) > 0.1;
        let lowest = loose.positions.iter().filter(inner).map(|p| p.z);
        assert!((lowest.fold(1.0, f64::min) + 0.05).abs() < 1e-9);
        // But for two corners, where both sheets have the same face.
        assert_eq!(loose.positions.iter().filter(|p| p.z == 0.0).count(), 62);
        // Little is left of a piece that is thinner than the clearance.
        let thin = with(0.5).map_or(0.0, |piece| volume(&piece.mesh));
        assert!(thin < 0.5 * volume(&tight), "{thin}");
        // The rim of a hole in the cut faces moves too.
        let mut pierced = lower.clone();
        let is_middle = |p: DVec3| p.x > 0.4 && p.x < 0.6 && p.y > 0.4 && p.y < 0.6;
        pierced.faces = (lower.faces.iter().copied())
            .filter(|f| !f.iter().all(|v| is_middle(lower.positions[*v as usize])))
            .collect();
        let moved = moved(&pierced, &upper, 0.05);
        let used: HashSet<u32> = pierced.faces.iter().flatten().copied().collect();
        let at = |v: &u32| moved.positions[*v as usize];
        let middle: Vec<DVec3> = used.iter().map(at).filter(|p| is_middle(*p)).collect();
        assert_eq!(middle.len(), 8);
        assert!(middle.iter().all(|p| (p.z + 0.05).abs() < 1e-9));
    }

    #[test]
    fn a_clearance_above_a_wide_margin_leaves_the_piece() {
        let bump = |x: f64, y: f64| {
            if (x - 0.5).hypot(y - 0.5) < 0.2 {
                0.3
            } else {
                1e-3
            }
        };
        let (upper, lower) = (sheet(20, bump), sheet(20, |_, _| 0.0));
        let with = |clearance| piece(&upper, &lower, clearance, None, &Control::new());
        // What the clearance takes from the whole sheet is more than the piece.
        let (tight, loose) = (with(0.0).unwrap().mesh, with(0.1).unwrap().mesh);
        assert!(volume(&tight) < 0.1);
        let left = volume(&loose) / volume(&tight);
        assert!((0.5..0.7).contains(&left), "{left}");
        // A second one is thinner than the clearance.
        let beside = |mesh: &Mesh, low: &Mesh| {
            let mut both = mesh.clone();
            both.positions
                .extend(low.positions.iter().map(|p| *p + 2.0 * DVec3::X));
            let first = mesh.positions.len() as u32;
            both.faces
                .extend(low.faces.iter().map(|f| f.map(|v| v + first)));
            both
        };
        let (upper, lower) = (
            beside(&upper, &sheet(20, |_, _| 0.05)),
            beside(&lower, &lower),
        );
        let with = |clearance| piece(&upper, &lower, clearance, None, &Control::new());
        assert!(with(0.0).unwrap().notes.is_empty());
        let one = with(0.1).unwrap();
        assert!((volume(&one.mesh) - volume(&loose)).abs() < 1e-9);
        assert!(
            one.notes.iter().any(|n| n.starts_with("of 2 pieces 1 ")),
            "{:?}",
            one.notes
        );
        let none = with(0.4).err().unwrap();
        assert!(none.contains("thinner than the clearance"), "{none}");
    }

    #[test]
    fn the_piece_is_the_volume_that_the_upper_sheet_adds() {
        let (upper, lower) = (sheet(8, |_, _| 0.3), sheet(8, |_, _| -0.1));
        let piece = made(&upper, &lower).unwrap();
        let (verdict, _) = judged(&piece.mesh).unwrap();
        assert!(verdict.is_sound());
        assert!(volume(&piece.mesh) > 0.2);
        assert_eq!(made(&lower, &upper).err().as_deref(), Some(BELOW));
        assert!(made(&upper, &upper).is_err());
    }

    #[test]
    fn where_the_sheets_intersect_only_added_volume_is_kept() {
        let upper = sheet(12, |x, _| 0.25 * (x - 0.3));
        let lower = sheet(12, |_, _| 0.0);
        let piece = made(&upper, &lower).unwrap();
        assert!(judged(&piece.mesh).unwrap().0.is_sound());
        assert!(piece.mesh.positions.iter().all(|p| p.z >= 0.0));
        assert!(!piece.notes.is_empty());
    }
}
