//! A mesh whose marked faces are cut out, and the holes that this leaves.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::{Inspection, RestoreError, inspect};
use crate::mesh::cut::{Remainder, settled};
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{Mesh, weld_map};
use crate::params::{FillParams, SurfaceKind};

/// Marked pieces of at most this many faces go without being replaced.
const CRUMB_FACES: usize = 2;

/// An edge between vertices of the welded input, the smaller number first.
type Edge = (u32, u32);

/// A cut, and what it left.
pub(super) struct Opening<'a> {
    /// The mesh before the cut.
    pub(super) before: &'a Inspection,
    /// Which faces were taken out: the marked ones, and those without which there would be no clean rim.
    pub(super) removed: Vec<bool>,
    /// The mesh after it.
    pub(super) kept: Remainder,
    /// Its holes.
    pub(super) found: Inspection,
    /// The numbers of the holes that the cut made or changed.
    made: Vec<usize>,
    /// For each hole the part of what was cut out that it bounds, as indices of `bounds`.
    part: Vec<Option<usize>>,
    /// The bounding boxes of the connected parts of what was cut out.
    bounds: Vec<(DVec3, DVec3)>,
}

impl<'a> Opening<'a> {
    /// Cuts the marked faces out of a mesh that was inspected, and small parts left inside too if asked.
    pub(super) fn new(
        mesh: &Mesh,
        before: &'a Inspection,
        marked: &[bool],
        keep_vertices: bool,
        small_parts: bool,
    ) -> Result<Self, RestoreError> {
        let removed = settled(&before.mesh, &before.topology, marked, small_parts);
        refuse_whole_pieces(before, &removed)?;
        let kept = Remainder::new(mesh, &removed, keep_vertices);
        let found = inspect(&kept.mesh)?;
        let weld = weld_map(mesh);
        let origin: Vec<u32> = (0..weld.len())
            .filter(|&v| kept.vertices[v])
            .map(|v| weld[v])
            .collect();
        let rims: Vec<Vec<Edge>> = found.holes.iter().map(|h| edges(&h.rim, &origin)).collect();
        let made = made(mesh, before, &found, &rims)?;
        let (of_edge, bounds) = parts(before, &removed);
        let part = rims
            .iter()
            .map(|rim| rim.iter().find_map(|e| of_edge.get(e).copied()))
            .collect();
        Ok(Self {
            before,
            removed,
            kept,
            found,
            made,
            part,
            bounds,
        })
    }

    /// Those of a fill of what the cut left open.
    pub(super) fn params(&self, fill: &FillParams) -> FillParams {
        FillParams {
            holes: Some(self.made.clone()),
            max_diameter: None,
            keep_open: Vec::new(),
            bridge: self.bridges(),
            surface: SurfaceKind::Stitched,
            ..fill.clone()
        }
    }

    /// Holes that bound the same connected part of what was cut out: they are filled together.
    fn bridges(&self) -> Vec<Vec<usize>> {
        let mut of_part: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for &id in &self.made {
            if let Some(part) = self.part[id - 1] {
                of_part.entry(part).or_default().push(id);
            }
        }
        of_part.into_values().filter(|ids| ids.len() > 1).collect()
    }

    /// For each hole the bounding box of what was cut out at it.
    pub(super) fn extents(&self) -> Vec<Option<(DVec3, DVec3)>> {
        let bounds = |part: &Option<usize>| part.map(|p| self.bounds[p]);
        self.part.iter().map(bounds).collect()
    }
}

fn key(v: u32, w: u32) -> Edge {
    (v.min(w), v.max(w))
}

/// The edges of a rim, by the numbers of the welded input.
fn edges(rim: &[u32], origin: &[u32]) -> Vec<Edge> {
    let next = rim.iter().cycle().skip(1);
    rim.iter()
        .zip(next)
        .map(|(&v, &w)| key(origin[v as usize], origin[w as usize]))
        .collect()
}

/// Pieces but crumbs must keep some faces.
fn refuse_whole_pieces(before: &Inspection, removed: &[bool]) -> Result<(), RestoreError> {
    let mut left = before.topology.piece_faces.clone();
    for (&piece, _) in before
        .topology
        .piece
        .iter()
        .zip(removed)
        .filter(|(_, r)| **r)
    {
        if piece != NONE {
            left[piece as usize] -= 1;
        }
    }
    let sizes = before.topology.piece_faces.iter().zip(&left);
    let whole = sizes.filter(|(all, left)| **left == 0 && **all > CRUMB_FACES);
    match whole.map(|(all, _)| *all).max() {
        Some(faces) => Err(RestoreError::WholePiece { faces }),
        None if left.iter().all(|l| *l == 0) => Err(RestoreError::WholePiece {
            faces: removed.len(),
        }),
        None => Ok(()),
    }
}

/// The numbers of the holes that the cut made or changed.
fn made(
    mesh: &Mesh,
    before: &Inspection,
    found: &Inspection,
    rims: &[Vec<Edge>],
) -> Result<Vec<usize>, RestoreError> {
    let old: BTreeSet<Edge> = (0..before.topology.boundary.len() as u32)
        .filter(|&h| before.topology.boundary[h as usize])
        .map(|h| key(start(&before.mesh, h), end(&before.mesh, h)))
        .collect();
    let own: Vec<u32> = (0..before.mesh.positions.len() as u32).collect();
    let outer: BTreeSet<Edge> = before
        .holes
        .iter()
        .filter(|h| h.outer_border)
        .flat_map(|h| edges(&h.rim, &own))
        .collect();
    let mut ids = Vec::new();
    for (hole, rim) in found.holes.iter().zip(rims) {
        if rim.iter().all(|e| old.contains(e)) {
            continue;
        }
        if let Some(edge) = rim.iter().find(|e| outer.contains(e)) {
            let p = mesh.positions[edge.0 as usize];
            return Err(RestoreError::Border {
                x: p.x,
                y: p.y,
                z: p.z,
            });
        }
        ids.push(hole.id);
    }
    Ok(ids)
}

/// The connected parts of what is cut out: the part at each edge along the cut, and their bounding boxes.
fn parts(before: &Inspection, removed: &[bool]) -> (BTreeMap<Edge, usize>, Vec<(DVec3, DVec3)>) {
    let (mesh, topology) = (&before.mesh, &before.topology);
    let (mut of_edge, mut bounds) = (BTreeMap::new(), Vec::new());
    let mut seen = vec![false; removed.len()];
    for seed in 0..removed.len() {
        if !removed[seed] || std::mem::replace(&mut seen[seed], true) {
            continue;
        }
        let mut stack = vec![seed];
        let mut around = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        while let Some(f) = stack.pop() {
            for k in 0..3 {
                let h = (3 * f + k) as u32;
                let p = mesh.positions[start(mesh, h) as usize];
                around = (around.0.min(p), around.1.max(p));
                match topology.opposite[h as usize] {
                    NONE => {}
                    other if removed[other as usize / 3] => {
                        if !std::mem::replace(&mut seen[other as usize / 3], true) {
                            stack.push(other as usize / 3);
                        }
                    }
                    _ => {
                        of_edge.insert(key(start(mesh, h), end(mesh, h)), bounds.len());
                    }
                }
            }
        }
        bounds.push(around);
    }
    (of_edge, bounds)
}
