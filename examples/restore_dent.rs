//! Makes a ball with a dent, restores it, and prints its largest distance from the sphere before and after:
//! `cargo run --release --example restore_dent`.

use std::error::Error;
use std::f64::consts::{PI, TAU};

use isomend::Attributes;
use isomend::glam::DVec3;
use isomend::{Mask, Selector};
use isomend::{Mesh, RestoreParams, restore};

/// Vertices on each ring, and rings between the poles.
const AROUND: u32 = 48;
const RINGS: u32 = 23;
/// The middle of the dent, its depth, and the width of its Gaussian profile.
const MIDDLE: DVec3 = DVec3::X;
const DEPTH: f64 = 0.2;
const WIDTH: f64 = 0.25;

/// The unit sphere, made of rings of vertices and two poles.
fn ball() -> Mesh {
    let mut mesh = Mesh::new(vec![-DVec3::Z], Vec::new());
    for ring in 1..=RINGS {
        let latitude = PI * f64::from(ring) / f64::from(RINGS + 1) - PI / 2.0;
        for i in 0..AROUND {
            let angle = TAU * (f64::from(i) + 0.5 * f64::from(ring)) / f64::from(AROUND);
            let (y, x) = angle.sin_cos();
            let radius = latitude.cos();
            let position = DVec3::new(x * radius, y * radius, latitude.sin());
            mesh.positions.push(position);
        }
    }
    mesh.positions.push(DVec3::Z);
    let vertex = |ring: u32, i: u32| 1 + (ring - 1) * AROUND + i % AROUND;
    let north = 1 + RINGS * AROUND;
    for i in 0..AROUND {
        mesh.faces.push([0, vertex(1, i + 1), vertex(1, i)]);
        for ring in 1..RINGS {
            let [a, b] = [vertex(ring, i), vertex(ring, i + 1)];
            let [c, d] = [vertex(ring + 1, i), vertex(ring + 1, i + 1)];
            mesh.faces.extend([[a, b, c], [b, d, c]]);
        }
        let [a, b] = [vertex(RINGS, i), vertex(RINGS, i + 1)];
        mesh.faces.push([a, b, north]);
    }
    mesh
}

/// The largest distance of a mesh's vertices from the unit sphere.
fn distance(mesh: &Mesh) -> f64 {
    let distances = mesh.positions.iter().map(|p| (p.length() - 1.0).abs());
    distances.fold(0.0, f64::max)
}

/// Restores the dented ball; returns its largest distance from the sphere before and after.
pub fn run() -> Result<[f64; 2], Box<dyn Error>> {
    let mut dented = ball();
    for position in &mut dented.positions {
        let depth = DEPTH * (-(position.distance(MIDDLE) / WIDTH).powi(2)).exp();
        *position *= 1.0 - depth;
    }
    let mask = Mask {
        selectors: vec![Selector::Ball {
            centre: MIDDLE,
            radius: 0.7,
        }],
        ..Mask::default()
    };
    let marked = mask.faces(&dented, &Attributes::default())?;
    let restored = restore(&dented, &marked, &RestoreParams::default())?;
    println!("{} faces replaced", restored.report.removed_faces);
    Ok([distance(&dented), distance(&restored.mesh)])
}

fn main() -> Result<(), Box<dyn Error>> {
    let [before, after] = run()?;
    println!("the farthest point from the sphere: {before:.4} before, {after:.4} after");
    Ok(())
}
