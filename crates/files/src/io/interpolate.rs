//! Interpolates the attributes of new vertices and corners that are on faces of the input, after faces were split.

use std::collections::HashMap;

use glam::DVec3;

use isomend_core::mesh::attributes::{Attribute, Attributes, Role};
use isomend_core::mesh::{Mesh, Origins};

/// Marks a face without an origin, or a corner without a value.
const NONE: u32 = u32::MAX;

/// Sets the attributes of new vertices and corners by interpolation in the input face that contains them. `attributes`
/// belong to `after` and hold the values copied so far; `old` belong to `before`. `origins` gives for each face of
/// `after` the face of `before` that contains it.
pub(super) fn interpolate(
    attributes: &mut Attributes,
    after: &Mesh,
    origins: &Origins,
    (old, before): (&Attributes, &Mesh),
) {
    // The vertices whose attributes are set.
    let mut done = vec![false; after.positions.len()];
    // Index in the pool of each value already added: (pool, bits of the value) -> index.
    let mut places: HashMap<(usize, Vec<u64>), u32> = HashMap::new();
    for (f, (face, origin)) in after.faces.iter().zip(&origins.faces).enumerate() {
        if origin.face == NONE {
            continue;
        }
        // A corner origin of 3 means: none of the three corners of the input face.
        for k in (0..3).filter(|k| origin.corners[*k] == 3) {
            let (v, own) = (face[k], origin.face as usize);
            let p = after.positions[v as usize];
            let weights = weights(before.corners(origin.face), p);
            let first = origins.vertices[v as usize] as usize;
            if p != before.positions[first] && !std::mem::replace(&mut done[v as usize], true) {
                for (new, old) in attributes.vertex.iter_mut().zip(&old.vertex) {
                    if let Some(value) = between(old, before.faces[own], weights) {
                        let start = v as usize * new.components;
                        for (x, y) in new.values[start..].iter_mut().zip(value) {
                            *x = new.scalar.nearest(y);
                        }
                    }
                }
            }
            let corner = attributes.corner.iter_mut().zip(&old.corner);
            for (i, (new, old)) in corner.enumerate() {
                let value = between(&old.pool, old.corners[own], weights);
                new.corners[f][k] = value.map_or(NONE, |value| {
                    let bits = value.iter().map(|x| x.to_bits()).collect();
                    *places.entry((i, bits)).or_insert_with(|| {
                        new.pool.push(Some(&value));
                        new.pool.len() as u32 - 1
                    })
                });
            }
        }
    }
}

/// The barycentric coordinates of `p` in a triangle. Where `p` is outside, negative coordinates are set to 0 and the
/// rest scaled to the sum 1.
fn weights([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    let part = |q: DVec3, r: DVec3| (q - p).cross(r - p).dot(normal).max(0.0);
    let own = [part(b, c), part(c, a), part(a, b)];
    let sum: f64 = own.iter().sum();
    match sum > 0.0 {
        true => own.map(|x| x / sum),
        false => [1.0, 0.0, 0.0],
    }
}

/// The weighted mean of three values. `None` if one is missing, or if the values are integers that are names (not
/// colours).
fn between(of: &Attribute, items: [u32; 3], weights: [f64; 3]) -> Option<Vec<f64>> {
    if !of.scalar.is_float() && of.role != Role::Colour {
        return None;
    }
    let mut sum = vec![0.0; of.components];
    for (item, weight) in items.into_iter().zip(weights) {
        let value = of.get(item as usize)?;
        for (s, x) in sum.iter_mut().zip(value) {
            *s += weight * x;
        }
    }
    if of.role == Role::Normal {
        let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length > 0.0 {
            sum.iter_mut().for_each(|x| *x /= length);
        }
    }
    Some(sum)
}
