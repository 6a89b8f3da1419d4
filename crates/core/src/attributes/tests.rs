//! Tests of the attributes of patches: continuation, seams, split vertices.

#![allow(clippy::too_many_lines)] // A long test tells one story.
use super::*;

/// A flat sheet of `n` by `n` unit squares without the middle `hole` by `hole` squares, and the same sheet with the
/// hole filled by a finer mesh.
struct Sheet {
    original: Mesh,
    filled: Mesh,
}

const N: u32 = 9;

fn sheet() -> Sheet {
    let at = |i: u32, j: u32| j * (N + 1) + i;
    let inside = |i: u32, j: u32| (3..6).contains(&i) && (3..6).contains(&j);
    // Vertices strictly inside the hole come last.
    let deep = |i: u32, j: u32| (4..6).contains(&i) && (4..6).contains(&j);
    let all = || (0..=N).flat_map(|j| (0..=N).map(move |i| (i, j)));
    let order: Vec<(u32, u32)> = all()
        .filter(|&(i, j)| !deep(i, j))
        .chain(all().filter(|&(i, j)| deep(i, j)))
        .collect();
    let mut number = vec![0; ((N + 1) * (N + 1)) as usize];
    for (v, &(i, j)) in order.iter().enumerate() {
        number[at(i, j) as usize] = v as u32;
    }
    let positions: Vec<DVec3> = order
        .iter()
        .map(|&(i, j)| DVec3::new(f64::from(i), f64::from(j), 0.0))
        .collect();
    let faces = |hole: bool| {
        let mut faces = Vec::new();
        for (i, j) in all().filter(|&(i, j)| i < N && j < N && inside(i, j) == hole) {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let [a, b, c, d] = corners.map(|(i, j)| number[at(i, j) as usize]);
            faces.extend([[a, b, c], [a, c, d]]);
        }
        faces
    };
    let kept = positions.len() - 4;
    Sheet {
        original: Mesh::new(positions[..kept].to_vec(), faces(false)),
        filled: Mesh::new(positions, [faces(false), faces(true)].concat()),
    }
}

fn vertex_attribute(
    mesh: &Mesh,
    role: Role,
    scalar: Scalar,
    f: impl Fn(DVec3) -> Vec<f64>,
) -> Attribute {
    let components = f(DVec3::ZERO).len();
    let mut attribute = Attribute::new("a", role, scalar, components);
    mesh.positions
        .iter()
        .for_each(|p| attribute.push(Some(&f(*p))));
    attribute
}

fn with_vertex(attribute: Attribute) -> Attributes {
    Attributes {
        vertex: vec![attribute],
        ..Attributes::default()
    }
}

#[test]
fn the_input_stays_and_new_faces_are_marked() {
    let Sheet { original, filled } = sheet();
    let out = transfer(&original, &Attributes::default(), filled.clone());
    assert_eq!(out.mesh, filled);
    let marked = (0..filled.faces.len()).filter(|&f| out.attributes.is_patch(f));
    assert_eq!(marked.count(), 18);
    assert!(!out.attributes.is_patch(original.faces.len() - 1));
    // A second run marks its faces too and keeps the earlier marks.
    let again = transfer(&filled, &out.attributes, filled.clone());
    assert_eq!(again.attributes, out.attributes);
}

#[test]
fn colours_and_coordinates_continue_linearly() {
    let Sheet { original, filled } = sheet();
    let colour = |p: DVec3| vec![20.0 * p.x, 255.0 - 10.0 * p.y, 7.0];
    let attributes = with_vertex(vertex_attribute(
        &original,
        Role::Colour,
        Scalar::U8,
        colour,
    ));
    let out = transfer(&original, &attributes, filled.clone());
    assert_eq!(out.mesh, filled, "no vertex is split");
    let after = &out.attributes.vertex[0];
    let n = original.positions.len();
    assert_eq!(after.values[..3 * n], attributes.vertex[0].values);
    for (v, p) in filled.positions.iter().enumerate().skip(n) {
        let value = after.get(v).unwrap();
        for (got, wanted) in value.iter().zip(colour(*p)) {
            assert!(
                (got - wanted).abs() <= 2.0 && got.fract() == 0.0,
                "{value:?}"
            );
        }
    }
}

#[test]
fn numbers_of_things_are_copied_not_blended() {
    let Sheet { original, filled } = sheet();
    let scan = |p: DVec3| vec![if p.x < 4.5 { 3.0 } else { 9.0 }];
    let attributes = with_vertex(vertex_attribute(&original, Role::Other, Scalar::I32, scan));
    let out = transfer(&original, &attributes, filled.clone());
    for v in original.positions.len()..filled.positions.len() {
        let value = out.attributes.vertex[0].get(v).unwrap()[0];
        assert!(value == 3.0 || value == 9.0, "{value}");
    }
}

#[test]
fn normals_are_of_unit_length_and_keep_the_custom_of_the_file() {
    let Sheet { original, filled } = sheet();
    for sign in [1.0, -1.0] {
        let tilted = DVec3::new(0.6, 0.0, 0.8) * sign;
        let normal = |_: DVec3| tilted.to_array().to_vec();
        let attributes = with_vertex(vertex_attribute(
            &original,
            Role::Normal,
            Scalar::F64,
            normal,
        ));
        let out = transfer(&original, &attributes, filled.clone());
        for v in original.positions.len()..filled.positions.len() {
            let got = DVec3::from_slice(out.attributes.vertex[0].get(v).unwrap());
            assert!((got.length() - 1.0).abs() < 1e-12);
            assert!(got.distance(tilted) < 1e-6, "{got}");
        }
    }
}

/// Texture coordinates of corners, with one chart left of x = `seam` and one right of it.
fn two_charts(mesh: &Mesh, seam: f64) -> Attributes {
    let mut pool = Attribute::new("vt", Role::Uv(0), Scalar::F64, 2);
    let mut corners = Vec::new();
    let mut materials = Labels::new(LabelKind::Material);
    for face in &mesh.faces {
        let centre = face
            .iter()
            .map(|&v| mesh.positions[v as usize].x)
            .sum::<f64>()
            / 3.0;
        let shift = if centre < seam { 0.0 } else { 100.0 };
        materials.of_face.push(0);
        corners.push(face.map(|v| {
            let p = mesh.positions[v as usize];
            pool.push(Some(&[p.x + shift, p.y]));
            pool.len() as u32 - 1
        }));
    }
    materials.place("skin");
    Attributes {
        corner: vec![CornerAttribute { pool, corners }],
        labels: vec![materials],
        ..Attributes::default()
    }
}

#[test]
fn a_rim_in_one_chart_gets_coordinates_and_the_material_of_the_rim() {
    let Sheet { original, filled } = sheet();
    let attributes = two_charts(&original, 1.0);
    let out = transfer(&original, &attributes, filled.clone());
    assert!(out.notes.is_empty(), "{:?}", out.notes);
    let (before, after) = (&attributes.corner[0], &out.attributes.corner[0]);
    let m = original.faces.len();
    assert_eq!(after.corners[..m], before.corners);
    assert_eq!(
        after.pool.values[..before.pool.values.len()],
        before.pool.values
    );
    assert_eq!(
        after.pool.len(),
        before.pool.len() + 4,
        "one for each new vertex"
    );
    for f in m..filled.faces.len() {
        assert_eq!(out.attributes.labels[0].get(f), Some("skin"));
        for k in 0..3 {
            let p = filled.positions[filled.faces[f][k] as usize];
            let uv = after.get(f, k).unwrap();
            assert!(
                (uv[0] - 100.0 - p.x).abs() < 0.02 && (uv[1] - p.y).abs() < 0.02,
                "{uv:?} {p}"
            );
        }
    }
}

#[test]
fn a_rim_across_a_seam_gets_a_material_of_its_own() {
    let Sheet { original, filled } = sheet();
    let attributes = two_charts(&original, 4.5);
    let out = transfer(&original, &attributes, filled.clone());
    assert_eq!(out.notes.len(), 1);
    for f in original.faces.len()..filled.faces.len() {
        assert_eq!(out.attributes.labels[0].get(f), Some(PATCH_NAME));
        assert_eq!(out.attributes.corner[0].get(f, 0), None);
    }
    assert_eq!(out.attributes.labels[0].get(0), Some("skin"));
}

#[test]
fn patches_use_the_vertices_of_their_rim_where_vertices_are_split() {
    let Sheet { original, filled } = sheet();
    // Each face has its own three vertices, as after an export with flat shading.
    let mut split = Mesh::default();
    let mut normal = Attribute::new("n", Role::Normal, Scalar::F32, 3);
    let mut uv = Attribute::new("t", Role::Uv(0), Scalar::F32, 2);
    for face in &original.faces {
        let at = split.positions.len() as u32;
        for &v in face {
            let p = original.positions[v as usize];
            split.positions.push(p);
            normal.push(Some(&[0.0, 0.0, 1.0]));
            uv.push(Some(&[p.x, p.y]));
        }
        split.faces.push([at, at + 1, at + 2]);
    }
    let n = split.positions.len();
    let weld = crate::mesh::weld_map(&split);
    let place = |p: DVec3| split.positions.iter().position(|q| *q == p);
    let mut after = split.clone();
    after
        .positions
        .extend(&filled.positions[original.positions.len()..]);
    for face in &filled.faces[original.faces.len()..] {
        after.faces.push(face.map(|v| {
            let p = filled.positions[v as usize];
            let new = || v as usize - original.positions.len() + n;
            place(p).map_or_else(|| new() as u32, |w| weld[w])
        }));
    }
    // One vertex in the middle of the lower side of the rim has another normal in one of its faces.
    let corner = (0..n).rfind(|&v| {
        split.positions[v] == DVec3::new(4.0, 3.0, 0.0)
            && split.faces[v / 3]
                .iter()
                .any(|&w| split.positions[w as usize] == DVec3::new(5.0, 3.0, 0.0))
    });
    normal.values[3 * corner.unwrap()..][..3].copy_from_slice(&[1.0, 0.0, 0.0]);
    let attributes = Attributes {
        vertex: vec![normal, uv],
        ..Attributes::default()
    };
    let out = transfer(&split, &attributes, after.clone());
    assert_eq!(
        out.attributes.copies.len(),
        1,
        "only the vertex with two normals"
    );
    let (copy, of) = out.attributes.copies[0];
    assert_eq!(
        out.mesh.positions[copy as usize],
        split.positions[of as usize]
    );
    let bent = DVec3::from_slice(out.attributes.vertex[0].get(copy as usize).unwrap());
    assert!((bent - DVec3::new(1.0, 0.0, 1.0).normalize()).length() < 1e-6);
    assert_eq!(
        out.attributes.vertex[1].get(copy as usize),
        Some(&[4.0, 3.0][..])
    );
    for (face, before) in out.mesh.faces[split.faces.len()..]
        .iter()
        .zip(&after.faces[split.faces.len()..])
    {
        for (v, w) in face.iter().zip(before) {
            assert_eq!(
                out.mesh.positions[*v as usize],
                after.positions[*w as usize]
            );
        }
    }
}

#[test]
fn values_that_are_no_numbers_leave_the_patch_connected() {
    let Sheet { original, filled } = sheet();
    for everywhere in [true, false] {
        let value = |p: DVec3| match everywhere || p.x < 4.0 {
            true => vec![f64::NAN],
            false => vec![p.y],
        };
        let attribute = vertex_attribute(&original, Role::Other, Scalar::F32, value);
        let out = transfer(&original, &with_vertex(attribute), filled.clone());
        assert_eq!(out.mesh, filled);
        let new = original.positions.len()..filled.positions.len();
        let values = new.map(|v| out.attributes.vertex[0].get(v).unwrap()[0]);
        for value in values {
            assert_eq!(value.is_nan(), everywhere, "{value}");
            assert!(everywhere || (2.9..=6.1).contains(&value), "{value}");
        }
    }
}

#[test]
fn a_colour_that_is_unwanted_is_not_continued() {
    let Sheet { original, filled } = sheet();
    // The rim is red, the rest has a gradient.
    let is_rim = |p: DVec3| (3.0..=6.0).contains(&p.x) && (3.0..=6.0).contains(&p.y);
    let colour = |p: DVec3| match is_rim(p) {
        true => vec![255.0, 0.0, 0.0],
        false => vec![10.0, 20.0 * p.x, 100.0],
    };
    let attribute = vertex_attribute(&original, Role::Colour, Scalar::U8, colour);
    let red = UnwantedColour {
        rgb: [1.0, 0.0, 0.0],
        tolerance: 0.1,
    };
    let plain = with_vertex(attribute);
    let out = transfer_without(&original, &plain, filled.clone(), &[red]);
    assert_eq!(out.mesh, filled);
    let colours = &out.attributes.vertex[0];
    for v in 0..filled.positions.len() {
        let value = colours.get(v).unwrap();
        match v < original.positions.len() {
            true => assert_eq!(Some(value), plain.vertex[0].get(v)),
            false => {
                let p = filled.positions[v];
                assert_eq!([value[0], value[2]], [10.0, 100.0]);
                assert!((value[1] - 20.0 * p.x).abs() < 12.0, "{value:?}");
            }
        }
    }
    let continued = transfer(&original, &plain, filled.clone());
    let last = continued.attributes.vertex[0].get(filled.positions.len() - 1);
    assert_eq!(last, Some(&[255.0, 0.0, 0.0][..]));
    // Nothing but the unwanted colour: it stays, since nothing else is known.
    let all = vertex_attribute(&original, Role::Colour, Scalar::U8, |_| {
        vec![255.0, 0.0, 0.0]
    });
    let out = transfer_without(&original, &with_vertex(all), filled.clone(), &[red]);
    assert_eq!(out.mesh, filled);
}
