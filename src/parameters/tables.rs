//! The parameters of each command. To add one: its place in the table of its command here, and its field and default in the
//! command's struct of parameters.

use super::solve::{EDGE_RATIO, ENERGY, MAX_DIAMETER, MESH_UNIT, VARIANT, VOXEL};
use super::{Bounds, Choice, Kind, Parameter, Table, Usual};

/// Most samples of a surface, so that they fit into memory.
pub const MOST_SAMPLES: usize = 100_000_000;

/// Whether open sheets stand on a flat base.
const FLAT_BASE: Parameter = Parameter {
    name: "flat_base",
    field: "flat_base",
    sentence: "Put open sheets such as terrains on a flat base, with straight walls down from their outer borders.",
    details: "The base is perpendicular to the axis along which the border is seen widest, on the side away from the surface. Holes inside \
              the sheet are filled as usual.",
    ..Parameter::PLAIN
};

/// How far below a sheet its base lies.
pub(crate) const BASE_OFFSET: Parameter = Parameter {
    name: "base_offset",
    field: "base_offset",
    kind: Kind::Number(Bounds::NOT_NEGATIVE, "LENGTH"),
    unit: MESH_UNIT,
    default: Usual::Words("the mean edge of the border"),
    sentence: "How far below the lowest vertex of its sheet the base of `flat_base` lies, in the mesh's units.",
    ..Parameter::PLAIN
};

/// `isomend fill`.
pub const FILL: Table = Table {
    command: "fill",
    own: &[
        Parameter {
            name: "holes",
            field: "holes",
            kind: Kind::Holes(true),
            default: Usual::Value("all"),
            sentence: "Numbers of the holes to fill; of all holes the outer borders of open sheets stay open.",
            details: "Numbers are those of `isomend inspect`. An outer border is filled when it is named here.",
            ..Parameter::PLAIN
        },
        Parameter {
            details: "Holes that `holes` names are filled nevertheless.",
            ..MAX_DIAMETER
        },
        Parameter {
            name: "keep_open",
            field: "keep_open",
            kind: Kind::Holes(false),
            sentence: "Numbers of holes to leave open.",
            ..Parameter::PLAIN
        },
        Parameter {
            name: "bridge",
            field: "bridge",
            kind: Kind::Groups,
            default: Usual::Words("near ones are joined"),
            sentence: "Groups of holes to fill in one region each, whatever their distance.",
            details: "On the command line such as `3+7` or `3+7+9`; may be given several times.",
            ..Parameter::PLAIN
        },
        FLAT,
        Parameter {
            name: "crease",
            field: "crease",
            kind: Kind::Pairs,
            default: Usual::Words("those that predict the faces round the hole"),
            sentence: "Pairs of crease ends between which a sharp edge is continued across their hole.",
            details: "Numbers are those of `isomend inspect -v`, such as `1+2`; may be given several times. In a hole with such a pair \
                      it is not asked whether sharp edges predict the faces round it.",
            ..Parameter::PLAIN
        },
        FLAT_BASE,
        BASE_OFFSET,
        Parameter {
            name: "surface",
            field: "surface",
            kind: Kind::Choice(&[
                Choice {
                    name: "stitched",
                    sentence: "The mesh with the patches stitched in.",
                },
                Choice {
                    name: "whole",
                    sentence: "The zero sets of the level sets alone, as marching cubes gives them.",
                },
            ]),
            default: Usual::Value("stitched"),
            sentence: "What is returned or written: the mesh with its patches, or the level sets alone.",
            details: "The level sets have the triangles of the grid, without an `edge_ratio`, and are not finished.",
            ..Parameter::PLAIN
        },
        Parameter {
            name: "repair",
            sentence: "First mend what else is wrong, as `isomend repair` does; numbers of holes are those of the input.",
            details: "The exit code is that of `isomend check` on what is written.",
            ..Parameter::PLAIN
        },
    ],
    solve: Some(""),
};

/// Whether vertices keep their numbers.
const KEEP_VERTICES: Parameter = Parameter {
    name: "keep_vertices",
    field: "keep_vertices",
    sentence: "Keep vertices that no face uses any more, so that those of the input keep their numbers.",
    library_only: true,
    ..Parameter::PLAIN
};

/// How much of a damaged shape is kept.
pub(crate) const KEEP_SHAPE: Parameter = Parameter {
    name: "keep_shape",
    field: "keep_shape",
    kind: Kind::Number(Bounds::PART, "W"),
    default: Usual::Value("0"),
    sentence: "How much of the damaged shape to keep, from 0 (nothing) to 1 (all that the grid can hold).",
    details: "With W the flow starts from the damaged surface and is pulled to it: features narrower than about (1 - W) / W times the \
              diameter of the region go, wider ones stay.",
    ..Parameter::PLAIN
};

/// `isomend restore`.
pub const RESTORE: Table = Table {
    command: "restore",
    own: &[KEEP_SHAPE, KEEP_VERTICES],
    solve: Some("fill"),
};

/// How far a surface is faired, as a length.
pub(crate) const STRENGTH: Parameter = Parameter {
    name: "strength",
    field: "extent.strength",
    kind: Kind::Number(Bounds::POSITIVE, "LENGTH"),
    unit: MESH_UNIT,
    default: Usual::Words("eight mean edges, more on surfaces of over 400,000 faces"),
    sentence: "Features narrower than this length go, in the mesh's units.",
    details: "Waves of this length lose all but a third of their height, those of half of it everything. It is the time \
              (LENGTH / 2 pi)^4.",
    excludes: "time",
    ..Parameter::PLAIN
};

/// How far a surface is faired, as a time.
pub(crate) const TIME: Parameter = Parameter {
    name: "time",
    field: "extent.time",
    kind: Kind::Number(Bounds::POSITIVE, "T"),
    unit: "the mesh's unit to the fourth power",
    default: Usual::Words("that of the strength"),
    sentence: "Time of the Willmore flow, in the mesh's units to the fourth power.",
    excludes: "strength",
    ..Parameter::PLAIN
};

/// The size of a faired surface's triangles.
pub(crate) const FAIR_EDGE_RATIO: Parameter = Parameter {
    default: Usual::Value("1"),
    sentence: "Length of the new edges over that of the edges round the region, or over the mean of all.",
    ..EDGE_RATIO
};

/// `isomend fair`.
pub const FAIR: Table = Table {
    command: "fair",
    own: &[
        STRENGTH,
        TIME,
        Parameter {
            details: "`auto` is an eighth of the features that go, at least a third of the mean edge, and more on large models.",
            ..VOXEL
        },
        VARIANT,
        FAIR_EDGE_RATIO,
        KEEP_VERTICES,
    ],
    solve: None,
};

/// Distance within which vertices of the border are merged.
pub(crate) const WELD: Parameter = Parameter {
    name: "weld",
    field: "weld",
    kind: Kind::Number(Bounds::POSITIVE, "LENGTH"),
    unit: MESH_UNIT,
    sentence: "Merge vertices of the border that are no farther apart than this, in the mesh's units. Those at exactly the same \
               position are merged anyway, and by default those of edges that coincide but for the precision of the coordinates.",
    ..Parameter::PLAIN
};

/// Holes that get flat caps.
pub(crate) const FLAT: Parameter = Parameter {
    name: "flat",
    field: "flat",
    kind: Kind::Holes(false),
    sentence: "Numbers of holes to close by nearly flat caps instead of continuing the surface: necks, bases, mouths of \
               vessels.",
    details: "The caps are the surfaces of least area with their rims. Their vertices are as dense as those round the hole.",
    ..Parameter::PLAIN
};

/// Size below which components are taken out.
pub(crate) const DEBRIS: Parameter = Parameter {
    name: "debris",
    field: "debris",
    kind: Kind::Number(Bounds::PART, "PART"),
    default: Usual::Words("they stay"),
    sentence: "Take out components with less than this part, from 0 to 1, of the area of the largest one.",
    ..Parameter::PLAIN
};

/// Thickness of walls.
pub(crate) const WALL: Parameter = Parameter {
    name: "wall",
    field: "wall",
    kind: Kind::Number(Bounds::POSITIVE, "LENGTH"),
    unit: MESH_UNIT,
    default: Usual::Words("a mean edge of the component"),
    sentence: "Thickness of the walls that `close_borders` makes of open sheets which no flat cap closes, in the mesh's units.",
    details: "Walls are thinner where they would cross something; the report says how thick they are.",
    ..Parameter::PLAIN
};

/// Thickness below which walls are defects.
pub(crate) const MIN_WALL: Parameter = Parameter {
    name: "min_wall",
    field: "min_wall",
    kind: Kind::Number(Bounds::POSITIVE, "LENGTH"),
    unit: MESH_UNIT,
    sentence: "Say no where a wall is thinner than this, in the mesh's units.",
    details: "A wall is a patch of the surface whose other side is parallel to it within 15 degrees: sharp edges are none.",
    ..Parameter::PLAIN
};

/// `isomend repair`.
pub const REPAIR: Table = Table {
    command: "repair",
    own: &[
        WELD,
        DEBRIS,
        Parameter {
            field: "fill.flat_base",
            ..FLAT_BASE
        },
        Parameter {
            field: "fill.base_offset",
            ..BASE_OFFSET
        },
        Parameter {
            name: "drop_inside",
            field: "drop_inside",
            sentence: "Take out components that lie wholly inside another one.",
            ..Parameter::PLAIN
        },
        Parameter {
            name: "keep_duplicates",
            field: "clean",
            kind: Kind::Flag(false),
            sentence: "Leave coinciding vertices, and degenerate and duplicate faces.",
            ..Parameter::PLAIN
        },
        Parameter {
            name: "keep_orientation",
            field: "orient",
            kind: Kind::Flag(false),
            sentence: "Turn no faces over.",
            ..Parameter::PLAIN
        },
        Parameter {
            name: "keep_non_manifold",
            field: "split",
            kind: Kind::Flag(false),
            sentence: "Leave edges with more than two faces, and vertices where surfaces meet in a point only.",
            ..Parameter::PLAIN
        },
        Parameter {
            name: "keep_crossings",
            field: "crossings",
            kind: Kind::Flag(false),
            sentence: "Leave faces that cross others.",
            ..Parameter::PLAIN
        },
        Parameter {
            name: "drop_unused",
            field: "drop_unused",
            sentence: "Drop vertices that no face of the input uses.",
            ..Parameter::PLAIN
        },
        Parameter {
            name: "keep_holes",
            field: "holes",
            kind: Kind::Flag(false),
            sentence: "Leave the holes of the mesh open; those that the repair makes are filled.",
            excludes: "close_borders",
            ..Parameter::PLAIN
        },
        Parameter {
            name: "close_borders",
            field: "borders",
            sentence: "Close the outer borders of open sheets too, which are left open otherwise.",
            excludes: "keep_holes",
            ..Parameter::PLAIN
        },
        WALL,
        Parameter {
            default: Usual::Words(
                "half a mean edge for walls that the repair makes, others are only told",
            ),
            ..MIN_WALL
        },
        Parameter {
            field: "fill.max_diameter",
            ..MAX_DIAMETER
        },
        Parameter {
            field: "fill.flat",
            ..FLAT
        },
    ],
    solve: Some("fill"),
};

/// Thickness below which parts are looked for.
pub(crate) const THIN: Parameter = Parameter {
    name: "thin",
    field: "thin",
    kind: Kind::Number(Bounds::POSITIVE, "LENGTH"),
    unit: MESH_UNIT,
    sentence: "Also look for parts thinner than this, in the mesh's units.",
    details: "The thickness at a face is the length of the ray from its centre inward to the next face that faces the other \
              way, within 60 degrees; faces that share a vertex with it do not count.",
    ..Parameter::PLAIN
};

/// `isomend check`.
pub const CHECK: Table = Table {
    command: "check",
    own: &[
        THIN,
        Parameter {
            default: Usual::Words("the least and the mean wall are only told"),
            ..MIN_WALL
        },
        Parameter {
            default: Usual::Value("0.01"),
            sentence: "Call components debris that have less than this part, from 0 to 1, of the area of the largest one.",
            ..DEBRIS
        },
    ],
    solve: None,
};

/// Distance at which distances are cut off.
pub(crate) const BAND: Parameter = Parameter {
    name: "band",
    field: "band",
    kind: Kind::Band,
    unit: MESH_UNIT,
    default: Usual::Value("full"),
    sentence: "Cut distances off at this length, which is faster; `full` keeps all.",
    ..Parameter::PLAIN
};

/// `isomend sdf`.
pub const SDF: Table = Table {
    command: "sdf",
    own: &[
        Parameter {
            sentence: "Distance of neighbouring nodes in the mesh's units; `auto` takes 1/128 of the longest side.",
            details: "",
            ..VOXEL
        },
        BAND,
    ],
    solve: None,
};

/// `isomend compare`.
pub const COMPARE: Table = Table {
    command: "compare",
    own: &[Parameter {
        name: "samples",
        field: "samples",
        kind: Kind::Whole(MOST_SAMPLES),
        default: Usual::Value("100000"),
        sentence: "Samples on each mesh, at most 100 million.",
        ..Parameter::PLAIN
    }],
    solve: None,
};

/// `isomend study`, whose other options are no parameters of a work.
pub const STUDY: Table = Table {
    command: "study",
    own: &[ENERGY],
    solve: None,
};

impl Table {
    /// `isomend fill`.
    pub const FILL: &'static Self = &FILL;
    /// `isomend repair`.
    pub const REPAIR: &'static Self = &REPAIR;
    /// `isomend restore`.
    pub const RESTORE: &'static Self = &RESTORE;
    /// `isomend fair`.
    pub const FAIR: &'static Self = &FAIR;
    /// `isomend check`.
    pub const CHECK: &'static Self = &CHECK;
    /// `isomend sdf`.
    pub const SDF: &'static Self = &SDF;
    /// `isomend compare`.
    pub const COMPARE: &'static Self = &COMPARE;
    /// `isomend study`.
    pub const STUDY: &'static Self = &STUDY;
    /// Those of the commands that work on meshes.
    pub const ALL: [&'static Self; 7] = [
        Self::FILL,
        Self::REPAIR,
        Self::RESTORE,
        Self::FAIR,
        Self::CHECK,
        Self::SDF,
        Self::COMPARE,
    ];
}
