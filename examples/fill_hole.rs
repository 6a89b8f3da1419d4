//! Makes a ball without its top, fills the hole, and prints the largest distance of the patch from the sphere:
//! `cargo run --release --example fill_hole`.

use std::error::Error;
use std::f64::consts::{PI, TAU};

use isomend::glam::DVec3;
use isomend::report::summary_lines;
use isomend::{FillParams, Mesh, fill};

/// Vertices on each ring.
const AROUND: u32 = 24;
/// Rings of the open ball; a whole ball would have eleven rings and a second pole.
const RINGS: u32 = 9;

/// The unit sphere from the south pole to 45 degrees north, made of rings of vertices.
fn ball_without_top() -> Mesh {
    let mut mesh = Mesh::new(vec![-DVec3::Z], Vec::new());
    for ring in 1..=RINGS {
        let latitude = PI * f64::from(ring) / 12.0 - PI / 2.0;
        for i in 0..AROUND {
            let angle = TAU * (f64::from(i) + 0.5 * f64::from(ring)) / f64::from(AROUND);
            let (y, x) = angle.sin_cos();
            let radius = latitude.cos();
            let position = DVec3::new(x * radius, y * radius, latitude.sin());
            mesh.positions.push(position);
        }
    }
    let vertex = |ring: u32, i: u32| 1 + (ring - 1) * AROUND + i % AROUND;
    for i in 0..AROUND {
        mesh.faces.push([0, vertex(1, i + 1), vertex(1, i)]);
        for ring in 1..RINGS {
            let [a, b] = [vertex(ring, i), vertex(ring, i + 1)];
            let [c, d] = [vertex(ring + 1, i), vertex(ring + 1, i + 1)];
            mesh.faces.extend([[a, b, c], [b, d, c]]);
        }
    }
    mesh
}

/// Fills the ball; returns the largest distance of the patch's vertices from the sphere.
pub fn run() -> Result<f64, Box<dyn Error>> {
    let ball = ball_without_top();
    let filled = fill(&ball, &FillParams::default())?;
    for line in summary_lines(&filled.report, true) {
        println!("{line}");
    }
    // The vertices and faces of the input come first, bit for bit.
    let patch = &filled.mesh.positions[ball.positions.len()..];
    let distances = patch.iter().map(|p| (p.length() - 1.0).abs());
    Ok(distances.fold(0.0, f64::max))
}

fn main() -> Result<(), Box<dyn Error>> {
    let farthest = run()?;
    println!("the patch is at most {farthest:.4} from the sphere");
    Ok(())
}
