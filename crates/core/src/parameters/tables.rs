//! The tables of parameters of each command. To add one, add its entry in the table of its command here, and its field and default
//! in the command's parameter struct.

use super::solve::{EDGE_RATIO, ENERGY, MAX_DIAMETER, MESH_UNIT, VOXEL};
use super::{Choice, DefaultValue, Kind, NumberBounds, Parameter, Table};

/// Upper bound of the number of samples on a mesh, so that they fit into memory.
pub const MOST_SAMPLES: usize = 100_000_000;

/// A former parameter of all commands that fill holes.
const LIKE_SCALE: (&str, &str) = (
    "like_scale",
    "--like, which scales where that fits better by far",
);

/// Whether open sheets are closed by walls and a flat base.
const FLAT_BASE: Parameter = Parameter {
    name: "flat_base",
    field: "flat_base",
    sentence: "Put open sheets such as terrains on a flat base, with straight walls down from their outer borders.",
    details: "The base is perpendicular to the axis along which the border's projection has the largest area, on the side away from the \
              surface. Holes inside the sheet are filled as usual.",
    ..Parameter::PLAIN
};

/// Distance of the base below its sheet.
pub(crate) const BASE_OFFSET: Parameter = Parameter {
    name: "base_offset",
    field: "base_offset",
    kind: Kind::Number(NumberBounds::NOT_NEGATIVE, "LENGTH"),
    unit: MESH_UNIT,
    default: DefaultValue::Words("the mean edge of the border"),
    sentence: "Distance from the lowest vertex of the sheet down to the base of `flat_base`, in the mesh's units.",
    ..Parameter::PLAIN
};

/// The holes to fill.
const HOLES: Parameter = Parameter {
    name: "holes",
    field: "holes",
    kind: Kind::Holes(true),
    default: DefaultValue::Value("all"),
    sentence: "Numbers of the holes to fill; with `all`, the outer borders of open sheets stay open.",
    details: "`isomend inspect` lists the numbers. An outer border is filled only if it is named here.",
    ..Parameter::PLAIN
};

/// Holes that stay open.
const KEEP_OPEN: Parameter = Parameter {
    name: "keep_open",
    field: "keep_open",
    kind: Kind::Holes(false),
    sentence: "Numbers of holes to leave open.",
    ..Parameter::PLAIN
};

/// Holes that are filled together.
const BRIDGE: Parameter = Parameter {
    name: "bridge",
    field: "bridge",
    kind: Kind::Groups,
    default: DefaultValue::Words("holes that are near each other share a region"),
    sentence: "Groups of holes to fill in one region each, whatever their distance.",
    details: "Written as `3+7` or `3+7+9` on the command line; may be given several times.",
    ..Parameter::PLAIN
};

/// Ends of sharp edges between which an edge is continued.
const CREASE: Parameter = Parameter {
    name: "crease",
    field: "crease",
    kind: Kind::Pairs,
    default: DefaultValue::Words("the pairs that predict the faces round the hole"),
    sentence: "Pairs of crease ends between which a sharp edge is continued across their hole.",
    details: "Written as `1+2`, with the numbers that `isomend inspect -v` lists; may be given several times. In a hole with a \
              given pair, sharp edges are continued without the test of `sharp`.",
    ..Parameter::PLAIN
};

/// `isomend fill`.
pub const FILL: Table = Table {
    command: "fill",
    own: &[
        HOLES,
        Parameter {
            details: "Holes that `holes` names are filled even if they are wider.",
            ..MAX_DIAMETER
        },
        KEEP_OPEN,
        BRIDGE,
        FLAT,
        CREASE,
        FLAT_BASE,
        BASE_OFFSET,
    ],
    solve: Some(""),
    former: &[
        (
            "repair",
            "`isomend repair`, which takes the options of a fill",
        ),
        LIKE_SCALE,
    ],
};

/// Whether unused vertices stay, so that vertices keep their numbers.
const KEEP_VERTICES: Parameter = Parameter {
    name: "keep_vertices",
    field: "keep_vertices",
    sentence: "Keep vertices that no face uses any more, so that the input's vertices keep their numbers.",
    library_only: true,
    ..Parameter::PLAIN
};

/// How much of the old shape a restored region keeps.
pub(crate) const KEEP_SHAPE: Parameter = Parameter {
    name: "keep_shape",
    field: "keep_shape",
    kind: Kind::Number(NumberBounds::PART, "W"),
    default: DefaultValue::Value("0"),
    sentence: "How much of the old shape to keep, from 0 (nothing) to 1 (everything that the grid can represent).",
    details: "The flow starts from the old surface and is attracted to it: features narrower than about (1 - W) / W times the diameter \
              of the region disappear, wider ones stay.",
    ..Parameter::PLAIN
};

/// `isomend restore`.
pub const RESTORE: Table = Table {
    command: "restore",
    own: &[KEEP_SHAPE, KEEP_VERTICES],
    solve: Some("fill"),
    former: &[LIKE_SCALE],
};

/// Amount of fairing, as a length.
pub(crate) const STRENGTH: Parameter = Parameter {
    name: "strength",
    field: "extent.strength",
    kind: Kind::Number(NumberBounds::POSITIVE, "LENGTH"),
    unit: MESH_UNIT,
    default: DefaultValue::Words("eight mean edges, more on surfaces of over 400,000 faces"),
    sentence: "Features narrower than this length disappear, in the mesh's units.",
    details: "Waves of this length keep about a third of their height, waves of half this length nothing. The flow time is \
              (LENGTH / 2 pi)^4.",
    excludes: "time",
    ..Parameter::PLAIN
};

/// Amount of fairing, as a flow time.
pub(crate) const TIME: Parameter = Parameter {
    name: "time",
    field: "extent.time",
    kind: Kind::Number(NumberBounds::POSITIVE, "T"),
    unit: "the mesh's unit to the fourth power",
    default: DefaultValue::Words("the time of the strength"),
    sentence: "Time of the Willmore flow, in the mesh's units to the fourth power.",
    excludes: "strength",
    ..Parameter::PLAIN
};

/// Edge length of a faired surface.
pub(crate) const FAIR_EDGE_RATIO: Parameter = Parameter {
    default: DefaultValue::Value("1"),
    sentence: "Length of the new edges relative to the edges round the region, or to the mean edge of the mesh.",
    ..EDGE_RATIO
};

/// `isomend fair`.
pub const FAIR: Table = Table {
    command: "fair",
    own: &[
        STRENGTH,
        TIME,
        Parameter {
            details: "`auto` is an eighth of the length of features that disappear, at least a third of the mean edge, and more on large \
                      models.",
            ..VOXEL
        },
        FAIR_EDGE_RATIO,
        KEEP_VERTICES,
    ],
    solve: None,
    former: &[],
};

/// Distance up to which boundary vertices are merged.
pub(crate) const WELD: Parameter = Parameter {
    name: "weld",
    field: "weld",
    kind: Kind::Number(NumberBounds::POSITIVE, "LENGTH"),
    unit: MESH_UNIT,
    sentence: "Merge boundary vertices that are no farther apart than this, in the mesh's units. Vertices at exactly the same position \
               are always merged; by default also vertices of edges that coincide within the precision of the coordinates.",
    ..Parameter::PLAIN
};

/// Holes that are closed by nearly flat caps.
pub(crate) const FLAT: Parameter = Parameter {
    name: "flat",
    field: "flat",
    kind: Kind::Holes(false),
    sentence: "Numbers of holes to close by nearly flat caps instead of continuing the surface: necks, bases, mouths of \
               vessels.",
    details: "A cap is the surface of least area that its rim bounds. Its vertices are as dense as those round the hole.",
    ..Parameter::PLAIN
};

/// Relative area below which components are removed.
pub(crate) const DEBRIS: Parameter = Parameter {
    name: "debris",
    field: "debris",
    kind: Kind::Number(NumberBounds::PART, "PART"),
    default: DefaultValue::Words("all components stay"),
    sentence: "Remove components whose area is below this fraction, from 0 to 1, of the area of the largest one.",
    ..Parameter::PLAIN
};

/// Components that are removed.
const DROP: Parameter = Parameter {
    name: "drop",
    field: "drop",
    kind: Kind::Holes(false),
    sentence: "Numbers of components to remove, as `isomend inspect -v` and the page count them.",
    ..Parameter::PLAIN
};

/// Thickness of the walls that `close_borders` makes.
pub(crate) const WALL: Parameter = Parameter {
    name: "wall",
    field: "wall",
    kind: Kind::Number(NumberBounds::POSITIVE, "LENGTH"),
    unit: MESH_UNIT,
    default: DefaultValue::Words("the mean edge of the component"),
    sentence: "Thickness of the walls that `close_borders` makes of open sheets that no flat cap closes, in the mesh's units.",
    details: "Walls are thinner where they would intersect other faces; the report gives their thickness.",
    ..Parameter::PLAIN
};

/// Thickness below which a wall is a defect.
pub(crate) const MIN_WALL: Parameter = Parameter {
    name: "min_wall",
    field: "min_wall",
    kind: Kind::Number(NumberBounds::POSITIVE, "LENGTH"),
    unit: MESH_UNIT,
    sentence: "Report walls thinner than this as a defect, in the mesh's units.",
    details: "A wall is a part of the surface whose other side is parallel to it within 15 degrees, so sharp edges do not count.",
    ..Parameter::PLAIN
};

/// `isomend repair`.
pub const REPAIR: Table = Table {
    command: "repair",
    own: &[
        WELD,
        DROP,
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
            sentence: "Remove components that lie wholly inside another one; cavities stay.",
            ..Parameter::PLAIN
        },
        Parameter {
            name: "solid",
            field: "solid",
            sentence: "Make double-skinned bodies solid: remove inner skins that pinholes join to the outer one, and close the pinholes.",
            ..Parameter::PLAIN
        },
        Parameter {
            name: "skip",
            field: "skip",
            kind: Kind::Words(
                &[
                    Choice {
                        name: "duplicates",
                        sentence: "Coinciding vertices, and degenerate and duplicate faces stay; cracks are not closed.",
                    },
                    Choice {
                        name: "orientation",
                        sentence: "All faces keep their orientation.",
                    },
                    Choice {
                        name: "non-manifold",
                        sentence: "Non-manifold edges, which have more than two faces, stay, and non-manifold vertices, where surfaces meet in a \
                               point only.",
                    },
                    Choice {
                        name: "intersections",
                        sentence: "Self-intersections stay.",
                    },
                    Choice {
                        name: "holes",
                        sentence: "The holes of the mesh stay open; holes that the repair makes are filled.",
                    },
                ],
                "STEP",
            ),
            default: DefaultValue::Words("no step"),
            sentence: "Steps of the repair to leave out: duplicates, orientation, non-manifold, intersections, holes.",
            details: "Without duplicates, coinciding vertices, degenerate and duplicate faces stay, and cracks; without orientation, \
                      faces stay as they are oriented; without non-manifold, non-manifold edges and vertices stay; without \
                      intersections, self-intersections stay; without holes, only holes that the repair makes are filled.",
            ..Parameter::PLAIN
        },
        Parameter {
            name: "drop_unused",
            field: "drop_unused",
            sentence: "Drop vertices that no face of the input uses.",
            ..Parameter::PLAIN
        },
        Parameter {
            name: "close_borders",
            field: "borders",
            sentence: "Also close the outer borders of open sheets, which otherwise stay open.",
            ..Parameter::PLAIN
        },
        WALL,
        Parameter {
            default: DefaultValue::Words(
                "half a mean edge for walls that the repair makes; other walls are only reported",
            ),
            ..MIN_WALL
        },
        Parameter {
            field: "fill.holes",
            details: "`isomend inspect` lists the numbers; holes that the repair makes are always filled. An outer border is filled only if it \
                      is named here.",
            ..HOLES
        },
        Parameter {
            field: "fill.max_diameter",
            ..MAX_DIAMETER
        },
        Parameter {
            field: "fill.keep_open",
            ..KEEP_OPEN
        },
        Parameter {
            field: "fill.bridge",
            ..BRIDGE
        },
        Parameter {
            field: "fill.flat",
            ..FLAT
        },
        Parameter {
            field: "fill.crease",
            ..CREASE
        },
    ],
    solve: Some("fill"),
    former: &[
        ("keep_duplicates", "--skip duplicates"),
        ("keep_orientation", "--skip orientation"),
        ("keep_non_manifold", "--skip non-manifold"),
        ("keep_crossings", "--skip intersections"),
        ("keep_holes", "--skip holes"),
        LIKE_SCALE,
    ],
};

/// Thickness below which parts are reported.
pub(crate) const THIN: Parameter = Parameter {
    name: "thin",
    field: "thin",
    kind: Kind::Number(NumberBounds::POSITIVE, "LENGTH"),
    unit: MESH_UNIT,
    sentence: "Also report parts thinner than this, in the mesh's units.",
    details: "The thickness at a face is the length of the ray from its centre inward to the next face of the opposite direction, \
              within 60 degrees; faces that share a vertex with it do not count.",
    ..Parameter::PLAIN
};

/// `isomend check`.
pub const CHECK: Table = Table {
    command: "check",
    own: &[
        THIN,
        Parameter {
            default: DefaultValue::Words("the thinnest and the mean wall are only reported"),
            ..MIN_WALL
        },
        Parameter {
            default: DefaultValue::Value("0.01"),
            sentence: "Report components as debris if their area is below this fraction, from 0 to 1, of the area of the largest one.",
            ..DEBRIS
        },
    ],
    solve: None,
    former: &[],
};

/// Length beyond which distances are cut off.
pub(crate) const BAND: Parameter = Parameter {
    name: "band",
    field: "band",
    kind: Kind::Band,
    unit: MESH_UNIT,
    default: DefaultValue::Value("full"),
    sentence: "Cut distances off at this length, which is faster; `full` computes all distances.",
    ..Parameter::PLAIN
};

/// `isomend sdf`.
pub const SDF: Table = Table {
    command: "sdf",
    own: &[
        Parameter {
            sentence: "Distance of neighbouring nodes, in the mesh's units; `auto` takes 1/128 of the longest side.",
            details: "",
            ..VOXEL
        },
        BAND,
    ],
    solve: None,
    former: &[],
};

/// `isomend compare`.
pub const COMPARE: Table = Table {
    command: "compare",
    own: &[Parameter {
        name: "samples",
        field: "samples",
        kind: Kind::Whole(MOST_SAMPLES),
        default: DefaultValue::Value("100000"),
        sentence: "Number of samples on each mesh, at most 100 million.",
        ..Parameter::PLAIN
    }],
    solve: None,
    former: &[],
};

/// `isomend study`; its other options belong to the command line only.
pub const STUDY: Table = Table {
    command: "study",
    own: &[ENERGY],
    solve: None,
    former: &[],
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
    /// The tables of the commands that work on meshes.
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
