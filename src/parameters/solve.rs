//! The parameters that all commands share which fill holes. To add one: its constant and its place in [`SOLVE`] here, and its
//! field and default in [`FillParams`](crate::FillParams).

use super::{Bounds, Case, Choice, Kind, Parameter, Usual};

/// Lengths are in it.
pub(super) const MESH_UNIT: &str = "the mesh's unit";

/// Most steps of the flow on a grid: each is kept in the report.
pub const MOST_STEPS: usize = 1_000_000;

/// `auto`, or the distance of neighbouring nodes of the grid.
pub const VOXEL: Parameter = Parameter {
    name: "voxel",
    field: "voxel",
    kind: Kind::Voxel,
    unit: MESH_UNIT,
    default: Usual::Value("auto"),
    sentence: "Voxel size in the mesh's units.",
    details: "`auto` takes 16 voxels across the hole, 12 where its rim has at most 25 edges, more where it is a slot, up to 96 in a region with a small loop. Where patches \
              are not finished it takes 32, up to 64 where the rim is finer or the hole is a slot; with curvature-variation 2.5 times \
              as many, at most 128. A length of less than 1/1024 of the hole is refused.",
    ..Parameter::PLAIN
};

/// The energy that patches minimise.
pub const ENERGY: Parameter = Parameter {
    name: "energy",
    field: "energy",
    kind: Kind::Choice(&[
        Choice {
            name: "willmore",
            sentence: "The integral of the squared mean curvature.",
        },
        Choice {
            name: "curvature-variation",
            sentence: "The integral of the squared slope of the mean curvature along the surface.",
        },
    ]),
    default: Usual::Value("willmore"),
    sentence: "What the patch makes small.",
    details: "The default continues spheres, minimal surfaces and tori and is the most robust, on rough scans above all. Take the \
              other where the surroundings are smooth and like a cylinder, a cone or an ellipsoid, which the Willmore energy cannot \
              continue exactly; it takes a few times as long, on voxels 0.4 times as large and with finer triangles.",
    ..Parameter::PLAIN
};

/// How patches are finished.
pub const FINISH: Parameter = Parameter {
    name: "finish",
    field: "finish",
    kind: Kind::Choice(&[
        Choice {
            name: "auto",
            sentence: "By Newton steps of the Willmore energy, and by what the surroundings predict as far as that proves itself at \
                       the rim.",
        },
        Choice {
            name: "willmore",
            sentence: "By Newton steps of the Willmore energy.",
        },
        Choice {
            name: "none",
            sentence: "Not at all: the level set's surface as it is, on finer grids.",
        },
    ]),
    default: Usual::Value("auto"),
    sentence: "How patches are finished on their own triangles, once the level set has found them.",
    details: "Patches of `energy` curvature-variation, and those with `steps` or `time_step`, are not finished.",
    ..Parameter::PLAIN
};

/// Whether sharp edges are continued.
pub const SHARP: Parameter = Parameter {
    name: "sharp",
    field: "sharp",
    kind: Kind::Choice(&[
        Choice {
            name: "auto",
            sentence: "Where that predicts the faces round the hole clearly better than a smooth patch.",
        },
        Choice {
            name: "off",
            sentence: "Never: all patches are smooth.",
        },
    ]),
    default: Usual::Value("auto"),
    sentence: "Whether sharp edges of man-made shapes that end at a hole are continued across it.",
    details: "The smooth sides round the hole are continued as planes and quadrics, and meet in edges and corners, which between flat \
              sides may be rounded. Patches that are not finished have none.",
    ..Parameter::PLAIN
};

/// The scheme of the flow's steps.
pub const VARIANT: Parameter = Parameter {
    name: "variant",
    field: "variant",
    kind: Kind::Choice(&[
        Choice {
            name: "I",
            sentence: "",
        },
        Choice {
            name: "II",
            sentence: "",
        },
        Choice {
            name: "gauss-newton",
            sentence: "",
        },
    ]),
    default: Usual::Value("gauss-newton"),
    sentence: "Scheme of the flow's steps: I and II are the paper's, for the Willmore energy; all have the same steady surface.",
    ..Parameter::PLAIN
};

/// The time step of the flow.
pub const TIME_STEP: Parameter = Parameter {
    name: "time_step",
    field: "time_step",
    kind: Kind::Number(Bounds::POSITIVE, "T"),
    unit: "the voxel size to the fourth power",
    default: Usual::Words("straight to the steady state"),
    sentence: "Time step of the flow, in units of the voxel size to the fourth power.",
    details: "The flow then runs on one grid for all its steps.",
    ..Parameter::PLAIN
};

/// The largest number of steps.
pub const STEPS: Parameter = Parameter {
    name: "steps",
    field: "steps",
    kind: Kind::Whole(MOST_STEPS),
    default: Usual::Cases(&[
        Case {
            value: "20",
            with: None,
        },
        Case {
            value: "200",
            with: Some(("variant", &["I", "II"])),
        },
    ]),
    sentence: "Most steps of the flow on each grid.",
    ..Parameter::PLAIN
};

/// The size of the patch's triangles.
pub const EDGE_RATIO: Parameter = Parameter {
    name: "edge_ratio",
    field: "edge_ratio",
    kind: Kind::Number(
        Bounds {
            low: 0.05,
            high: 20.0,
            open: true,
        },
        "RATIO",
    ),
    default: Usual::Cases(&[
        Case {
            value: "0.7",
            with: None,
        },
        Case {
            value: "0.8",
            with: Some(("finish", &["none"])),
        },
        Case {
            value: "0.45",
            with: Some(("energy", &["curvature-variation"])),
        },
    ]),
    sentence: "Length of the patch's edges over that of the edges round the hole.",
    ..Parameter::PLAIN
};

/// What holes are filled after.
pub const LIKE: Parameter = Parameter {
    name: "like",
    field: "like",
    kind: Kind::Like,
    default: Usual::Words("nothing but their surroundings"),
    sentence: "Fill holes after a counterpart: the mesh mirrored (`mirror`), or another mesh of the same kind of object.",
    details: "The plane of symmetry is looked for, or given by a point and a normal; the other mesh is turned and shifted to fit. What \
              lies at the hole is joined to its rim by a smooth field of offsets. It is taken only where it predicts the faces round the \
              hole, which the report tells.",
    ..Parameter::PLAIN
};

/// Whether a template may be scaled.
pub const LIKE_SCALE: Parameter = Parameter {
    name: "like_scale",
    field: "like_scale",
    sentence: "Scale the mesh that `like` names to fit.",
    ..Parameter::PLAIN
};

/// Whether patches get grain.
pub const GRAIN: Parameter = Parameter {
    name: "grain",
    field: "grain",
    sentence: "Give patches the roughness of their surroundings, so that they do not look like plastic.",
    details: "It is invented: simulated with the covariance of what a smooth patch leaves out round the hole, the same each time. The \
              report says how rough the patch and its surroundings are; expected errors do not count it.",
    ..Parameter::PLAIN
};

/// The parameters that all commands share which fill holes.
pub const SOLVE: &[Parameter] = &[
    VOXEL, ENERGY, FINISH, SHARP, LIKE, LIKE_SCALE, GRAIN, VARIANT, TIME_STEP, STEPS, EDGE_RATIO,
];

/// The widest hole to fill.
pub const MAX_DIAMETER: Parameter = Parameter {
    name: "max_diameter",
    field: "max_diameter",
    kind: Kind::Number(Bounds::POSITIVE, "LENGTH"),
    unit: MESH_UNIT,
    sentence: "Leave holes open that are wider than this, in the mesh's units.",
    ..Parameter::PLAIN
};
