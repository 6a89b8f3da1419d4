//! The parameters that all hole-filling commands share. To add one, add its constant and its entry in [`SOLVE`] here, and its field
//! and default in [`FillParams`](crate::fill::FillParams).

use super::{Case, Choice, DefaultValue, Kind, NumberBounds, Parameter};

/// Unit of lengths.
pub(super) const MESH_UNIT: &str = "the mesh's unit";

/// Voxel size: the distance of neighbouring nodes of the grid, or `auto`.
pub const VOXEL: Parameter = Parameter {
    name: "voxel",
    field: "voxel",
    kind: Kind::Voxel,
    unit: MESH_UNIT,
    default: DefaultValue::Value("auto"),
    sentence: "Voxel size in the mesh's units.",
    details: "`auto` takes 16 voxels across the hole, 10 if its rim has at most 25 edges, or at most 60 where the surface bends \
              little, more if the hole is a slot, and up to 96 in a region with a small loop. If patches are not finished, it takes \
              32, up to 64 if the rim is finer or the hole is a slot; with curvature-variation 2.5 times as many, at most 128. A \
              length below 1/1024 of the widest hole, or larger than it, is refused; narrower holes than the length get an automatic \
              voxel.",
    ..Parameter::PLAIN
};

/// The bending energy that patches minimise.
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
            sentence: "The integral of the squared gradient of the mean curvature along the surface.",
        },
    ]),
    default: DefaultValue::Value("willmore"),
    sentence: "The bending energy that patches minimise.",
    details: "The default continues spheres, minimal surfaces and tori. It is the more robust one, above all on rough scans. Use \
              curvature-variation for smooth surroundings like a cylinder, a cone or an ellipsoid, which the Willmore energy cannot \
              continue exactly; it takes 10 to 60 times as long, on voxels 0.4 times as large and with finer triangles, and its \
              patches have no expected errors.",
    ..Parameter::PLAIN
};

/// How patches are finished on their own triangles.
pub const FINISH: Parameter = Parameter {
    name: "finish",
    field: "finish",
    kind: Kind::Choice(&[
        Choice {
            name: "auto",
            sentence: "By Newton steps of the Willmore energy, then by surfaces fitted to the surroundings, as far as these predict \
                       the faces at the rim.",
        },
        Choice {
            name: "willmore",
            sentence: "By Newton steps of the Willmore energy.",
        },
        Choice {
            name: "none",
            sentence: "Not at all: the surface of the level set, on finer grids.",
        },
    ]),
    default: DefaultValue::Value("auto"),
    sentence: "How the patches of the level set are finished on their own triangles.",
    details: "Patches of `energy` curvature-variation are not finished.",
    ..Parameter::PLAIN
};

/// Whether sharp edges are continued.
pub const SHARP: Parameter = Parameter {
    name: "sharp",
    field: "sharp",
    kind: Kind::Choice(&[
        Choice {
            name: "auto",
            sentence: "If a patch with sharp edges predicts the faces round the hole clearly better than a smooth one.",
        },
        Choice {
            name: "off",
            sentence: "Never: all patches are smooth.",
        },
    ]),
    default: DefaultValue::Value("auto"),
    sentence: "Whether sharp edges of man-made shapes that end at a hole are continued across it.",
    details: "The smooth sides round the hole are continued as planes and quadrics that meet in edges and corners; these may be rounded \
              between flat sides. Patches that are not finished have no sharp edges.",
    ..Parameter::PLAIN
};

/// Edge length of a patch relative to its surroundings.
pub const EDGE_RATIO: Parameter = Parameter {
    name: "edge_ratio",
    field: "edge_ratio",
    kind: Kind::Number(
        NumberBounds {
            low: 0.05,
            high: 20.0,
            open: true,
        },
        "RATIO",
    ),
    default: DefaultValue::Cases(&[
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
    sentence: "Length of the patch's edges relative to the edges round the hole.",
    ..Parameter::PLAIN
};

/// The counterpart whose shape holes are filled with.
pub const LIKE: Parameter = Parameter {
    name: "like",
    field: "like",
    kind: Kind::Like,
    default: DefaultValue::Words("none"),
    sentence: "Fill holes with the shape of a counterpart: the mesh mirrored (`mirror`), or another mesh of the same kind of object.",
    details: "The plane of symmetry is searched, or given by a point and a normal. The other mesh is rotated and translated to fit, and scaled if it is of another size. The \
              part of it that lies at the hole is joined to the rim by a smooth field of offsets. It is used only if it predicts the \
              faces around the hole; the report says how well.",
    ..Parameter::PLAIN
};

/// Whether patches get grain.
pub const GRAIN: Parameter = Parameter {
    name: "grain",
    field: "grain",
    sentence: "Give patches the roughness of their surroundings, so that they do not look like plastic.",
    details: "The roughness is simulated with the covariance of the residuals of a smooth patch around the hole, the same at \
              each run. The report gives the roughness of the patch and of its surroundings; expected errors do not include it.",
    ..Parameter::PLAIN
};

/// Whether each rim is closed by itself.
pub const APART: Parameter = Parameter {
    name: "apart",
    field: "apart",
    sentence: "Close each rim by itself: join only rims that `bridge` names.",
    details: "Without it an island and its hole are joined, and so are the rims on the two sides of a wall, by the edge of an opening, \
              or of a bore, by its wall. For an implant each side is wanted by itself. Borders of islands stay open.",
    ..Parameter::PLAIN
};

/// The parameters that all hole-filling commands share.
pub const SOLVE: &[Parameter] = &[VOXEL, ENERGY, FINISH, SHARP, LIKE, GRAIN, APART, EDGE_RATIO];

/// Diameter above which holes stay open.
pub const MAX_DIAMETER: Parameter = Parameter {
    name: "max_diameter",
    field: "max_diameter",
    kind: Kind::Number(NumberBounds::POSITIVE, "LENGTH"),
    unit: MESH_UNIT,
    sentence: "Leave holes open that are wider than this, in the mesh's units.",
    details: "Holes that are named are filled whatever their width.",
    ..Parameter::PLAIN
};
