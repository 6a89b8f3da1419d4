//! A remark on components that are inside out and got patches: a patch follows the faces around it.

use glam::DVec3;

use isomend_core::elementary::powf;
use isomend_core::mesh::{DisjointSets, Mesh, area_vector, bounds};

/// Fraction of its area by which a closed component's area vectors may fail to cancel: its other holes.
const OPEN: f64 = 0.05;

/// Area to the power of 3/2. A closed component with less volume is no body.
const LEAST_VOLUME: f64 = 1e-3;

/// Sums over a component.
#[derive(Clone, Copy)]
struct Sums {
    area: f64,
    vector: DVec3,
    /// With a sign; relative to the first point of the mesh.
    volume: f64,
    low: DVec3,
    high: DVec3,
    has_new: bool,
}

impl Sums {
    fn is_closed(&self) -> bool {
        self.vector.length() <= OPEN * self.area
    }

    fn is_inside_out(&self) -> bool {
        self.has_new && self.is_closed() && self.volume < -LEAST_VOLUME * powf(self.area, 1.5)
    }

    /// Whether the box of a component is in the box of this one. What lies inside another body may be a cavity.
    fn holds(&self, inner: &Self) -> bool {
        self.low.cmple(inner.low).all() && self.high.cmpge(inner.high).all()
    }
}

/// A remark on the closed components with faces from `kept` on that are inside out and do not lie inside others; none if there are none.
pub(super) fn note(mesh: &Mesh, kept: usize) -> Option<String> {
    if kept >= mesh.faces.len() {
        return None;
    }
    let all = sums(mesh, kept);
    let is_inner = |i: usize| (all.iter().enumerate()).any(|(k, c)| k != i && c.holds(&all[i]));
    let wrong = |i: &usize| all[*i].is_inside_out() && !is_inner(*i);
    let count = (0..all.len()).filter(wrong).count();
    match count {
        0 => None,
        1 => Some("1 component with new faces is inside out, as in the input: its faces show the inside; isomend repair reverses it".to_owned()),
        n => Some(format!("{n} components with new faces are inside out, as in the input: their faces show the inside; isomend repair reverses them")),
    }
}

fn sums(mesh: &Mesh, kept: usize) -> Vec<Sums> {
    let mut sets = DisjointSets::new(mesh.positions.len());
    for [a, b, c] in &mesh.faces {
        sets.join(*a, *b);
        sets.join(*b, *c);
    }
    let origin = mesh.positions.first().copied().unwrap_or_default();
    let mut place = vec![usize::MAX; mesh.positions.len()];
    let mut all: Vec<Sums> = Vec::new();
    for (f, face) in mesh.faces.iter().enumerate() {
        let own = &mut place[sets.find(face[0]) as usize];
        let corners = face.map(|v| mesh.positions[v as usize]);
        let (low, high) = bounds(corners);
        if *own == usize::MAX {
            *own = all.len();
            all.push(Sums {
                area: 0.0,
                vector: DVec3::ZERO,
                volume: 0.0,
                low,
                high,
                has_new: false,
            });
        }
        let sum = &mut all[*own];
        let vector = 0.5 * area_vector(corners);
        sum.area += vector.length();
        sum.vector += vector;
        sum.volume += (corners[0] - origin).dot(vector) / 3.0;
        sum.low = sum.low.min(low);
        sum.high = sum.high.max(high);
        sum.has_new |= f >= kept;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use isomend_core::mesh::shapes::{grid, icosphere};

    fn reversed(mut mesh: Mesh) -> Mesh {
        mesh.faces.iter_mut().for_each(|f| f.swap(1, 2));
        mesh
    }

    #[test]
    fn bodies_inside_out_are_counted() {
        let ball = icosphere(2);
        let kept = ball.faces.len() - 3;
        assert_eq!(note(&ball, kept), None);
        assert!(note(&reversed(ball.clone()), kept).is_some_and(|n| n.starts_with("1 component ")));
        assert_eq!(note(&reversed(ball.clone()), ball.faces.len()), None);
        // A cavity.
        let cavity = reversed(ball.clone());
        let outer = ball.positions.iter().map(|p| 3.0 * *p);
        let mut hollow = Mesh::new(outer.collect(), ball.faces.clone());
        let count = hollow.positions.len() as u32;
        hollow.positions.extend(&cavity.positions);
        hollow
            .faces
            .extend(cavity.faces.iter().map(|f| f.map(|v| v + count)));
        assert_eq!(note(&hollow, 2 * ball.faces.len() - 3), None);
        // A sheet has no inside.
        let sheet = grid(6, 6, [false; 2], |u, v| DVec3::new(u, v, -5.0));
        assert_eq!(note(&sheet, 3), None);
    }
}
