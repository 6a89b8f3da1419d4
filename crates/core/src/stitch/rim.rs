//! The rim: boundary loops in the direction of the patch, traced so that each loop bounds a single gap.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::{StitchError, StitchInput};
use crate::elementary::{angle_between, atan2};
use crate::mesh::area_vector;

/// The mesh face on the other side of a rim edge.
#[derive(Clone, Copy)]
pub(super) struct Beyond {
    /// Unit normal of the face.
    pub(super) normal: DVec3,
    /// The vertex of the face that is not on the edge.
    pub(super) apex: DVec3,
}

/// The rim loops of a region, and properties of the mesh at the rim.
#[derive(Default)]
pub(super) struct Rims {
    /// Loops of mesh vertices; a vertex occurs once for each gap that it bounds.
    pub(super) loops: Vec<Vec<u32>>,
    /// For each loop, the input loop that its first edge comes from.
    pub(super) source: Vec<usize>,
    /// Edges of the mesh between rim vertices, the smaller index first.
    pub(super) edges: FxHashSet<(u32, u32)>,
    /// Unit normal of the surface at each rim vertex.
    pub(super) normal: FxHashMap<u32, DVec3>,
    /// Mean length of the mesh's edges at each rim vertex.
    pub(super) length: FxHashMap<u32, f64>,
    /// The mesh face next to each directed rim edge.
    pub(super) beyond: FxHashMap<(u32, u32), Beyond>,
    /// Mean dihedral angle (deviation from flat) at the mesh's edges at rim vertices, in radians; `None` without such edges.
    pub(super) angle_around: Option<f64>,
}

impl Rims {
    pub(super) fn new(input: &StitchInput) -> Result<Self, StitchError> {
        validate(input)?;
        let mut rims = around_rim(input)?;
        let edges = directed_edges(input, &rims)?;
        (rims.loops, rims.source) = trace(input, &rims, &edges);
        if rims.loops.is_empty() {
            return Err(StitchError::NoLoops);
        }
        Ok(rims)
    }

    pub(super) fn has_edge(&self, a: u32, b: u32) -> bool {
        self.edges.contains(&(a.min(b), a.max(b)))
    }
}

/// Checks indices and numbers of the input.
fn validate(input: &StitchInput) -> Result<(), StitchError> {
    let len = input.mesh.positions.len();
    let check = |what: &'static str, v: u32, len: usize| {
        if (v as usize) < len {
            Ok(())
        } else {
            Err(StitchError::Index {
                what: what.into(),
                vertex: v,
                len,
            })
        }
    };
    // Rim loops: existing vertices at finite positions.
    for &v in input.loops.iter().flatten() {
        check("a rim loop", v, len)?;
        if !input.mesh.positions[v as usize].is_finite() {
            return Err(StitchError::Number {
                what: "a rim vertex".into(),
            });
        }
    }
    // Faces of the mesh and of the extracted surface: existing vertices.
    input
        .mesh
        .faces
        .iter()
        .flatten()
        .try_for_each(|&v| check("a face of the mesh", v, len))?;
    let extracted = input.extracted;
    extracted
        .faces
        .iter()
        .flatten()
        .try_for_each(|&v| check("an extracted face", v, extracted.positions.len()))?;
    // Lengths and factors: finite and positive; depth and compensation: finite.
    let p = &input.params;
    let positive = [input.voxel, p.edge_factor, p.chord_error];
    if positive.iter().any(|v| !v.is_finite() || *v <= 0.0) {
        return Err(StitchError::Number {
            what: "the voxel, the edge factor or the chord error".into(),
        });
    }
    if !p.cut_depth.is_finite() || !p.facet_compensation.is_finite() {
        return Err(StitchError::Number {
            what: "the cut depth or the facet compensation".into(),
        });
    }
    Ok(())
}

/// Normals, edges and edge lengths of the mesh at the rim vertices.
fn around_rim(input: &StitchInput) -> Result<Rims, StitchError> {
    let on_rim: FxHashSet<u32> = input.loops.iter().flatten().copied().collect();
    let at = |v: u32| input.mesh.positions[v as usize];
    // Sums over the faces of the mesh that have a rim vertex.
    let mut edges = FxHashSet::default();
    let mut beyond = FxHashMap::default();
    let mut first_normal: FxHashMap<(u32, u32), DVec3> = FxHashMap::default();
    let mut angles = Vec::new();
    let mut length: FxHashMap<u32, (f64, f64)> = FxHashMap::default();
    let mut sum: FxHashMap<u32, DVec3> = FxHashMap::default();
    for f in input
        .mesh
        .faces
        .iter()
        .filter(|f| f.iter().any(|v| on_rim.contains(v)))
    {
        let n = area_vector(f.map(at));
        for k in 0..3 {
            let (a, b) = (f[k], f[(k + 1) % 3]);
            // The angle at an edge, computed at the second of its faces.
            if on_rim.contains(&a) || on_rim.contains(&b) {
                match first_normal.remove(&(b, a)) {
                    Some(other) if n.length() * other.length() > 0.0 => {
                        angles.push(angle_between(n, other));
                    }
                    Some(_) => {}
                    None => _ = first_normal.insert((a, b), n),
                }
            }
            // Lengths and area vectors at each rim vertex, for the mean edge length and the normal.
            for v in [a, b].into_iter().filter(|v| on_rim.contains(v)) {
                let l = length.entry(v).or_default();
                *l = (l.0 + at(a).distance(at(b)), l.1 + 1.0);
            }
            if on_rim.contains(&a) {
                *sum.entry(a).or_default() += n;
            }
            // An edge between rim vertices; a patch on its other side uses it from b to a.
            if on_rim.contains(&a) && on_rim.contains(&b) {
                edges.insert((a.min(b), a.max(b)));
                let (normal, apex) = (n.normalize_or_zero(), at(f[(k + 2) % 3]));
                beyond.insert((b, a), Beyond { normal, apex });
            }
        }
    }
    let normal = on_rim.iter().map(|&v| {
        let area = sum.get(&v).copied().unwrap_or_default();
        (v, normal_at(input, v, area))
    });
    Ok(Rims {
        loops: Vec::new(),
        source: Vec::new(),
        edges,
        normal: normal.collect(),
        length: length
            .into_iter()
            .map(|(v, (sum, n))| (v, sum / n))
            .collect(),
        beyond,
        angle_around: (!angles.is_empty())
            .then(|| angles.iter().sum::<f64>() / angles.len() as f64),
    })
}

/// The normal of the surface at a rim vertex; the normal of the mesh if the two point to opposite sides.
fn normal_at(input: &StitchInput, v: u32, area: DVec3) -> DVec3 {
    let of_mesh = area.normalize_or_zero();
    let at = input.mesh.positions[v as usize];
    let of_surface = input.surface.project(at).map(|(_, n)| n);
    of_surface
        .filter(|n| n.dot(of_mesh) >= 0.0)
        .unwrap_or(of_mesh)
}

/// The directed rim edges, each with its input loop. Fails for an edge that is not on the boundary of the mesh in this direction
/// or occurs twice.
fn directed_edges(
    input: &StitchInput,
    rims: &Rims,
) -> Result<BTreeMap<(u32, u32), usize>, StitchError> {
    let mut edges = BTreeMap::new();
    for (rim, lp) in input.loops.iter().enumerate() {
        for (i, &from) in lp.iter().enumerate() {
            let to = lp[(i + 1) % lp.len()];
            let open =
                rims.beyond.contains_key(&(from, to)) && !rims.beyond.contains_key(&(to, from));
            if from == to || !open || edges.insert((from, to), rim).is_some() {
                return Err(StitchError::NotOnBoundary { rim, from, to });
            }
        }
    }
    Ok(edges)
}

/// Traces the rim; at a vertex with several gaps, each loop stays within its own gap.
fn trace(
    input: &StitchInput,
    rims: &Rims,
    edges: &BTreeMap<(u32, u32), usize>,
) -> (Vec<Vec<u32>>, Vec<usize>) {
    let next = turns(input, rims, edges);
    let mut left = edges.clone();
    let (mut loops, mut source) = (Vec::new(), Vec::new());
    while let Some((&start, &rim)) = left.iter().next() {
        let mut lp = Vec::new();
        let mut at = start;
        while left.remove(&at).is_some() {
            lp.push(at.0);
            at = (at.1, next[&at]);
        }
        loops.push(lp);
        source.push(rim);
    }
    (loops, source)
}

/// For each directed rim edge, the vertex after its end.
///
/// A gap extends counter-clockwise from its outgoing rim edge to its incoming one; so a loop leaves a vertex by the first rim
/// edge clockwise from the one by which it arrives. If angles contradict each other, every edge still gets exactly one successor.
fn turns(
    input: &StitchInput,
    rims: &Rims,
    edges: &BTreeMap<(u32, u32), usize>,
) -> FxHashMap<(u32, u32), u32> {
    let mut at: BTreeMap<u32, (Vec<u32>, Vec<u32>)> = BTreeMap::new();
    for &(a, b) in edges.keys() {
        at.entry(a).or_default().1.push(b);
        at.entry(b).or_default().0.push(a);
    }
    let mut next = FxHashMap::default();
    for (v, (incoming, outgoing)) in at {
        let mut pairs: Vec<(f64, u32, u32)> = Vec::new();
        for &a in &incoming {
            pairs.extend(
                outgoing
                    .iter()
                    .map(|&b| (clockwise(input, rims, v, a, b), a, b)),
            );
        }
        pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        let mut taken = FxHashSet::default();
        for (_, a, b) in pairs {
            if !next.contains_key(&(a, v)) && taken.insert(b) {
                next.insert((a, v), b);
            }
        }
    }
    next
}

/// The clockwise angle from `a` to `b` at `at`, seen from the tip of the normal.
fn clockwise(input: &StitchInput, rims: &Rims, at: u32, a: u32, b: u32) -> f64 {
    let p = |v: u32| input.mesh.positions[v as usize];
    let n = rims.normal[&at];
    let x = if n == DVec3::ZERO {
        DVec3::X
    } else {
        n.any_orthonormal_vector()
    };
    let y = n.cross(x);
    let angle = |v: u32| atan2((p(v) - p(at)).dot(y), (p(v) - p(at)).dot(x));
    if a == b {
        TAU
    } else {
        (angle(a) - angle(b)).rem_euclid(TAU)
    }
}
