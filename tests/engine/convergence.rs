//! Level-set fills of exact surfaces: error bounds and second-order convergence.

use isomend::study::experiments::{PatchError, fill_shape, patch_error};
use isomend::study::shapes::ExactShape;
use isomend_core::flow::{Energy, FlowSettings, Variant};

/// Upper bound of the iterations of the preconditioned solver in one step, at any resolution.
const MOST_ITERATIONS: usize = 6;

/// The error of a fill with `16 · 2^refinements` voxels across the unknown ball.
fn errors(shape: &ExactShape, refinements: usize) -> PatchError {
    let solved = fill_shape(shape, refinements, FlowSettings::default(), &|| true);
    assert!(solved.converged(), "{}", shape.name);
    for level in &solved.reports {
        for step in &level.flow.steps {
            assert!(step.iterations <= MOST_ITERATIONS, "{}", shape.name);
        }
    }
    patch_error(shape, &solved).expect("a foot for every node")
}

#[test]
fn a_plane_is_filled_exactly() {
    assert!(errors(&ExactShape::plane(), 0).largest < 1e-6);
}

/// With 32 voxels across, the largest error is below 1.56e-4 of the diameter for a cap of 60 degrees and below 4.5e-4 for a
/// cap of 90 degrees.
#[test]
fn sphere_caps_are_within_bounds() {
    for (degrees, bound) in [(60.0f64, 1.56e-4), (90.0, 4.5e-4)] {
        let error = errors(&ExactShape::sphere_cap("cap", degrees), 1);
        println!("sphere {degrees}: {error:?}");
        assert!(error.largest < bound, "{degrees}: {error:?}");
    }
}

#[test]
fn the_catenoid_and_the_inner_torus_converge_at_second_order() {
    let inner = ExactShape::clifford_torus("inner torus", 0.6, false);
    let bounds = [
        (ExactShape::catenoid(), 4.9e-4, 1.2e-4),
        (inner, 5.2e-4, 1.3e-4),
    ];
    for (shape, at32, at64) in bounds {
        let (coarse, fine) = (errors(&shape, 1), errors(&shape, 2));
        println!("{}: {coarse:?} {fine:?}", shape.name);
        assert!(
            coarse.largest < 1.2 * at32 && fine.largest < 1.2 * at64,
            "{}: {coarse:?} {fine:?}",
            shape.name
        );
        let order = (coarse.rms / fine.rms).log2();
        assert!(order > 1.8, "{}: order {order:.2}", shape.name);
    }
}

/// A cyclide is a Möbius image of the Clifford torus, and therefore also a critical point of the Willmore energy.
#[test]
fn a_cyclide_is_continued_within_bounds() {
    let (coarse, fine) = (
        errors(&ExactShape::cyclide(), 0),
        errors(&ExactShape::cyclide(), 1),
    );
    println!("{coarse:?} {fine:?}");
    assert!(
        coarse.largest < 2e-4 && fine.largest < 7e-5,
        "{coarse:?} {fine:?}"
    );
}

#[test]
fn all_variants_converge_to_the_same_energy() {
    let shape = ExactShape::clifford_torus("outer torus", 1.0, true);
    let ends: Vec<f64> = [Variant::I, Variant::II, Variant::GaussNewton]
        .into_iter()
        .map(|variant| {
            let flow = FlowSettings {
                variant,
                max_steps: 60,
                ..FlowSettings::default()
            };
            let solved = fill_shape(&shape, 0, flow, &|| true);
            assert!(solved.converged(), "{variant:?}");
            solved.reports[0].flow.energy_after
        })
        .collect();
    for e in &ends {
        assert!((e / ends[2] - 1.0).abs() < 1e-3, "{ends:?}");
    }
}

/// The Willmore energy cannot continue cylinders and ellipsoids. With 32 voxels across, the energy of curvature variation is
/// within 1.2 times 3.8e-4 and 11e-4 of the diameter, at least ten times closer than the Willmore energy.
#[test]
fn the_variation_of_curvature_continues_cylinders_and_ellipsoids() {
    let flow = FlowSettings {
        energy: Energy::CurvatureVariation,
        ..FlowSettings::default()
    };
    for (name, bound) in [("cylinder", 1.2 * 3.8e-4), ("ellipsoid", 1.2 * 1.1e-3)] {
        let shape = ExactShape::all()
            .into_iter()
            .find(|s| s.name == name)
            .expect("a shape of the study");
        let solved = fill_shape(&shape, 1, flow, &|| true);
        assert!(solved.converged(), "{name}");
        let ran: Vec<Energy> = solved.reports.iter().map(|r| r.flow.energy).collect();
        let after = Energy::CurvatureVariation;
        assert_eq!(ran, [Energy::Willmore, after, after]);
        let error = patch_error(&shape, &solved).expect("a foot for every node");
        let willmore = errors(&shape, 1);
        println!("{name}: {error:?}, Willmore {willmore:?}");
        assert!(error.largest < bound, "{name}: {error:?}");
        assert!(10.0 * error.largest < willmore.largest, "{name}");
    }
}
