//! A fitted counterpart as the surface onto which a patch's vertices are projected.

use glam::DVec3;

use super::judge::Fitted;
use crate::cancel::Cancel;
use crate::fill::problem::RegionProblem;
use crate::mesh::{VertexFaces, face_normal, vertex_normal};
use crate::sdf::{RimSet, Sampler, Surface};

/// The surface of a counterpart, and the distance by which it is cut along the rims of a region.
pub(super) struct CounterpartSurface<'a> {
    fitted: &'a Fitted,
    normals: Vec<DVec3>,
    known: &'a Sampler<'a>,
    rims: RimSet,
    /// The rims' edges, each with the direction in which the surface would continue.
    rim_edges: Vec<([DVec3; 2], DVec3)>,
    cancel: &'a Cancel,
}

impl<'a> CounterpartSurface<'a> {
    pub(super) fn new(problem: &'a RegionProblem<'_>, fitted: &'a Fitted) -> Self {
        let around = VertexFaces::new(&fitted.mesh);
        let vertices = 0..fitted.mesh.positions.len() as u32;
        let at = |v: u32| problem.mesh.positions[v as usize];
        let rim_edges = problem.holes.iter().flat_map(|hole| {
            let next = hole.rim.iter().cycle().skip(1);
            let edges = hole.rim.iter().zip(next).zip(&hole.conormals);
            edges.map(|((&a, &b), &conormal)| ([at(a), at(b)], conormal))
        });
        Self {
            rim_edges: rim_edges.collect(),
            fitted,
            normals: vertices
                .map(|v| vertex_normal(&fitted.mesh, &around, v))
                .collect(),
            known: problem.known,
            rims: RimSet::new(problem.holes.iter().copied()),
            cancel: problem.cancel,
        }
    }
}

impl CounterpartSurface<'_> {
    /// The distance of a point from the rims, negative on the side of the known faces there.
    fn rim_distance(&self, p: DVec3) -> f64 {
        let (mut least, mut side) = (f64::INFINITY, 0.0);
        for ([a, b], conormal) in &self.rim_edges {
            let along = *b - *a;
            let part = (p - *a).dot(along) / along.length_squared();
            let offset = p - (*a + part.clamp(0.0, 1.0) * along);
            let distance = offset.length();
            // At a vertex both of its edges are nearest: the one that the point faces more decides.
            let own = offset.dot(*conormal);
            if distance < least || (distance == least && own.abs() > f64::abs(side)) {
                (least, side) = (distance, own);
            }
        }
        match side > 0.0 {
            true => least,
            false => -least,
        }
    }
}

impl Surface for CounterpartSurface<'_> {
    fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }

    fn project(&self, p: DVec3) -> Option<(DVec3, DVec3)> {
        let closest = self.fitted.bvh.closest(p, f64::INFINITY)?;
        let face = self.fitted.mesh.faces[closest.face as usize];
        let corners = (0..3).map(|k| closest.barycentric[k] * self.normals[face[k] as usize]);
        let normal = corners.sum::<DVec3>().try_normalize()?;
        Some((closest.point, normal))
    }

    fn depth(&self, p: DVec3) -> f64 {
        if self.is_cancelled() {
            return -f64::MAX;
        }
        let Some((closest, on_rim)) = self.known.closest_of_all(&self.rims, p) else {
            return -f64::MAX;
        };
        if on_rim {
            return closest.distance;
        }
        // In thin parts the nearest known face can be of the opposite wall: then the rim alone decides.
        let known = face_normal(self.known.mesh(), closest.face);
        match self.project(p) {
            Some((_, normal)) if normal.dot(known) < 0.0 => self.rim_distance(p),
            _ => -closest.distance,
        }
    }
}
