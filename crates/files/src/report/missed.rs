//! Explains why a mask marks no face: the bounds of the mesh, and the distance of each part of the mask from it.

use std::collections::BTreeMap;

use glam::DVec3;

use super::{length, point};
use isomend_core::mesh::attributes::{Attributes, LabelKind, Role};
use isomend_core::mesh::mask::{Mask, Selector};
use isomend_core::mesh::{Mesh, bounds};
use isomend_core::spatial::closest_on_triangle;

/// Most colours and materials that are listed.
const LISTED: usize = 8;
/// Most projections between a triangle and a box; each one brings the pair of points nearer.
const STEPS: usize = 64;

/// The reasons why a mask marks no face of a mesh, in lines: the bounds of the mesh, the point of the mesh nearest to each ball and box of
/// the mask, or the colours and materials of the mesh. `inside` are the bounds of the selectors of the kind [`Selector::Inside`], in
/// order. If only the shrinking of the mask removed all faces, the lines say that instead.
#[doc(hidden)]
pub fn missed_lines(
    mask: &Mask,
    inside: &[[DVec3; 2]],
    mesh: &Mesh,
    attributes: &Attributes,
) -> Vec<String> {
    let corners = mesh.faces.iter().flatten();
    let (low, high) = bounds(corners.map(|&v| mesh.positions[v as usize]));
    let size = low.distance(high);
    let at = |p| point(p, size);
    let unshrunk = Mask {
        shrink: 0.0,
        ..mask.clone()
    };
    let before = unshrunk.faces(mesh, attributes).unwrap_or_default();
    let before = before.iter().filter(|marked| **marked).count();
    if before > 0 {
        return vec![format!(
            "without shrinking it marks {before} faces, but all of them are within {} of unmarked faces; shrink it less",
            length(mask.shrink)
        )];
    }
    let mut lines = vec![format!("the mesh reaches from {} to {}", at(low), at(high))];
    let mut inside = inside.iter();
    for selector in &mask.selectors {
        let line = match selector {
            Selector::Ball { centre, radius } => {
                let (near, distance) = nearest(mesh, *centre, *centre);
                let name = format!("the centre of the ball at {}", at(*centre));
                distance_text(&name, &at(near), distance, distance <= *radius)
            }
            Selector::Box { low, high } => {
                let (near, distance) = nearest(mesh, *low, *high);
                distance_text("the box", &at(near), distance, distance <= 0.0)
            }
            Selector::Inside(_) => {
                let Some([low, high]) = inside.next() else {
                    continue;
                };
                let (near, distance) = nearest(mesh, *low, *high);
                let name = format!("the mask's own bounds, {} to {}", at(*low), at(*high));
                distance_text(&name, &at(near), distance, distance <= 0.0)
            }
            Selector::Colour { .. } => colours(mesh, attributes),
            Selector::Material(_) => materials(attributes),
            Selector::Faces(_) => "the list of faces is empty".to_owned(),
        };
        lines.push(line);
    }
    lines
}

/// The distance of the mesh from a part of the mask. `reached`: the part touches the mesh but contains no face centroid.
fn distance_text(what: &str, near: &str, distance: f64, reached: bool) -> String {
    let end = if reached {
        "; it reaches the surface, but it contains the centroid of no face: make it larger"
    } else {
        ""
    };
    format!(
        "the point of the mesh nearest to {what} is {near}, {} away{end}",
        length(distance)
    )
}

/// The point of a mesh nearest to a box, and its distance. A box of size 0 is a point.
fn nearest(mesh: &Mesh, low: DVec3, high: DVec3) -> (DVec3, f64) {
    let mut best = (DVec3::NAN, f64::INFINITY);
    for face in 0..mesh.faces.len() as u32 {
        let corners = mesh.corners(face);
        let (l, h) = bounds(corners);
        let gap = (l - high).max(low - h).max(DVec3::ZERO).length();
        if gap >= best.1 {
            continue;
        }
        let found = nearest_of_triangle(corners, low, high);
        if found.1 < best.1 {
            best = found;
        }
    }
    best
}

/// The point of a triangle nearest to a box, and its distance. Projects alternately onto the box and onto the triangle, which converges
/// to the nearest pair of points since both are convex.
fn nearest_of_triangle([a, b, c]: [DVec3; 3], low: DVec3, high: DVec3) -> (DVec3, f64) {
    let mut on = (a + b + c) / 3.0;
    let mut distance = f64::INFINITY;
    for _ in 0..STEPS {
        let q = on.clamp(low, high);
        on = closest_on_triangle(q, a, b, c).0;
        let now = on.distance(on.clamp(low, high));
        if now >= distance * (1.0 - 1e-12) {
            break;
        }
        distance = now;
    }
    (on, on.distance(on.clamp(low, high)))
}

/// The vertex colours of the mesh, the most frequent first.
fn colours(mesh: &Mesh, attributes: &Attributes) -> String {
    let Some(colours) = attributes.vertex_role(Role::Colour) else {
        return "the vertices of the mesh have no colours".to_owned();
    };
    let unit = colours.unit();
    let mut count: BTreeMap<[u8; 3], usize> = BTreeMap::new();
    for v in 0..mesh.positions.len() {
        if let Some(c) = colours.get(v).filter(|c| c.len() >= 3) {
            let byte = |i: usize| (c[i] / unit * 255.0).round().clamp(0.0, 255.0) as u8;
            *count.entry([byte(0), byte(1), byte(2)]).or_default() += 1;
        }
    }
    let names = count
        .into_iter()
        .map(|([r, g, b], n)| (n, format!("{r:02x}{g:02x}{b:02x} ({n} vertices)")));
    format!(
        "no face has three vertices of that colour; the mesh has {}",
        listed(names.collect())
    )
}

/// The materials of the faces, the most frequent first.
fn materials(attributes: &Attributes) -> String {
    let labels = attributes.labels_of(LabelKind::Material);
    let mut count: BTreeMap<&str, usize> = BTreeMap::new();
    for labels in labels.iter() {
        for f in 0..labels.of_face.len() {
            if let Some(name) = labels.get(f) {
                *count.entry(name).or_default() += 1;
            }
        }
    }
    let names = count
        .into_iter()
        .map(|(name, n)| (n, format!("'{name}' ({n} faces)")));
    format!(
        "no face has that material; the mesh has {}",
        listed(names.collect())
    )
}

/// The [`LISTED`] most frequent names, and the number of the others.
fn listed(mut names: Vec<(usize, String)>) -> String {
    names.sort_by(|a, b| b.0.cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
    let more = names.len().saturating_sub(LISTED);
    let first: Vec<String> = names.into_iter().take(LISTED).map(|n| n.1).collect();
    match (first.is_empty(), more) {
        (true, _) => "none".to_owned(),
        (false, 0) => first.join(", "),
        (false, more) => format!("{} and {more} more", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isomend_core::mesh::shapes::icosphere;

    fn lines(mask: Mask) -> String {
        missed_lines(&mask, &[], &icosphere(4), &Attributes::default()).join("; ")
    }

    #[test]
    fn the_nearest_point_is_that_of_the_surface() {
        let mesh = icosphere(4);
        let (near, distance) = nearest(&mesh, 3.0 * DVec3::X, 3.0 * DVec3::X);
        assert!(near.distance(DVec3::X) < 0.05 && (distance - 2.0).abs() < 0.01);
        // A box whose nearest part is the middle of a side, an edge and a corner.
        for towards in [DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::ONE] {
            let low = 2.0 * towards - DVec3::splat(0.5) * (DVec3::ONE - towards);
            let (near, distance) = nearest(&mesh, low, low + DVec3::ONE);
            let wanted = 2.0 * towards.length() - 1.0;
            assert!((distance - wanted).abs() < 0.01, "{towards}: {distance}");
            assert!(
                near.distance(towards.normalize()) < 0.3,
                "{towards}: {near}"
            );
        }
    }

    #[test]
    fn small_shrunk_and_distant_masks_get_different_reasons() {
        let ball = |radius, shrink| Mask {
            selectors: vec![Selector::Ball {
                centre: DVec3::X,
                radius,
            }],
            grow: 0.0,
            shrink,
        };
        assert!(lines(ball(1e-5, 0.0)).contains("centroid of no face"));
        let shrunk = lines(ball(0.3, 2.0));
        assert!(shrunk.contains("shrink it less"), "{shrunk}");
        let far = Mask {
            selectors: vec![Selector::Box {
                low: DVec3::splat(4.0),
                high: DVec3::splat(5.0),
            }],
            ..Mask::default()
        };
        let far = lines(far);
        assert!(
            far.contains("reaches from -1, -1, -1 to") && far.contains("nearest to the box"),
            "{far}"
        );
    }
}
