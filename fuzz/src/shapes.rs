//! Small meshes from any bytes: a shape, then edits that leave it with all that meshes can suffer from.

use std::f64::consts::PI;

use arbitrary::{Result, Unstructured};
use isomend::Mesh;
use isomend::glam::DVec3;

/// Most faces of a mesh.
const MOST_FACES: usize = 200;
/// Most edits.
const MOST_EDITS: usize = 24;
/// Coordinates that have made trouble somewhere.
const EXTREMES: [f64; 12] = [
    0.0, -0.0, 1.0, 1e-9, -1e-30, 1e-150, 5e-324, 1e6, -1e9, 1e15, -1e31, 1e60,
];
/// Largest coordinate: the squares of areas are still finite.
const LARGEST: f64 = 1e70;

/// A mesh of at least one and at most 200 faces; all positions are finite.
pub fn mesh(input: &mut Unstructured) -> Result<Mesh> {
    let mut mesh = base(input)?;
    for _ in 0..input.int_in_range(0..=MOST_EDITS)? {
        edit(&mut mesh, input)?;
    }
    mesh.faces.truncate(MOST_FACES);
    Ok(mesh)
}

fn base(input: &mut Unstructured) -> Result<Mesh> {
    let mut mesh = match input.int_in_range(0..=8)? {
        0 => bowl(input)?,
        1 => sheet(input)?,
        2 => tube(input)?,
        3 => tetrahedron(),
        4 => {
            let (mut mesh, mut other) = (bowl(input)?, bowl(input)?);
            for p in &mut other.positions {
                p.z = 1.5 - p.z;
            }
            // Upside down, so that the two rims face each other.
            other.faces.iter_mut().for_each(|f| f.swap(0, 1));
            append(&mut mesh, &other);
            mesh
        }
        5 => octahedron(),
        6 => glued(input, false)?,
        7 => glued(input, true)?,
        _ => soup(input)?,
    };
    // Edits need a face and a vertex.
    if mesh.faces.is_empty() {
        append(&mut mesh, &tetrahedron());
    }
    Ok(mesh)
}

fn append(mesh: &mut Mesh, other: &Mesh) {
    let shift = mesh.positions.len() as u32;
    mesh.positions.extend_from_slice(&other.positions);
    let faces = other.faces.iter().map(|f| f.map(|v| v + shift));
    mesh.faces.extend(faces);
}

fn tetrahedron() -> Mesh {
    let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    Mesh::new(positions, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3]])
}

fn octahedron() -> Mesh {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let positions = axes.into_iter().flat_map(|p| [p, -p]).collect();
    let face = |i: u32| {
        let [x, y, z] = [i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2 & 1)];
        match i.count_ones() % 2 {
            0 => [x, y, z],
            _ => [x, z, y],
        }
    };
    Mesh::new(positions, (0..8).map(face).collect())
}

/// A one-sided surface: a grid with one pair of sides glued in reverse, a Möbius band; or the other pair too, a Klein bottle.
fn glued(input: &mut Unstructured, closed: bool) -> Result<Mesh> {
    let (n, m) = (input.int_in_range(3..=9u32)?, input.int_in_range(3..=7u32)?);
    let rows = if closed { m } else { m + 1 };
    let turn = |i: u32, count: u32| 2.0 * PI * f64::from(i) / f64::from(count);
    let mut mesh = Mesh::default();
    for i in 0..n {
        for j in 0..rows {
            let u = turn(i, n);
            let (along, across) = match closed {
                true => (turn(j, m).sin(), (2.0 * turn(j, m)).sin()),
                false => (f64::from(j) / f64::from(m) - 0.5, 0.0),
            };
            let (s, c) = (0.5 * u).sin_cos();
            let reach = 3.0 + c * along - s * across;
            let height = s * along + c * across;
            mesh.positions
                .push(DVec3::new(reach * u.cos(), reach * u.sin(), height));
        }
    }
    let vertex = |i: u32, j: u32| match (i < n, closed) {
        (true, _) => i * rows + j % rows,
        (false, true) => (m - j % m) % m,
        (false, false) => m - j,
    };
    for i in 0..n {
        for j in 0..m {
            let [a, b] = [vertex(i, j), vertex(i + 1, j)];
            let [c, d] = [vertex(i, j + 1), vertex(i + 1, j + 1)];
            mesh.faces.extend([[a, b, d], [a, d, c]]);
        }
    }
    Ok(mesh)
}

/// A ball without its top.
fn bowl(input: &mut Unstructured) -> Result<Mesh> {
    let (rings, around) = (input.int_in_range(1..=6)?, input.int_in_range(3..=9)?);
    let mut mesh = Mesh::new(vec![-DVec3::Z], Vec::new());
    for ring in 1..=rings {
        let latitude = PI * (f64::from(ring) / (f64::from(rings) + 1.5) - 0.5);
        for i in 0..around {
            let angle = 2.0 * PI * (f64::from(i) + 0.5 * f64::from(ring)) / f64::from(around);
            let (y, x) = angle.sin_cos();
            let r = latitude.cos();
            mesh.positions
                .push(DVec3::new(x * r, y * r, latitude.sin()));
        }
    }
    let at = |ring: u32, i: u32| 1 + (ring - 1) * around + i % around;
    for i in 0..around {
        mesh.faces.push([0, at(1, i + 1), at(1, i)]);
        for ring in 1..rings {
            let [a, b, c, d] = [
                at(ring, i),
                at(ring, i + 1),
                at(ring + 1, i),
                at(ring + 1, i + 1),
            ];
            mesh.faces.extend([[a, b, c], [b, d, c]]);
        }
    }
    Ok(mesh)
}

/// A sheet, plane or bent, with holes where bits are zero.
fn sheet(input: &mut Unstructured) -> Result<Mesh> {
    let (nx, ny) = (input.int_in_range(1..=9)?, input.int_in_range(1..=9)?);
    let bend = f64::from(input.arbitrary::<i8>()?) / 512.0;
    let kept: [u8; 11] = if input.arbitrary()? {
        input.arbitrary()?
    } else {
        [255; 11]
    };
    let mut mesh = Mesh::default();
    for y in 0..=ny {
        for x in 0..=nx {
            let (x, y) = (f64::from(x), f64::from(y));
            mesh.positions
                .push(DVec3::new(x, y, bend * (x * x - y * y)));
        }
    }
    for cell in 0..nx * ny {
        let [x, y] = [cell % nx, cell / nx];
        let a = y * (nx + 1) + x;
        if kept[(cell / 8) as usize] >> (cell % 8) & 1 == 1 {
            mesh.faces
                .extend([[a, a + 1, a + nx + 1], [a + 1, a + nx + 2, a + nx + 1]]);
        }
    }
    Ok(mesh)
}

/// A tube that is open at both ends; with one ring of faces it may be very short.
fn tube(input: &mut Unstructured) -> Result<Mesh> {
    let (rings, around) = (input.int_in_range(1..=6)?, input.int_in_range(3..=12)?);
    let step = f64::from(input.int_in_range(1..=64u8)?) / 32.0;
    let mut mesh = Mesh::default();
    for ring in 0..=rings {
        for i in 0..around {
            let angle = 2.0 * PI * f64::from(i) / f64::from(around);
            let (y, x) = angle.sin_cos();
            mesh.positions
                .push(DVec3::new(x, y, step * f64::from(ring)));
        }
    }
    for ring in 0..rings {
        for i in 0..around {
            let next = (i + 1) % around;
            let [a, b] = [i, next].map(|i| ring * around + i);
            let [c, d] = [a + around, b + around];
            mesh.faces.extend([[a, b, c], [b, d, c]]);
        }
    }
    Ok(mesh)
}

/// Any faces between points of a small lattice.
fn soup(input: &mut Unstructured) -> Result<Mesh> {
    let count = input.int_in_range(3..=20u32)?;
    let mut mesh = Mesh::default();
    for _ in 0..count {
        let bits = input.arbitrary::<u8>()?;
        let at = |shift: u8| f64::from(bits >> shift & 3);
        mesh.positions.push(DVec3::new(at(0), at(2), at(4)));
    }
    for _ in 0..input.int_in_range(1..=40)? {
        let mut corner = || input.int_in_range(0..=count - 1);
        mesh.faces.push([corner()?, corner()?, corner()?]);
    }
    Ok(mesh)
}

fn edit(mesh: &mut Mesh, input: &mut Unstructured) -> Result<()> {
    let face = input.choose_index(mesh.faces.len())?;
    let vertex = input.choose_index(mesh.positions.len())?;
    let corner = input.int_in_range(0..=2usize)?;
    match input.int_in_range(0..=11)? {
        0 | 1 if mesh.faces.len() > 1 => {
            mesh.faces.remove(face);
        }
        2 => mesh.faces.push(mesh.faces[face]),
        3 => mesh.faces[face].swap(0, 1),
        // A face more at an edge, or a face without an area.
        4 => {
            let [a, b, _] = mesh.faces[face];
            mesh.faces.push([b, a, vertex as u32]);
        }
        5 => mesh.faces[face][corner] = vertex as u32,
        6 => {
            let from = mesh.faces[face][corner] as usize;
            mesh.positions[vertex] = mesh.positions[from];
        }
        // A copy of a vertex at the same place, as at a seam of texture coordinates.
        7 => {
            let old = mesh.faces[face][corner] as usize;
            mesh.faces[face][corner] = mesh.positions.len() as u32;
            mesh.positions.push(mesh.positions[old]);
        }
        8 => {
            let by: [i8; 3] = input.arbitrary()?;
            mesh.positions[vertex] += DVec3::from_array(by.map(|b| f64::from(b) / 64.0));
        }
        9 => mesh.positions[vertex][corner] = *input.choose(&EXTREMES)?,
        10 => island(mesh, vertex, input)?,
        11 => {
            let scale = 10f64.powi(input.int_in_range(-20..=20)?);
            let shift = *input.choose(&[0.0, 0.0, 1.0, 1e3, 1e6])?;
            let all = mesh.positions.iter_mut();
            all.for_each(|p| *p = *p * scale + DVec3::splat(shift * scale));
        }
        _ => mesh.positions.push(DVec3::splat(corner as f64)),
    }
    let all = mesh.positions.iter_mut();
    all.for_each(|p| *p = p.clamp(DVec3::splat(-LARGEST), DVec3::splat(LARGEST)));
    Ok(())
}

/// A small triangle near a vertex, which is no part of the rest.
fn island(mesh: &mut Mesh, vertex: usize, input: &mut Unstructured) -> Result<()> {
    let at = mesh.positions[vertex];
    let base = mesh.positions.len() as u32;
    for axis in 0..3 {
        let mut p = at;
        p[axis] += f64::from(input.arbitrary::<i8>()?) / 256.0;
        mesh.positions.push(p);
    }
    mesh.faces.push([base, base + 1, base + 2]);
    Ok(())
}
