//! Half-edge mesh of a patch that can be flipped, split and collapsed in place.

use glam::DVec3;
use rustc_hash::{FxBuildHasher, FxHashMap};

use super::StitchError;

/// Marks a missing half-edge, a removed face, or a vertex without original.
pub(super) const NONE: u32 = u32::MAX;

/// A manifold triangle mesh with simple boundary loops, as a corner table.
///
/// Half-edge `3 f + k` runs from corner `k` of face `f` to the next corner. A rim vertex at which the patch has several sectors
/// occurs once for each of them ("rim corner"), so that the boundary loops stay simple; [`PatchMesh::origin`] has the vertex of
/// the input mesh. Rim corners come first and never move.
#[derive(Clone, Debug, Default)]
pub(super) struct PatchMesh {
    /// Positions relative to the patch's centre.
    pub(super) position: Vec<DVec3>,
    /// Unit normals of the smooth surface, outward.
    pub(super) normal: Vec<DVec3>,
    /// Target edge length at each vertex.
    pub(super) size: Vec<f64>,
    /// The input vertex of each rim corner.
    pub(super) origin: Vec<u32>,
    /// Faces; a removed one has `u32::MAX` in all corners.
    pub(super) faces: Vec<[u32; 3]>,
    /// The opposite half-edge; `u32::MAX` along the rim.
    twin: Vec<u32>,
    /// One half-edge out of each vertex; for a rim corner, the one along the rim. `u32::MAX` for removed vertices.
    out: Vec<u32>,
}

impl PatchMesh {
    /// Computes the connectivity of the faces.
    ///
    /// Fails if an edge would have more than two faces, or two faces of different orientation.
    pub(super) fn connect(&mut self) -> Result<(), StitchError> {
        self.faces.retain(|f| f[0] != NONE);
        let mut by_edge = FxHashMap::with_capacity_and_hasher(self.faces.len() * 3, FxBuildHasher);
        for (f, face) in self.faces.iter().enumerate() {
            for k in 0..3 {
                let edge = (face[k], face[(k + 1) % 3]);
                if edge.0 == edge.1 || by_edge.insert(edge, (3 * f + k) as u32).is_some() {
                    return Err(StitchError::NotManifold {
                        position: self.position[edge.0 as usize],
                    });
                }
            }
        }
        self.twin = vec![NONE; self.faces.len() * 3];
        self.out = vec![NONE; self.position.len()];
        for (f, face) in self.faces.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                let h = 3 * f + k;
                self.twin[h] = by_edge.get(&(b, a)).copied().unwrap_or(NONE);
                if self.out[a as usize] == NONE || self.twin[h] == NONE {
                    self.out[a as usize] = h as u32;
                }
            }
        }
        self.check_fans()
    }

    /// Fails if the faces of a vertex are not a single fan.
    fn check_fans(&self) -> Result<(), StitchError> {
        let mut valence = vec![0usize; self.position.len()];
        self.faces
            .iter()
            .flatten()
            .for_each(|&v| valence[v as usize] += 1);
        for (v, &n) in valence.iter().enumerate() {
            if n > 0 && self.outgoing(v as u32).take(n + 1).count() != n {
                return Err(StitchError::NotManifold {
                    position: self.position[v],
                });
            }
        }
        Ok(())
    }

    /// The position of a vertex on the border; none if the mesh is closed.
    pub(super) fn on_border(&self) -> Option<DVec3> {
        let open = self.twin.iter().position(|t| *t == NONE)?;
        Some(self.position[self.from(open as u32) as usize])
    }

    /// Number of rim corners; the vertices after them are free.
    pub(super) fn rim_len(&self) -> usize {
        self.origin.len()
    }

    pub(super) fn is_rim(&self, v: u32) -> bool {
        (v as usize) < self.origin.len()
    }

    pub(super) fn is_used(&self, v: u32) -> bool {
        self.out[v as usize] != NONE
    }

    pub(super) fn from(&self, h: u32) -> u32 {
        self.faces[h as usize / 3][h as usize % 3]
    }

    pub(super) fn to(&self, h: u32) -> u32 {
        self.from(next(h))
    }

    pub(super) fn twin(&self, h: u32) -> Option<u32> {
        Some(self.twin[h as usize]).filter(|&t| t != NONE)
    }

    /// The half-edges out of `v`, counter-clockwise; for a rim corner from one rim edge to the other.
    pub(super) fn outgoing(&self, v: u32) -> Outgoing<'_> {
        Outgoing {
            mesh: self,
            start: self.out[v as usize],
            at: self.out[v as usize],
        }
    }

    /// The neighbours of `v`.
    pub(super) fn neighbours(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let mut last = None;
        let mut fan = self.outgoing(v);
        std::iter::from_fn(move || match fan.next() {
            Some(h) => {
                last = self.is_rim(v).then_some(prev(h));
                Some(self.to(h))
            }
            None => last
                .take()
                .filter(|&p| self.twin[p as usize] == NONE)
                .map(|p| self.from(p)),
        })
    }

    /// Half-edges of all interior edges, each edge once.
    pub(super) fn interior_edges(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.twin.len() as u32).filter(|&h| {
            self.faces[h as usize / 3][0] != NONE
                && self.twin[h as usize] != NONE
                && h < self.twin[h as usize]
        })
    }

    /// Whether two vertices are joined by an edge. The two fans are walked in turns, until the smaller one ends: rims of thousands of
    /// edges make vertices with as many neighbours.
    pub(super) fn has_edge(&self, a: u32, b: u32) -> bool {
        let (mut of_a, mut of_b) = (self.neighbours(a), self.neighbours(b));
        loop {
            match (of_a.next(), of_b.next()) {
                (Some(n), _) if n == b => return true,
                (_, Some(n)) if n == a => return true,
                (Some(_), Some(_)) => {}
                _ => return false,
            }
        }
    }

    /// Whether a vertex has more faces than it needs: one at a rim, three elsewhere.
    pub(super) fn has_spare_face(&self, v: u32) -> bool {
        let least = if self.is_rim(v) { 1 } else { 3 };
        self.outgoing(v).nth(least).is_some()
    }

    pub(super) fn area_vector(&self, face: [u32; 3]) -> DVec3 {
        crate::mesh::area_vector(face.map(|v| self.position[v as usize]))
    }

    pub(super) fn length(&self, h: u32) -> f64 {
        self.position[self.from(h) as usize].distance(self.position[self.to(h) as usize])
    }

    /// The half-edge along the rim out of a rim corner; `None` for a vertex without one.
    pub(super) fn rim_edge(&self, v: u32) -> Option<u32> {
        let used = self.is_used(v).then(|| self.outgoing(v).next())?;
        used.filter(|&h| self.twin(h).is_none())
    }

    /// Mean length of the edges out of `v`.
    pub(super) fn mean_length(&self, v: u32) -> f64 {
        let (sum, count) = self.outgoing(v).fold((0.0, 0.0), |(sum, count), h| {
            (sum + self.length(h), count + 1.0)
        });
        sum / count
    }

    /// The neighbourhood of an edge a → b and its twin: the corners a, b, c (of the face of `h`), d (of the twin's), and the
    /// opposite half-edges of bc, ca, ad, db.
    fn diamond(&self, h: u32, t: u32) -> ([u32; 4], [u32; 4]) {
        let corners = [h, next(h), prev(h), prev(t)].map(|e| self.from(e));
        let outside = [next(h), prev(h), next(t), prev(t)].map(|e| self.twin[e as usize]);
        (corners, outside)
    }

    /// Flips the edge in its two faces; the new edge must not exist yet.
    pub(super) fn flip(&mut self, h: u32) {
        let Some(t) = self.twin(h) else { return };
        let ([a, b, c, d], [bc, ca, ad, db]) = self.diamond(h, t);
        let (f, g) = (h / 3 * 3, t / 3 * 3);
        self.faces[f as usize / 3] = [a, d, c];
        self.faces[g as usize / 3] = [d, b, c];
        self.glue(f, ad);
        self.glue(f + 1, g + 2);
        self.glue(f + 2, ca);
        self.glue(g, db);
        self.glue(g + 1, bc);
        for (v, old, new) in [
            (a, [f, g], f),
            (b, [f, g], g + 1),
            (c, [f, g], f + 2),
            (d, [f, g], g),
        ] {
            if old.contains(&(self.out[v as usize] / 3 * 3)) {
                self.out[v as usize] = new;
            }
        }
    }

    /// Splits an interior edge with a new vertex, and returns the vertex.
    pub(super) fn split(&mut self, h: u32, position: DVec3, normal: DVec3, size: f64) -> u32 {
        let m = self.position.len() as u32;
        let Some(t) = self.twin(h) else { return NONE };
        self.position.push(position);
        self.normal.push(normal);
        self.size.push(size);
        // The two faces, a b c and b a d, and the opposite half-edges of their outer edges.
        let ([a, b, c, d], [bc, ca, ad, db]) = self.diamond(h, t);
        let (f, g) = (h / 3 * 3, t / 3 * 3);
        let (f2, g2) = (self.twin.len() as u32, self.twin.len() as u32 + 3);
        self.twin.extend([NONE; 6]);
        // Each face becomes two at the new vertex m: one replaces it, one is appended.
        self.faces[f as usize / 3] = [a, m, c];
        self.faces[g as usize / 3] = [m, a, d];
        self.faces.extend([[m, b, c], [b, m, d]]);
        // Pairs of opposite half-edges.
        for (x, y) in [
            (f, g),
            (f + 1, f2 + 2),
            (f + 2, ca),
            (g + 1, ad),
            (g + 2, g2 + 1),
            (f2, g2),
            (f2 + 1, bc),
            (g2 + 2, db),
        ] {
            self.glue(x, y);
        }
        self.out.push(f2);
        // If a corner's outgoing half-edge was in one of the two faces, it gets one that still leaves it; at a rim corner, the
        // one along the rim.
        for (v, new) in [
            (
                a,
                if self.twin[g as usize + 1] == NONE {
                    g + 1
                } else {
                    f
                },
            ),
            (b, if bc == NONE { f2 + 1 } else { g2 }),
            (c, f + 2),
            (d, g2 + 2),
        ] {
            if [f, g].contains(&(self.out[v as usize] / 3 * 3)) {
                self.out[v as usize] = new;
            }
        }
        m
    }

    /// Whether the free vertex `from(h)` can be merged into `to(h)` without a change of topology.
    pub(super) fn can_collapse(&self, h: u32) -> bool {
        let Some(t) = self.twin(h) else { return false };
        let (u, v, c, d) = (
            self.from(h),
            self.to(h),
            self.from(prev(h)),
            self.from(prev(t)),
        );
        if self.is_rim(u) || c == d {
            return false;
        }
        if !self.has_spare_face(c) || !self.has_spare_face(d) {
            return false;
        }
        self.neighbours(u)
            .all(|n| n == v || n == c || n == d || !self.has_edge(n, v))
    }

    /// Merges `from(h)` into `to(h)`; [`PatchMesh::can_collapse`] must hold.
    pub(super) fn collapse(&mut self, h: u32) {
        let Some(t) = self.twin(h) else { return };
        let (u, v, c, d) = (
            self.from(h),
            self.to(h),
            self.from(prev(h)),
            self.from(prev(t)),
        );
        let fan: Vec<u32> = self.outgoing(u).collect();
        for g in fan {
            self.faces[g as usize / 3][g as usize % 3] = v;
        }
        let (vc, cu) = (self.twin[next(h) as usize], self.twin[prev(h) as usize]);
        let (ud, dv) = (self.twin[next(t) as usize], self.twin[prev(t) as usize]);
        self.glue(cu, vc);
        self.glue(ud, dv);
        let gone = [h / 3, t / 3];
        for f in gone {
            self.faces[f as usize] = [NONE; 3];
        }
        self.out[u as usize] = NONE;
        // Outgoing half-edges of v, c and d next to the removed faces; a half-edge along the rim comes first.
        let at = |x: u32| next(x);
        self.restart(v, gone, [dv, if cu == NONE { NONE } else { cu }]);
        self.restart(c, gone, [vc, if cu == NONE { NONE } else { at(cu) }]);
        self.restart(d, gone, [ud, if dv == NONE { NONE } else { at(dv) }]);
    }

    /// Gives `v` a new outgoing half-edge if its own was removed.
    fn restart(&mut self, v: u32, gone: [u32; 2], candidates: [u32; 2]) {
        if self.out[v as usize] != NONE && !gone.contains(&(self.out[v as usize] / 3)) {
            return;
        }
        let mut at = candidates
            .into_iter()
            .find(|&h| h != NONE && self.from(h) == v)
            .unwrap_or(NONE);
        // Turn clockwise until the rim.
        let first = at;
        while at != NONE && self.is_rim(v) {
            match self.twin(at) {
                Some(t) if next(t) != first => at = next(t),
                _ => break,
            }
        }
        self.out[v as usize] = at;
    }

    /// Makes two half-edges opposite to each other.
    fn glue(&mut self, x: u32, y: u32) {
        if x != NONE {
            self.twin[x as usize] = y;
        }
        if y != NONE {
            self.twin[y as usize] = x;
        }
    }

    /// Removes deleted faces and vertices; the others keep their order.
    pub(super) fn compact(&mut self) {
        // Moves the used vertices together.
        let mut vertex = vec![NONE; self.position.len()];
        let mut kept = 0;
        for (v, number) in vertex.iter_mut().enumerate() {
            if v < self.rim_len() || self.out[v] != NONE {
                *number = kept as u32;
                self.position[kept] = self.position[v];
                self.normal[kept] = self.normal[v];
                self.size[kept] = self.size[v];
                self.out[kept] = self.out[v];
                kept += 1;
            }
        }
        self.position.truncate(kept);
        self.normal.truncate(kept);
        self.size.truncate(kept);
        self.out.truncate(kept);
        // Moves the remaining faces together, and renumbers half-edges.
        let mut half_edge = vec![NONE; self.twin.len()];
        let mut faces = 0;
        for f in 0..self.faces.len() {
            if self.faces[f][0] != NONE {
                for k in 0..3 {
                    half_edge[3 * f + k] = (3 * faces + k) as u32;
                    self.twin[3 * faces + k] = self.twin[3 * f + k];
                }
                self.faces[faces] = self.faces[f].map(|v| vertex[v as usize]);
                faces += 1;
            }
        }
        self.faces.truncate(faces);
        self.twin.truncate(3 * faces);
        for h in self
            .twin
            .iter_mut()
            .chain(&mut self.out)
            .filter(|h| **h != NONE)
        {
            *h = half_edge[*h as usize];
        }
    }
}

pub(super) fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

pub(super) fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

/// Iterator of [`PatchMesh::outgoing`].
pub(super) struct Outgoing<'a> {
    mesh: &'a PatchMesh,
    start: u32,
    at: u32,
}

impl Iterator for Outgoing<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        if self.at == NONE {
            return None;
        }
        let h = self.at;
        self.at = self.mesh.twin[prev(h) as usize];
        if self.at == self.start {
            self.at = NONE;
        }
        Some(h)
    }
}
