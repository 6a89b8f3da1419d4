//! Mesh check: lists all defects of a mesh and decides whether it is watertight and printable.
//!
//! [`judge`] takes a mesh with known connectivity and lists every kind of defect with its count, its faces and its places. It
//! changes nothing. Vertices at exactly the same position count as one throughout.
//!
//! The terms follow other programs: watertight and consistently oriented as in trimesh (every edge has exactly two faces, which
//! run through it in opposite directions), intersecting faces as in MeshLab (faces with a common point other than a shared vertex
//! or edge). Intersections are decided exactly here, so faces that merely touch, and neighbours that are folded onto each other,
//! count too.

mod bodies;
mod boundary;
mod components;
mod defects;
mod doubt;
mod edge_tree;
mod resolution;
mod thin;
mod walls;

use std::collections::BTreeMap;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::mesh::{Hole, Mesh, OpenChain, Topology};
use crate::parameters::{OutOfBounds, tables};

pub(crate) use boundary::{Boundary, CRACK, JUNCTION_MOST};
pub use components::Component;
pub(crate) use components::components;
pub use defects::{duplicates, is_flat, self_intersections, self_intersections_among};
pub use doubt::ShapeDoubt;
pub(crate) use resolution::{WELD_UNITS, weld_length};
pub use walls::{WallMap, Walls};

/// Options of a check: what to look for beyond the defects that are always listed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct CheckParams {
    /// Reports parts thinner than this, in mesh units.
    ///
    /// The thickness at a face is the length of the ray from its centre inward, against its normal, to the next face whose normal
    /// is within 60 degrees of the ray. Faces that share a vertex with it do not count.
    pub thin: Option<f64>,
    /// Components with less than this fraction of the largest component's area are listed as debris.
    pub debris: f64,
    /// Walls of closed components that are thinner than this, in mesh units, are defects.
    ///
    /// Thickness is measured as for [`Self::thin`], at all faces. A wall is a patch of the surface whose opposite side is
    /// parallel to it within 15 degrees; the surface near a sharp edge is not a wall.
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
    /// Checks that the values are within their bounds.
    ///
    /// # Errors
    /// The parameter that is out of bounds.
    pub fn check(&self) -> Result<(), OutOfBounds> {
        tables::THIN.check(self.thin)?;
        tables::MIN_WALL.check(self.min_wall)?;
        tables::DEBRIS.check(self.debris)
    }
}

/// A kind of defect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DefectKind {
    /// Boundary edges: edges with only one face.
    BoundaryEdge,
    /// Edges with more than two faces.
    NonManifoldEdge,
    /// Vertices where surfaces meet in a single point; vertices of edges with more than two faces are not counted.
    NonManifoldVertex,
    /// Edges whose two faces run through them in the same direction.
    Misoriented,
    /// Closed components that are inside out.
    InsideOut,
    /// Faces that use a vertex twice, or whose vertices lie on one line.
    Degenerate,
    /// Faces with the same vertices as an earlier face.
    Duplicate,
    /// Faces that intersect or touch another face outside shared vertices and edges.
    SelfIntersection,
    /// Faces where the body is thinner than [`CheckParams::thin`].
    Thin,
    /// Faces of walls that are thinner than [`CheckParams::min_wall`].
    ThinWall,
}

impl DefectKind {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::BoundaryEdge,
        Self::NonManifoldEdge,
        Self::NonManifoldVertex,
        Self::Misoriented,
        Self::InsideOut,
        Self::Degenerate,
        Self::Duplicate,
        Self::SelfIntersection,
        Self::Thin,
        Self::ThinWall,
    ];

    /// The defect in words, with its count.
    pub fn text(self, count: usize) -> String {
        let (one, many) = match self {
            Self::BoundaryEdge => ("edge has only one face", "edges have only one face"),
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
            Self::Duplicate => ("face duplicates another", "faces duplicate others"),
            Self::SelfIntersection => ("face intersects another", "faces intersect others"),
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
    /// Number of edges, vertices, faces or components with the defect, depending on the kind.
    pub count: usize,
    /// The affected faces, ascending.
    pub faces: Vec<u32>,
    /// A place of each connected group of these faces, in the order of their first faces: the mean of its edges or vertices, or the face
    /// centre that is nearest to the mean.
    pub places: Vec<DVec3>,
}

/// The result of a check: counts, components and defects of a mesh.
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
    /// Holes: closed loops of boundary edges.
    pub holes: usize,
    /// Chains of boundary edges that do not close.
    pub open_chains: usize,
    /// T-junctions: boundary vertices that lie on a boundary edge. A repair splits these edges.
    #[serde(default)]
    pub t_junctions: usize,
    /// Holes that are closed by splitting the edges at T-junctions.
    #[serde(default)]
    pub t_junction_holes: usize,
    /// The recommended welding distance (mesh units) and the number of boundary edges that it closes; none if it would close too
    /// few.
    #[serde(default)]
    pub weld: Option<(f64, usize)>,
    /// Whether a repair welds within that distance by default.
    #[serde(default)]
    pub weld_by_default: bool,
    /// The components, in the order of their first faces.
    pub components: Vec<Component>,
    /// The defects that were found, one entry for each kind.
    pub defects: Vec<Defect>,
    /// After a repair without a `min_wall`: the numbers, from 1, of components whose walls were made by the repair and are
    /// thinner than half a mean edge.
    #[serde(default)]
    pub foils: Vec<usize>,
    /// After a repair: why the shape is doubtful, if it is.
    #[serde(default)]
    pub doubt: Option<ShapeDoubt>,
    /// The options of the check.
    pub params: CheckParams,
    /// The verdict on each object of a 3MF file, with its name, if the file has several: each is checked by itself, and the other
    /// fields are sums. Else empty.
    #[serde(default)]
    pub objects: Vec<(String, Verdict)>,
}

/// A mesh with its connectivity, the subject of a check.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// The mesh as given by the caller.
    pub input: &'a Mesh,
    /// The mesh on welded vertices, its faces reoriented to agree.
    pub mesh: &'a Mesh,
    /// Its connectivity.
    pub topology: &'a Topology,
    /// Its holes.
    pub holes: &'a [Hole],
    /// Boundary chains that do not close.
    pub open_chains: &'a [OpenChain],
}

/// Lists all defects of a mesh.
///
/// # Panics
/// If a face uses a vertex that does not exist, or the connectivity belongs to another mesh.
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
    let closing = Boundary::new(subject.mesh, subject.topology).closing(subject.holes);
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
        doubt: None,
        params: params.clone(),
        objects: Vec::new(),
    }
}

impl Verdict {
    /// The number of edges, vertices, faces or components with a kind of defect.
    pub fn count(&self, kind: DefectKind) -> usize {
        let found = self.defects.iter().find(|d| d.kind == kind);
        found.map_or(0, |d| d.count)
    }

    /// Whether every edge has exactly two faces.
    pub fn is_watertight(&self) -> bool {
        self.is_closed() && self.count(DefectKind::NonManifoldEdge) == 0
    }

    /// Whether no edge has only one face.
    pub fn is_closed(&self) -> bool {
        self.count(DefectKind::BoundaryEdge) == 0
    }

    /// Whether there are no non-manifold edges or vertices.
    pub fn is_manifold(&self) -> bool {
        self.count(DefectKind::NonManifoldEdge) + self.count(DefectKind::NonManifoldVertex) == 0
    }

    /// Whether all edges of two faces run through them in opposite directions.
    pub fn is_oriented(&self) -> bool {
        self.count(DefectKind::Misoriented) == 0
    }

    /// Whether the mesh has no defects and its shape is not doubtful: it is watertight and can be printed.
    pub fn is_sound(&self) -> bool {
        self.defects.is_empty() && self.doubt.is_none()
    }

    /// Whether only what the repair itself did is doubtful, which a check of the written file cannot know: that it changed the shape, or
    /// made thin walls.
    #[doc(hidden)]
    pub fn is_doubtful(&self) -> bool {
        if !self.objects.is_empty() {
            let mut own = self.objects.iter().map(|(_, own)| own);
            return !self.is_sound() && own.all(|own| own.is_sound() || own.is_doubtful());
        }
        let is_made = |d: &Defect| d.kind == DefectKind::ThinWall && !self.foils.is_empty();
        !self.is_sound() && self.defects.iter().all(is_made)
    }

    /// The defects in words; empty for a sound mesh.
    pub fn reasons(&self) -> Vec<String> {
        if !self.objects.is_empty() {
            let named = |(name, own): &(String, Self)| -> Vec<String> {
                let reasons = own.reasons().into_iter();
                reasons.map(|reason| format!("{name}: {reason}")).collect()
            };
            return self.objects.iter().flat_map(named).collect();
        }
        let mut reasons = Vec::new();
        for defect in &self.defects {
            match defect.kind {
                DefectKind::BoundaryEdge => self.open_reasons(defect.count, &mut reasons),
                DefectKind::ThinWall => reasons.push(self.thin_reason()),
                kind => reasons.push(kind.text(defect.count)),
            }
        }
        reasons.extend(self.doubt.iter().map(ShapeDoubt::text));
        reasons
    }

    /// Adds the reasons for open edges: T-junctions first, then the holes that are not caused by T-junctions.
    fn open_reasons(&self, edges: usize, reasons: &mut Vec<String>) {
        let holes = self.holes - self.t_junction_holes.min(self.holes);
        match self.t_junctions {
            0 => {}
            1 => reasons.push("1 vertex lies on an edge (T-junction)".to_owned()),
            n => reasons.push(format!("{n} vertices lie on edges (T-junctions)")),
        }
        match holes {
            0 if self.holes > 0 => {}
            0 => reasons.push(DefectKind::BoundaryEdge.text(edges)),
            1 => reasons.push("1 hole is open".to_owned()),
            n => reasons.push(format!("{n} holes are open")),
        }
    }

    /// The verdict in one line.
    pub fn line(&self) -> String {
        let reasons = self.reasons();
        if self.is_doubtful() {
            let doubt = reasons.join(", ");
            return format!("watertight, but the shape is doubtful: {doubt}");
        }
        match &reasons[..] {
            [] => "watertight and printable: yes".to_owned(),
            [reason] => format!("watertight and printable: no, because {reason}"),
            [first @ .., last] => format!(
                "watertight and printable: no, because {} and {last}",
                first.join(", ")
            ),
        }
    }

    /// For each defective face one kind of defect, for display: the rarest kind, with the fewest faces, takes precedence.
    pub fn marks(&self) -> BTreeMap<u32, DefectKind> {
        let mut order: Vec<&Defect> = self.defects.iter().collect();
        order.sort_by_key(|d| std::cmp::Reverse(d.faces.len()));
        let all = order
            .iter()
            .flat_map(|d| d.faces.iter().map(|f| (*f, d.kind)));
        all.collect()
    }

    /// Number of components listed as debris.
    pub fn debris(&self) -> usize {
        self.components.iter().filter(|c| c.debris).count()
    }

    /// Number of components that lie inside another.
    pub fn inside(&self) -> usize {
        let inside = |c: &&Component| c.inside.is_some();
        self.components.iter().filter(inside).count()
    }
}
