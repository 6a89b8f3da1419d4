//! Fills a hole in the wall of a tube with a bending energy that the program defines, and prints the patch's distance from the tube:
//! `cargo run --release --example own_energy`.
//!
//! `½∫(h − h₀)² dA` is zero on the tube if the target h₀ is the tube's own mean curvature, 1/r. The Willmore energy has h₀ = 0; the tube
//! is not one of its steady states, so that its patch differs from the tube.

use std::error::Error;
use std::f64::consts::TAU;

use isomend::glam::DVec3;
use isomend::{
    BendingEnergy, Closure, Control, Density, FillParams, Filled, Finish, Hole, Mesh, inspect,
};

/// Radius of the tube.
const RADIUS: f64 = 1.0;
/// Vertices round the tube.
const AROUND: u32 = 48;
/// Rings of vertices along the tube.
const RINGS: u32 = 33;
/// Angle between the hole's middle and its rim, seen from the axis, in radians; the hole is about as long as it is wide.
const HALF_ANGLE: f64 = 0.9;

/// The energy of Helfrich (1973, equation 12) with a spontaneous curvature.
struct Helfrich {
    /// h₀: the mean curvature (sum of the principal curvatures) at which the energy density is zero, in 1/length.
    spontaneous: f64,
}

impl BendingEnergy for Helfrich {
    fn density(&self, _: DVec3, h: f64) -> Density {
        let excess = h - self.spontaneous;
        Density::new(0.5 * excess * excess, excess, 1.0)
    }
}

/// An open tube along z with a round hole in its wall, on the side of +x.
fn tube() -> Mesh {
    let mut mesh = Mesh::default();
    let step = TAU * RADIUS / f64::from(AROUND);
    for ring in 0..RINGS {
        for i in 0..AROUND {
            let angle = TAU * (f64::from(i) + 0.5 * f64::from(ring % 2)) / f64::from(AROUND);
            let z = step * (f64::from(ring) - 0.5 * f64::from(RINGS - 1));
            let (y, x) = angle.sin_cos();
            mesh.positions.push(DVec3::new(RADIUS * x, RADIUS * y, z));
        }
    }
    let vertex = |ring: u32, i: u32| ring * AROUND + i % AROUND;
    for ring in 0..RINGS - 1 {
        for i in 0..AROUND {
            let [a, b] = [vertex(ring, i), vertex(ring, i + 1)];
            let [c, d] = [vertex(ring + 1, i), vertex(ring + 1, i + 1)];
            mesh.faces.extend(match ring % 2 {
                0 => [[a, b, c], [b, d, c]],
                _ => [[a, b, d], [a, d, c]],
            });
        }
    }
    let is_in_hole = |v: u32| {
        let p = mesh.positions[v as usize];
        p.y.atan2(p.x).hypot(p.z / RADIUS) < HALF_ANGLE
    };
    mesh.faces
        .retain(|face| !face.iter().any(|&v| is_in_hole(v)));
    mesh
}

/// The largest distance of the patch's vertices from the tube.
fn farthest(mesh: &Mesh, filled: &Filled) -> f64 {
    let patch = &filled.mesh.positions[mesh.positions.len()..];
    let distances = patch.iter().map(|p| (p.x.hypot(p.y) - RADIUS).abs());
    distances.fold(0.0, f64::max)
}

/// Fills the hole with the Willmore energy and with Helfrich's; returns the largest distance of each patch from the tube, in radii.
pub fn run() -> Result<[f64; 2], Box<dyn Error>> {
    let mesh = tube();
    let found = inspect(&mesh)?;
    // The tube's ends are boundary loops too; their centres are on the axis.
    let is_in_wall = |hole: &&Hole| hole.centre.x > 0.5 * RADIUS;
    let hole = found
        .holes
        .iter()
        .find(is_in_wall)
        .ok_or("the tube has no hole")?;
    // Without the finish, which would predict the tube from the hole's surroundings whatever the energy.
    let params = FillParams::new()
        .with_holes([hole.id])
        .with_finish(Finish::None);
    let control = Control::new();

    let willmore = found.fill(&params, &control)?;
    let helfrich = Helfrich {
        spontaneous: 1.0 / RADIUS,
    };
    let own = found.fill_with(&params, &helfrich, &control)?;
    for filled in [&willmore, &own] {
        let outcome = &filled.report.holes[hole.id.get() - 1].outcome;
        if outcome.closure() != Some(&Closure::LevelSet) || !filled.report.regions[0].converged {
            return Err(format!("the hole was not filled: {outcome:?}").into());
        }
    }
    let [away, near] = [&willmore, &own].map(|filled| farthest(&mesh, filled) / RADIUS);
    if near > 0.2 * away {
        return Err(format!("{near} from the tube, and {away} without a target curvature").into());
    }
    Ok([away, near])
}

fn main() -> Result<(), Box<dyn Error>> {
    let [away, near] = run()?;
    println!("by the Willmore energy the patch is up to {away:.4} radii from the tube,");
    println!("with the tube's curvature as the target up to {near:.4}");
    Ok(())
}
