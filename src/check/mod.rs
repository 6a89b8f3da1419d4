//! What is wrong with a mesh, and one verdict on it: is it watertight, and can it be printed?
//!
//! [`judge`] looks at a mesh whose connectivity is known and lists every kind of defect with its number, its faces and where it is.
//! Nothing is changed. Vertices at exactly the same position count as one throughout.
//!
//! The terms are those of other programs: watertight and consistently oriented as trimesh has them (every edge in exactly two
//! faces, which run through it in opposite directions), crossing faces as MeshLab selects them (faces that have a point in common
//! other than a shared vertex or edge); but the latter is decided exactly here, so that faces that merely touch, and neighbours that are folded
//! onto each other, count too.

mod border;
mod components;
mod defects;
mod edge_tree;
mod resolution;
mod thin;
mod walls;

use std::collections::BTreeMap;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::mesh::{Hole, Mesh, OpenChain, Topology};
use crate::parameters::{OutOfBounds, tables};

pub(crate) use border::{Border, Match};
pub use components::Component;
pub(crate) use components::components;
pub(crate) use defects::{crossing, crossing_among, duplicates, is_flat};
pub(crate) use resolution::weld_length;
pub(crate) use walls::Walls;

/// What is looked for, beyond what always is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct CheckParams {
    /// Parts thinner than this are looked for, in the mesh's units.
    ///
    /// The thickness at a face is the length of the ray from its centre inward, against its normal, to the next face that faces the
    /// other way, within 60 degrees; faces that share a vertex with it do not count.
    pub thin: Option<f64>,
    /// Components with less than this part of the area of the largest one are told as debris.
    pub debris: f64,
    /// Walls of closed components that are thinner than this, in the mesh's units, are defects.
    ///
    /// Thickness is measured as for [`Self::thin`], at all faces. A wall is a patch of the surface whose other side is parallel to it
    /// within 15 degrees, so that sharp edges are none.
    pub min_wall: Option<f64>,
}

impl Default for CheckParams {
    fn default() -> Self {
        Self {
            thin: None,
            debris: 0.01,
            min_wall: None,
        }
    }
}

impl CheckParams {
    /// Whether they make sense by themselves.
    ///
    /// # Errors
    /// With the parameter that does not.
    pub fn check(&self) -> Result<(), OutOfBounds> {
        tables::THIN.check(self.thin)?;
        tables::MIN_WALL.check(self.min_wall)?;
        tables::DEBRIS.check(self.debris)
    }
}

/// A kind of defect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum DefectKind {
    /// Edges in one face only.
    Border,
    /// Edges in more than two faces.
    NonManifoldEdge,
    /// Vertices where surfaces meet in nothing but a point; without those of edges in more than two faces.
    NonManifoldVertex,
    /// Edges whose two faces run through them in the same direction.
    Misoriented,
    /// Closed components that are inside out.
    InsideOut,
    /// Faces that use a vertex twice, or whose vertices lie on one line.
    Degenerate,
    /// Faces on the vertices of an earlier one.
    Duplicate,
    /// Faces that cross or touch another one where they share no vertex or edge.
    Crossing,
    /// Faces where the body is thinner than asked for.
    Thin,
    /// Faces at walls that are thinner than allowed.
    ThinWall,
}

impl DefectKind {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Border,
        Self::NonManifoldEdge,
        Self::NonManifoldVertex,
        Self::Misoriented,
        Self::InsideOut,
        Self::Degenerate,
        Self::Duplicate,
        Self::Crossing,
        Self::Thin,
        Self::ThinWall,
    ];

    /// That there are so many of it, in words.
    pub fn text(self, count: usize) -> String {
        let (one, many) = match self {
            Self::Border => ("edge is on a border", "edges are on borders"),
            Self::NonManifoldEdge => (
                "edge has more than two faces",
                "edges have more than two faces",
            ),
            Self::NonManifoldVertex => (
                "vertex joins surfaces that meet in a point only",
                "vertices join surfaces that meet in a point only",
            ),
            Self::Misoriented => (
                "edge has faces oriented against each other",
                "edges have faces oriented against each other",
            ),
            Self::InsideOut => (
                "closed component is inside out",
                "closed components are inside out",
            ),
            Self::Degenerate => ("face is degenerate", "faces are degenerate"),
            Self::Duplicate => ("face is there twice", "faces are there twice"),
            Self::Crossing => ("face crosses another", "faces cross others"),
            Self::Thin => ("face is at a thin part", "faces are at thin parts"),
            Self::ThinWall => ("face is at a thin wall", "faces are at thin walls"),
        };
        format!("{count} {}", if count == 1 { one } else { many })
    }
}

/// All defects of a kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Defect {
    /// The kind.
    pub kind: DefectKind,
    /// How many edges, vertices, faces or components have it, by the kind.
    pub count: usize,
    /// The faces at them, in rising order.
    pub faces: Vec<u32>,
    /// Where they are: the middle of each connected group of these faces, in the order of their first faces.
    pub places: Vec<DVec3>,
}

/// What a mesh is, and what is wrong with it.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Verdict {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
    /// Vertices that no face uses.
    pub unused_vertices: usize,
    /// Vertices at the position of an earlier one.
    pub duplicate_vertices: usize,
    /// Holes: closed loops of border edges.
    pub holes: usize,
    /// Chains of border edges that do not close.
    pub open_chains: usize,
    /// T-junctions: border vertices that lie on a border edge. A repair splits these edges.
    #[serde(default)]
    pub t_junctions: usize,
    /// Holes that are closed once the edges at T-junctions are split.
    #[serde(default)]
    pub t_junction_holes: usize,
    /// The length, in the mesh's units, within which vertices of the border are to be merged so that most of its edges close which
    /// nearly coincide, and how many of its edges close so; none where few do.
    #[serde(default)]
    pub weld: Option<(f64, usize)>,
    /// Whether a repair merges within that length by itself.
    #[serde(default)]
    pub weld_by_default: bool,
    /// The components, in the order of their first faces.
    pub components: Vec<Component>,
    /// The kinds of defects that there are.
    pub defects: Vec<Defect>,
    /// After a repair the numbers, from 1, of components whose walls it made and which are thinner than half a mean edge, where nothing else
    /// was asked for.
    #[serde(default)]
    pub foils: Vec<usize>,
    /// What was looked for.
    pub params: CheckParams,
}

/// A mesh whose connectivity is known.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// The mesh as given.
    pub input: &'a Mesh,
    /// The mesh on welded vertices, its faces turned to agree.
    pub mesh: &'a Mesh,
    /// Its connectivity.
    pub topology: &'a Topology,
    /// Its holes.
    pub holes: &'a [Hole],
    /// Chains of its border that do not close.
    pub open_chains: &'a [OpenChain],
}

/// Looks for everything that may be wrong with a mesh.
///
/// # Panics
/// When faces use vertices that there are not, or the connectivity is that of another mesh.
pub fn judge(subject: &Subject, params: &CheckParams) -> Verdict {
    let mut components = components(subject.mesh, subject.topology, params.debris);
    let thin_walls = walls::measure(subject, &mut components, params.min_wall);
    let mut defects = defects::of_topology(subject);
    defects.push(defects::inside_out(subject, &components));
    defects.extend(defects::of_faces(subject));
    if let Some(length) = params.thin {
        defects.push(thin::thin(subject, length));
    }
    defects.extend(thin_walls);
    defects.retain(|d| d.count > 0);
    let closing = Border::new(subject.mesh, subject.topology).closing(subject.holes);
    let mut used = vec![false; subject.input.positions.len()];
    let corners = subject.input.faces.iter().flatten();
    corners.for_each(|&v| used[v as usize] = true);
    Verdict {
        vertices: used.len(),
        faces: subject.input.faces.len(),
        unused_vertices: used.iter().filter(|used| !**used).count(),
        duplicate_vertices: subject.topology.defects.duplicate_vertices,
        holes: subject.holes.len(),
        open_chains: subject.open_chains.len(),
        t_junctions: closing.junctions,
        t_junction_holes: closing.junction_holes,
        weld: closing.weld,
        weld_by_default: closing.by_default,
        components,
        defects,
        foils: Vec::new(),
        params: params.clone(),
    }
}

impl Verdict {
    /// How many edges, vertices, faces or components have a kind of defect.
    pub fn count(&self, kind: DefectKind) -> usize {
        let found = self.defects.iter().find(|d| d.kind == kind);
        found.map_or(0, |d| d.count)
    }

    /// Whether every edge is in exactly two faces.
    pub fn is_watertight(&self) -> bool {
        self.is_closed() && self.count(DefectKind::NonManifoldEdge) == 0
    }

    /// Whether no edge is in one face only.
    pub fn is_closed(&self) -> bool {
        self.count(DefectKind::Border) == 0
    }

    /// Whether no edge has more than two faces, and surfaces meet nowhere in a point only.
    pub fn is_manifold(&self) -> bool {
        self.count(DefectKind::NonManifoldEdge) + self.count(DefectKind::NonManifoldVertex) == 0
    }

    /// Whether all edges of two faces run through them in opposite directions.
    pub fn is_oriented(&self) -> bool {
        self.count(DefectKind::Misoriented) == 0
    }

    /// Whether nothing is wrong with it: it is watertight and can be printed.
    pub fn is_sound(&self) -> bool {
        self.defects.is_empty()
    }

    /// What is wrong with it, in words; nothing where it is sound.
    pub fn reasons(&self) -> Vec<String> {
        let mut reasons = Vec::new();
        for defect in &self.defects {
            match defect.kind {
                DefectKind::Border => self.open_reasons(defect.count, &mut reasons),
                DefectKind::ThinWall => reasons.push(self.thin_reason()),
                kind => reasons.push(kind.text(defect.count)),
            }
        }
        reasons
    }

    /// Why edges of the border are open: those of holes, and those that T-junctions leave.
    fn open_reasons(&self, edges: usize, reasons: &mut Vec<String>) {
        let holes = self.holes - self.t_junction_holes.min(self.holes);
        match self.t_junctions {
            0 => {}
            1 => reasons.push("1 vertex lies on an edge (T-junction)".to_owned()),
            n => reasons.push(format!("{n} vertices lie on edges (T-junctions)")),
        }
        match holes {
            0 if self.holes > 0 => {}
            0 => reasons.push(DefectKind::Border.text(edges)),
            1 => reasons.push("1 hole is open".to_owned()),
            n => reasons.push(format!("{n} holes are open")),
        }
    }

    /// The verdict in a line.
    pub fn line(&self) -> String {
        let reasons = self.reasons();
        match &reasons[..] {
            [] => "watertight and printable: yes".to_owned(),
            [reason] => format!("watertight and printable: no, because {reason}"),
            [first @ .., last] => format!(
                "watertight and printable: no, because {} and {last}",
                first.join(", ")
            ),
        }
    }

    /// For each face the most telling kind of defect that it has: that of the fewest faces.
    pub fn marks(&self) -> BTreeMap<u32, DefectKind> {
        let mut order: Vec<&Defect> = self.defects.iter().collect();
        order.sort_by_key(|d| std::cmp::Reverse(d.faces.len()));
        let all = order
            .iter()
            .flat_map(|d| d.faces.iter().map(|f| (*f, d.kind)));
        all.collect()
    }

    /// Components that are told as debris.
    pub fn debris(&self) -> usize {
        self.components.iter().filter(|c| c.debris).count()
    }

    /// Components that lie inside another.
    pub fn inside(&self) -> usize {
        let inside = |c: &&Component| c.inside.is_some();
        self.components.iter().filter(inside).count()
    }
}
