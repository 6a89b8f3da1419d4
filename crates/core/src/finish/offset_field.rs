//! Smooth vector field of offsets between two surfaces, kriged from known points round a hole and continued across it.

use glam::{DMat3, DVec2, DVec3};

use super::collar::farthest_points;
use super::kriging::{Kriging, Model, ORDERS};
use super::params::FinishParams;
use crate::cancel::Cancel;

/// A known point round a hole.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OffsetDatum {
    /// Its position.
    pub(crate) point: DVec3,
    /// The offset at the point.
    pub offset: DVec3,
    /// Its distance from the rim.
    pub(crate) depth: f64,
}

/// A field of offsets over the plane normal to the mean normal of the surroundings. The three components are kriged with the same model,
/// whose noise is estimated from the data, so that the field is the smooth part of the offsets.
pub(crate) struct OffsetField {
    origin: DVec3,
    /// Columns: two directions in the plane, and its normal.
    frame: DMat3,
    /// The unit of length of the components: the diameter of the hole.
    unit: f64,
    components: [Kriging; 3],
}

impl OffsetField {
    /// Fits a field to data round a hole, given the mean normal of the surroundings, the hole's diameter and the mean edge. `None` if there
    /// are too few data or the token is set.
    pub(crate) fn fit(
        data: &[OffsetDatum],
        normal: DVec3,
        diameter: f64,
        edge: f64,
        cancel: &Cancel,
    ) -> Option<Self> {
        let params = FinishParams::default();
        let normal = normal.try_normalize()?;
        let first = normal.any_orthonormal_vector();
        let frame = DMat3::from_cols(first, normal.cross(first), normal);
        let origin = data.iter().map(|d| d.point).sum::<DVec3>() / data.len().max(1) as f64;
        let place = |p: DVec3| (frame.transpose() * (p - origin)).truncate() / diameter;
        let edge = edge / diameter;
        // Choose well-distributed data, denser near the rim.
        let chosen = spread(data, params.most_data, edge * diameter, cancel);
        let points: Vec<DVec2> = chosen.iter().map(|d| place(d.point)).collect();
        let along = |axis: DVec3| -> Vec<f64> {
            let all = chosen.iter();
            all.map(|d| d.offset.dot(axis) / diameter).collect()
        };
        // Order and noise maximise the restricted likelihood of the normal component.
        let heights = along(normal);
        let few = params.most_estimated.min(points.len());
        let model = Model::estimate(&points[..few], &heights[..few], edge, &ORDERS, cancel)?;
        let fitted = |axis: DVec3| Kriging::new(points.clone(), &along(axis), edge, model);
        Some(Self {
            origin,
            frame,
            unit: diameter,
            components: [
                fitted(frame.x_axis)?,
                fitted(frame.y_axis)?,
                fitted(normal)?,
            ],
        })
    }

    fn place(&self, p: DVec3) -> DVec2 {
        (self.frame.transpose() * (p - self.origin)).truncate() / self.unit
    }

    /// The offset at a point, in the mesh's units.
    pub(crate) fn at(&self, p: DVec3) -> DVec3 {
        let place = self.place(p);
        let offset = DVec3::from_array([0, 1, 2].map(|k| self.components[k].at(place)));
        self.frame * offset * self.unit
    }

    /// The standard deviation of the offset along the normal at a point, in the mesh's units.
    pub(crate) fn deviation(&self, p: DVec3) -> f64 {
        self.components[2].deviation(self.place(p)) * self.unit
    }
}

/// Chooses at most `most` of the data by farthest-point sampling, as for a collar. The score is the squared distance from the data chosen
/// before, divided by the distance from the rim and half an edge.
fn spread(data: &[OffsetDatum], most: usize, edge: f64, cancel: &Cancel) -> Vec<OffsetDatum> {
    let points: Vec<DVec3> = data.iter().map(|d| d.point).collect();
    let unknown = vec![f64::INFINITY; data.len()];
    let score = |i: usize, squared: f64| squared.min(f64::MAX) / (data[i].depth + 0.5 * edge);
    let chosen = farthest_points(&points, unknown, score, most, cancel);
    chosen.into_iter().map(|i| data[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points round a hole of radius 0.5 in the plane, with an offset.
    fn ring(offset: impl Fn(DVec2) -> DVec3) -> Vec<OffsetDatum> {
        let ring = |k: u32| {
            let radius = 0.5 + 0.1 * f64::from(k);
            (0..30).map(move |i| {
                DVec2::from_angle(f64::from(i) * 0.2094 + 0.1 * f64::from(k)) * radius
            })
        };
        let places = (0..5).flat_map(ring);
        let datum = |p: DVec2| OffsetDatum {
            point: p.extend(3.0),
            offset: offset(p),
            depth: p.length() - 0.5,
        };
        places.map(datum).collect()
    }

    #[test]
    fn a_tilt_is_continued_across_the_hole() {
        let tilt = |p: DVec2| DVec3::new(0.02, 0.0, 0.1 * p.x - 0.05 * p.y + 0.01);
        let field = OffsetField::fit(&ring(tilt), DVec3::Z, 1.0, 0.1, &Cancel::new()).unwrap();
        for p in [DVec2::ZERO, DVec2::new(0.2, -0.3), DVec2::new(-0.4, 0.1)] {
            let off = field.at(p.extend(3.1)).distance(tilt(p));
            assert!(off < 1e-6, "{p} {off}");
        }
    }

    #[test]
    fn noise_of_the_data_is_not_part_of_the_field() {
        let noise = |p: DVec2| 0.01 * (78.233 * p.x + 1234.5 * p.y).sin();
        let noisy = |p: DVec2| DVec3::Z * (0.1 * p.x + noise(p));
        let field = OffsetField::fit(&ring(noisy), DVec3::Z, 1.0, 0.1, &Cancel::new()).unwrap();
        let off = field.at(DVec3::new(0.1, 0.1, 3.0)).z - 0.01;
        assert!(off.abs() < 0.006, "{off}");
        assert!(field.deviation(DVec3::Z * 3.0) > 1e-4);
    }

    #[test]
    fn too_few_data_give_no_field() {
        let data = ring(|_| DVec3::ZERO);
        assert!(OffsetField::fit(&data[..5], DVec3::Z, 1.0, 0.1, &Cancel::new()).is_none());
        assert!(OffsetField::fit(&data, DVec3::ZERO, 1.0, 0.1, &Cancel::new()).is_none());
    }
}
