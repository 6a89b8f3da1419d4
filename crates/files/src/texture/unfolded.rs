//! Charts: patches mapped into a circle, with the input's faces across their rims and the radius in texels.

use glam::{DVec2, DVec3};

use super::chart::{Border, Weights, layout};
use super::disk::Disk;
use super::rim_colours::RimColours;
use isomend_core::attributes::{Patches, Slot};
use isomend_core::cancel::Cancel;
use isomend_core::mesh::{Mesh, area_vector};

/// Upper bound of a chart's texel density over the mean density at its rim: the chart's area on the page grows with the square.
const DENSEST: f64 = 4.0;

/// A patch mapped into the unit circle.
pub(super) struct Chart {
    /// Its faces, counted from the first new face.
    pub(super) faces: Vec<usize>,
    pub(super) disk: Disk,
    /// The positions of the disk's vertices in space.
    pub(super) points: Vec<DVec3>,
    pub(super) border: Border,
    /// For each edge of the border: the input's face across it, with its corners at the ends of the edge; `None` on a cut.
    pub(super) across: Vec<Option<(u32, [u8; 2])>>,
    /// Radius in texels at which the chart has the texel density of its rim.
    pub(super) radius: f64,
    /// The positions of the disk's vertices in the unit circle.
    pub(super) places: Vec<DVec2>,
}

impl Chart {
    pub(super) fn new(
        faces: Vec<usize>,
        patches: &Patches,
        filled: &Mesh,
        rim_colours: &RimColours<'_>,
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
        let density = density(&across, &border, &points, rim_colours);
        let density = density.ok_or("there is no image round the patch")?;
        let area: f64 = (disk.faces.iter())
            .map(|f| 0.5 * area_vector(f.map(|v| points[v as usize])).length())
            .sum();
        // The larger of the radii of the circles with the border's length and with the patch's area.
        let of_border = border.length / std::f64::consts::TAU;
        let radius = density * of_border.max((area / std::f64::consts::PI).sqrt());
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

    /// Whether a triangle is flipped or degenerate after rounding of its corners.
    pub(super) fn is_folded(&self, rounded: impl Fn(DVec2) -> [f64; 2]) -> bool {
        let places: Vec<DVec2> = self.places.iter().map(|p| rounded(*p).into()).collect();
        self.disk.faces.iter().any(|face| {
            let [a, b, c] = face.map(|v| places[v as usize]);
            (b - a).perp_dot(c - a) <= 0.0
        })
    }
}

/// Texel density at a rim, in texels per unit of length: its 90th percentile along the rim, between the mean and [`DENSEST`] times the
/// mean. Charts that share a rim may differ widely: at the eyes of the glTF sample duck, edges of one rim have 0.2 to 23 texels. `None`
/// without images.
fn density(
    across: &[Option<(u32, [u8; 2])>],
    border: &Border,
    points: &[DVec3],
    rim_colours: &RimColours<'_>,
) -> Option<f64> {
    let mut edges: Vec<[f64; 2]> = Vec::new();
    for (edge, found) in across.iter().enumerate() {
        let texels = found.and_then(|(face, corners)| rim_colours.texels(face, corners));
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

/// The input's face that has both slots of a rim edge as corners, and the numbers of these corners.
fn common_face(a: &Slot, b: &Slot) -> Option<(u32, [u8; 2])> {
    let mut pairs = a.rim.iter().flat_map(|p| b.rim.iter().map(move |q| (p, q)));
    let found = pairs.find(|(p, q)| p.0 == q.0 && p.1 != q.1);
    found.map(|(p, q)| (p.0, [p.1, q.1]))
}
