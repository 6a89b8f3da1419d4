//! Patches unfolded into charts, with the faces across their rims and the texels that they need.

use glam::{DVec2, DVec3};

use super::chart::{Border, Weights, layout};
use super::disk::Disk;
use super::looks::Looks;
use crate::attributes::{Patches, Slot};
use crate::cancel::Cancel;
use crate::mesh::{Mesh, area_vector};

/// Upper bound of the texels per length, over the mean at the rim: the area of a patch on the page grows with the square.
const DENSEST: f64 = 4.0;

/// A patch laid out in a circle.
pub(super) struct Chart {
    /// Its faces among the new ones.
    pub(super) faces: Vec<usize>,
    pub(super) disk: Disk,
    pub(super) points: Vec<DVec3>,
    pub(super) border: Border,
    /// For each edge of the border the mesh's own face across it, with the corners at its ends; nothing on a cut.
    pub(super) across: Vec<Option<(u32, [u8; 2])>>,
    /// The radius in texels that keeps as many of them for a length as there are at the rim.
    pub(super) radius: f64,
    pub(super) places: Vec<DVec2>,
}

impl Chart {
    pub(super) fn new(
        faces: Vec<usize>,
        patches: &Patches,
        filled: &Mesh,
        looks: &Looks<'_>,
        cancel: &Cancel,
    ) -> Result<Self, String> {
        let in_slots: Vec<[u32; 3]> = faces.iter().map(|f| patches.faces[*f]).collect();
        let disk = Disk::cut(&in_slots).ok_or("the patch cannot be cut open into a disk")?;
        let slot = |v: u32| &patches.slots[disk.slots[v as usize] as usize];
        let points: Vec<DVec3> = (0..disk.slots.len() as u32)
            .map(|v| filled.positions[slot(v).vertex as usize])
            .collect();
        let border = Border::new(&disk, &points);
        let across: Vec<Option<(u32, [u8; 2])>> = (0..border.len())
            .map(|edge| {
                let [a, b] = border.ends(edge);
                common_face(slot(a), slot(b))
            })
            .collect();
        let density = density(&across, &border, &points, looks);
        let density = density.ok_or("there is no image round the patch")?;
        let area: f64 = (disk.faces.iter())
            .map(|f| 0.5 * area_vector(f.map(|v| points[v as usize])).length())
            .sum();
        let round = border.length / std::f64::consts::TAU;
        let radius = density * round.max((area / std::f64::consts::PI).sqrt());
        let places = layout(&disk, &points, &border, Weights::MeanValue, cancel);
        Ok(Self {
            faces,
            disk,
            points,
            border,
            across,
            radius,
            places,
        })
    }

    /// Whether a triangle is flipped over once the places of its corners are rounded.
    pub(super) fn is_folded(&self, rounded: impl Fn(DVec2) -> [f64; 2]) -> bool {
        let places: Vec<DVec2> = self.places.iter().map(|p| rounded(*p).into()).collect();
        self.disk.faces.iter().any(|face| {
            let [a, b, c] = face.map(|v| places[v as usize]);
            (b - a).perp_dot(c - a) <= 0.0
        })
    }
}

/// Texels for a length at a rim: as many as nine tenths of it have at most, since charts that meet there may differ widely: at the eyes
/// of the duck of the glTF samples edges of one rim had from 0.2 to 23 texels; but no more than [`DENSEST`] times the mean. Nothing where there are no images.
fn density(
    across: &[Option<(u32, [u8; 2])>],
    border: &Border,
    points: &[DVec3],
    looks: &Looks<'_>,
) -> Option<f64> {
    let mut edges: Vec<[f64; 2]> = Vec::new();
    for (edge, found) in across.iter().enumerate() {
        let texels = found.and_then(|(face, corners)| looks.texels(face, corners));
        let [a, b] = border.ends(edge).map(|v| points[v as usize]);
        let length = a.distance(b);
        edges.extend(
            texels
                .filter(|_| length > 0.0)
                .map(|t| [t / length, length]),
        );
    }
    edges.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let length: f64 = edges.iter().map(|[_, length]| length).sum();
    let mean = edges.iter().map(|[density, l]| density * l).sum::<f64>() / length;
    let mut sum = 0.0;
    let high = edges.iter().find(|[_, l]| {
        sum += l;
        sum >= 0.9 * length
    });
    let density = high?[0].clamp(mean, DENSEST * mean);
    (density.is_finite() && density > 0.0).then_some(density)
}

/// The mesh's own face that meets two slots on a rim, and its corners there.
fn common_face(a: &Slot, b: &Slot) -> Option<(u32, [u8; 2])> {
    let mut pairs = a.rim.iter().flat_map(|p| b.rim.iter().map(move |q| (p, q)));
    let found = pairs.find(|(p, q)| p.0 == q.0 && p.1 != q.1);
    found.map(|(p, q)| (p.0, [p.1, q.1]))
}
