//! Masks: sets of faces selected by position, colour, material or number.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;
use serde::Serialize;
use thiserror::Error;

use super::attributes::{Attribute, Attributes, LabelKind, Role};
use super::{DisjointSets, Mesh, Topology, area_vector, weld_map};

/// One way to select faces.
#[derive(Clone)]
pub enum Selector {
    /// Faces whose centroid is in a box, boundary included.
    Box {
        /// The smallest coordinates, in the mesh's units.
        low: DVec3,
        /// The largest coordinates, in the mesh's units.
        high: DVec3,
    },
    /// Faces whose centroid is in a ball.
    Ball {
        /// Its centre.
        centre: DVec3,
        /// Its radius, in the mesh's units.
        radius: f64,
    },
    /// Faces for whose centroid the function returns true, for example a test for the inside of a closed mesh.
    Inside(std::sync::Arc<dyn Fn(DVec3) -> bool + Send + Sync>),
    /// Faces by their numbers, from 0 in the order of the file.
    Faces(Vec<usize>),
    /// Faces with all vertices close to a colour.
    Colour {
        /// Red, green and blue, from 0 to 1.
        rgb: [f64; 3],
        /// Maximum difference of each of the three.
        tolerance: f64,
    },
    /// Faces with a material.
    Material(String),
}

/// A set of faces: the union of the selectors' faces, then grown and shrunk.
#[derive(Clone, Default)]
pub struct Mask {
    /// The selectors.
    pub selectors: Vec<Selector>,
    /// Adds faces whose vertices are all within this distance of the selection, along edges, in the mesh's units.
    pub grow: f64,
    /// Then removes faces with a vertex closer than this to unselected faces, along edges, in the mesh's units.
    pub shrink: f64,
}

/// Why a mask cannot be applied.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MaskError {
    /// A face number is out of range.
    #[error("the mask names face {face}, but the mesh has {count}, numbered from 0")]
    NoSuchFace {
        /// The number.
        face: usize,
        /// Number of faces.
        count: usize,
    },
    /// A colour is selected, but there are no vertex colours.
    #[error("the mask asks for a colour, but the vertices of the mesh have none")]
    NoColours,
    /// A material is selected that the mesh does not have.
    #[error("the mesh has no material '{name}'; it has {listed}")]
    NoSuchMaterial {
        /// The name.
        name: String,
        /// The materials of the mesh.
        listed: String,
    },
    /// A length or number is invalid.
    #[error("{0}")]
    Parameter(String),
}

impl Mask {
    /// Whether the mask has no selectors.
    pub fn is_empty(&self) -> bool {
        self.selectors.is_empty()
    }

    /// Marks the selected faces.
    ///
    /// Vertices at the same position count as one. Distances for growing and shrinking are lengths of shortest paths along edges;
    /// on regular meshes these are up to about a tenth longer than on the surface.
    ///
    /// # Errors
    /// If the mask refers to a face, colour or material that the mesh does not have, or a length is negative.
    pub fn faces(&self, mesh: &Mesh, attributes: &Attributes) -> Result<Vec<bool>, MaskError> {
        for (length, name) in [(self.grow, "grow"), (self.shrink, "shrink")] {
            if !(length.is_finite() && length >= 0.0) {
                let what = format!("the length to {name} by must not be negative, but is {length}");
                return Err(MaskError::Parameter(what));
            }
        }
        let mut selected = vec![false; mesh.faces.len()];
        for selector in &self.selectors {
            selector.check()?;
            select(selector, mesh, attributes, &mut selected)?;
        }
        if self.grow > 0.0 || self.shrink > 0.0 {
            let paths = Paths::new(mesh);
            if self.grow > 0.0 {
                let distance = paths.distances_from(|f| selected[f]);
                paths.each_face(|f, corners| {
                    selected[f] |= corners.iter().all(|v| distance[*v as usize] <= self.grow);
                });
            }
            if self.shrink > 0.0 {
                let distance = paths.distances_from(|f| !selected[f]);
                paths.each_face(|f, corners| {
                    selected[f] &= corners.iter().all(|v| distance[*v as usize] >= self.shrink);
                });
            }
        }
        Ok(selected)
    }
}

impl Selector {
    /// Checks its numbers, for example that the low corner of a box does not exceed the high one.
    ///
    /// # Errors
    /// [`MaskError::Parameter`] with the axis or the number.
    pub fn check(&self) -> Result<(), MaskError> {
        let bad = |what: String| Err(MaskError::Parameter(what));
        match self {
            Self::Box { low, high } => {
                let sides = low.to_array().into_iter().zip(high.to_array());
                for (axis, (low, high)) in ["x", "y", "z"].into_iter().zip(sides) {
                    if !(low.is_finite() && high.is_finite()) {
                        return bad(format!(
                            "the {axis} of the box must be numbers, but are {low} and {high}"
                        ));
                    }
                    if low > high {
                        return bad(format!(
                            "the box ends before it begins: its low {axis}, {low}, exceeds its high one, {high}; swap them"
                        ));
                    }
                }
                Ok(())
            }
            Self::Ball { centre, radius } if !(centre.is_finite() && radius.is_finite()) => {
                bad("the centre and the radius of the ball must be numbers".to_owned())
            }
            Self::Ball { radius, .. } if *radius <= 0.0 => bad(format!(
                "the radius of the ball must be positive, but is {radius}"
            )),
            Self::Colour { tolerance, .. } if !(0.0..=1.0).contains(tolerance) => bad(format!(
                "the tolerance of a colour must be between 0 and 1, but is {tolerance}"
            )),
            _ => Ok(()),
        }
    }
}

/// Marks the faces that a selector selects.
fn select(
    selector: &Selector,
    mesh: &Mesh,
    attributes: &Attributes,
    selected: &mut [bool],
) -> Result<(), MaskError> {
    let centroid = |f: usize| {
        let [a, b, c] = mesh.faces[f].map(|v| mesh.positions[v as usize]);
        (a + b + c) / 3.0
    };
    let mut mark = |chosen: &dyn Fn(usize) -> bool| {
        for (f, flag) in selected.iter_mut().enumerate() {
            *flag = *flag || chosen(f);
        }
    };
    match selector {
        Selector::Box { low, high } => mark(&|f| {
            let p = centroid(f);
            p.cmpge(*low).all() && p.cmple(*high).all()
        }),
        Selector::Ball { centre, radius } => {
            mark(&|f| centroid(f).distance(*centre) <= *radius);
        }
        Selector::Inside(inside) => mark(&|f| inside(centroid(f))),
        Selector::Faces(numbers) => {
            for &face in numbers {
                let count = selected.len();
                *selected
                    .get_mut(face)
                    .ok_or(MaskError::NoSuchFace { face, count })? = true;
            }
        }
        Selector::Colour { rgb, tolerance } => {
            let colours = attributes
                .vertex_role(Role::Colour)
                .filter(|c| c.components >= 3)
                .ok_or(MaskError::NoColours)?;
            let near = |v: u32| is_near(colours, v as usize, *rgb, *tolerance);
            mark(&|f| mesh.faces[f].iter().all(|v| near(*v)));
        }
        Selector::Material(name) => {
            let labels = attributes.labels_of(LabelKind::Material);
            let labels = labels.filter(|l| l.names.contains(name)).ok_or_else(|| {
                let names = labels.map(|l| format!("'{}'", l.names.join("', '")));
                MaskError::NoSuchMaterial {
                    name: name.clone(),
                    listed: names.unwrap_or_else(|| "none".to_owned()),
                }
            })?;
            mark(&|f| labels.get(f) == Some(name));
        }
    }
    Ok(())
}

/// Whether a colour is within a tolerance of another one in each of red, green and blue, as fractions of 1.
pub fn is_near(colours: &Attribute, item: usize, rgb: [f64; 3], tolerance: f64) -> bool {
    let unit = colours.unit();
    // Slightly more than the tolerance, because 8-bit colours are rounded.
    let most = tolerance + 1e-6;
    let value = colours.get(item);
    value.is_some_and(|c| (0..3).all(|i| (c[i] / unit - rgb[i]).abs() <= most))
}

/// Shortest paths along the edges of a welded mesh.
struct Paths<'a> {
    mesh: &'a Mesh,
    faces: Vec<[u32; 3]>,
    /// Start of the neighbours of each vertex.
    offsets: Vec<u32>,
    /// The neighbours of all vertices; neighbours across inner edges occur twice.
    neighbours: Vec<u32>,
}

impl<'a> Paths<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        let weld = weld_map(mesh);
        let faces: Vec<[u32; 3]> = mesh
            .faces
            .iter()
            .map(|f| f.map(|v| weld[v as usize]))
            .collect();
        let mut offsets = vec![0u32; mesh.positions.len() + 1];
        for v in faces.iter().flatten() {
            offsets[*v as usize + 1] += 2;
        }
        for i in 1..offsets.len() {
            offsets[i] += offsets[i - 1];
        }
        let mut at = offsets.clone();
        let mut neighbours = vec![0; 6 * faces.len()];
        for face in &faces {
            for k in 0..3 {
                let place = &mut at[face[k] as usize];
                neighbours[*place as usize] = face[(k + 1) % 3];
                neighbours[*place as usize + 1] = face[(k + 2) % 3];
                *place += 2;
            }
        }
        Self {
            mesh,
            faces,
            offsets,
            neighbours,
        }
    }

    fn each_face(&self, mut visit: impl FnMut(usize, &[u32; 3])) {
        for (f, corners) in self.faces.iter().enumerate() {
            visit(f, corners);
        }
    }

    /// The distance of each vertex from the selected faces; infinite if not connected.
    fn distances_from(&self, chosen: impl Fn(usize) -> bool) -> Vec<f64> {
        let mut distance = vec![f64::INFINITY; self.mesh.positions.len()];
        let mut queue = BinaryHeap::new();
        self.each_face(|f, corners| {
            for &v in corners.iter().filter(|_| chosen(f)) {
                if distance[v as usize] > 0.0 {
                    distance[v as usize] = 0.0;
                    queue.push(Reverse((0u64, v)));
                }
            }
        });
        // For non-negative numbers the bit patterns sort like the values.
        while let Some(Reverse((bits, v))) = queue.pop() {
            let here = f64::from_bits(bits);
            if here > distance[v as usize] {
                continue;
            }
            let range = self.offsets[v as usize] as usize..self.offsets[v as usize + 1] as usize;
            for &w in &self.neighbours[range] {
                let [p, q] = [v, w].map(|v| self.mesh.positions[v as usize]);
                let new = here + p.distance(q);
                if new < distance[w as usize] {
                    distance[w as usize] = new;
                    queue.push(Reverse((new.to_bits(), w)));
                }
            }
        }
        distance
    }
}

/// Marks the faces with all vertices at least `by` from the boundary, along edges of a welded mesh.
pub fn shrunk_from_borders(mesh: &Mesh, topology: &Topology, by: f64) -> Vec<bool> {
    let paths = Paths::new(mesh);
    let distance = paths.distances_from(|f| (3 * f..3 * f + 3).any(|h| topology.boundary[h]));
    let mut inner = vec![false; mesh.faces.len()];
    paths.each_face(|f, corners| {
        inner[f] = corners.iter().all(|v| distance[*v as usize] >= by);
    });
    inner
}

/// Measures of a selection.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Selection {
    /// Number of faces.
    pub faces: usize,
    /// Total area, in the mesh's units squared.
    pub area: f64,
    /// Number of edge-connected components.
    pub components: usize,
    /// Smallest and largest coordinates; `None` if nothing is selected.
    pub bounds: Option<[DVec3; 2]>,
}

impl Selection {
    /// Measures selected faces.
    ///
    /// # Panics
    /// If the numbers of marks and faces differ.
    pub fn new(mesh: &Mesh, selected: &[bool]) -> Self {
        assert_eq!(selected.len(), mesh.faces.len(), "one mark for each face");
        let weld = weld_map(mesh);
        let faces: Vec<[u32; 3]> = (0..selected.len())
            .filter(|f| selected[*f])
            .map(|f| mesh.faces[f].map(|v| weld[v as usize]))
            .collect();
        let mut area = 0.0;
        let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let bounds = faces.iter().fold(start, |[low, high], face| {
            let [a, b, c] = face.map(|v| mesh.positions[v as usize]);
            area += 0.5 * area_vector([a, b, c]).length();
            [low.min(a).min(b).min(c), high.max(a).max(b).max(c)]
        });
        Self {
            faces: faces.len(),
            area,
            components: count_components(&faces),
            bounds: (!faces.is_empty()).then_some(bounds),
        }
    }
}

/// The number of edge-connected components.
fn count_components(faces: &[[u32; 3]]) -> usize {
    let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * faces.len());
    for (f, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            edges.push((a.min(b), a.max(b), f as u32));
        }
    }
    edges.sort_unstable();
    let mut sets = DisjointSets::new(faces.len());
    let mut count = faces.len();
    for pair in edges.windows(2) {
        let [one, other] = [pair[0], pair[1]];
        if (one.0, one.1) == (other.0, other.1) && sets.join(one.2, other.2) {
            count -= 1;
        }
    }
    count
}

#[cfg(test)]
mod tests;
