//! JSON rows for the verdict of a mesh check.

use glam::DVec3;
use serde::Serialize;

use isomend_core::check::{Component, Defect, DefectKind, ShapeDoubt, Verdict};

/// Most faces and places per defect, and most components, in a document.
const MOST_LISTED: usize = 1000;

/// The verdict of a mesh check.
#[derive(Serialize)]
pub(in crate::job) struct VerdictRow<'a> {
    /// Whether there are no defects and no doubt. It is watertight and can be printed.
    sound: bool,
    /// Why not, in words.
    reasons: Vec<String>,
    /// Whether each edge has two faces.
    watertight: bool,
    /// Whether no edge has only one face.
    closed: bool,
    /// Whether no edge or vertex is non-manifold.
    manifold: bool,
    /// Whether neighbouring faces have the same orientation.
    oriented: bool,
    /// Number of holes.
    holes: usize,
    /// Number of boundary chains that do not close.
    open_chains: usize,
    /// Boundary vertices on other boundary edges.
    t_junctions: usize,
    /// Holes that splitting these closes.
    t_junction_holes: usize,
    /// Merging vertices that closes boundary edges. Null if none is recommended.
    weld: Option<WeldRow>,
    /// Vertices without faces.
    unused_vertices: usize,
    /// Vertices at an earlier one.
    duplicate_vertices: usize,
    /// Defects by kind.
    defects: Vec<DefectRow<'a>>,
    /// Number of components.
    components: usize,
    /// Number of small components.
    debris: usize,
    /// Number of components inside others.
    inside: usize,
    /// The largest components. At most a thousand, by falling area.
    largest_components: Vec<&'a Component>,
    /// Thickness that was asked for.
    thin: Option<f64>,
    /// Wall thickness that was asked for.
    min_wall: Option<f64>,
    /// Measured wall thickness. Null if it was not measured.
    walls: Option<WallRow>,
    /// Why a repaired shape is doubtful.
    doubt: Option<ShapeDoubt>,
    /// Objects of a 3MF file.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    objects: Vec<ObjectRow<'a>>,
}

/// The verdict on an object.
#[derive(Serialize)]
struct ObjectRow<'a> {
    /// Name of the object.
    name: &'a str,
    /// Whether it is sound.
    sound: bool,
    /// Why it is not, as sentences.
    reasons: Vec<String>,
    /// Number of faces.
    faces: usize,
    /// Number of connected components.
    components: usize,
}

/// Wall thickness of the closed components.
#[derive(Serialize)]
struct WallRow {
    /// The least thickness.
    least: Option<f64>,
    /// The mean thickness.
    mean: f64,
    /// The component with the thinnest wall, from 1 in the order of first faces.
    component: usize,
    /// Where the thinnest wall is.
    at: Option<DVec3>,
    /// Whether the walls were measured at a part of the faces only: a thinner place may have been missed.
    sampled: bool,
}

/// A weld that closes boundary edges.
#[derive(Serialize)]
struct WeldRow {
    /// Boundary vertices within this distance are merged.
    length: f64,
    /// Boundary edges that the weld closes.
    edges: usize,
    /// Whether a repair welds them by default.
    by_default: bool,
}

/// The defects of a kind.
#[derive(Serialize)]
struct DefectRow<'a> {
    /// Kind.
    kind: DefectKind,
    /// Number of defects.
    count: usize,
    /// The first thousand faces.
    faces: &'a [u32],
    /// The first thousand positions.
    places: &'a [DVec3],
}

impl<'a> ObjectRow<'a> {
    fn new((name, verdict): &'a (String, Verdict)) -> Self {
        Self {
            name,
            sound: verdict.is_sound(),
            reasons: verdict.reasons(),
            faces: verdict.faces,
            components: verdict.components.len(),
        }
    }
}

impl<'a> VerdictRow<'a> {
    pub(in crate::job) fn new(verdict: &'a Verdict) -> Self {
        let row = |d: &'a Defect| DefectRow {
            kind: d.kind,
            count: d.count,
            faces: &d.faces[..d.faces.len().min(MOST_LISTED)],
            places: &d.places[..d.places.len().min(MOST_LISTED)],
        };
        let mut components: Vec<&Component> = verdict.components.iter().collect();
        components.sort_by(|a, b| b.area.total_cmp(&a.area));
        components.truncate(MOST_LISTED);
        Self {
            sound: verdict.is_sound(),
            reasons: verdict.reasons(),
            watertight: verdict.is_watertight(),
            closed: verdict.is_closed(),
            manifold: verdict.is_manifold(),
            oriented: verdict.is_oriented(),
            holes: verdict.holes,
            open_chains: verdict.open_chains,
            t_junctions: verdict.t_junctions,
            t_junction_holes: verdict.t_junction_holes,
            weld: verdict.weld.map(|(length, edges)| WeldRow {
                length,
                edges,
                by_default: verdict.weld_by_default,
            }),
            unused_vertices: verdict.unused_vertices,
            duplicate_vertices: verdict.duplicate_vertices,
            defects: verdict.defects.iter().map(row).collect(),
            components: verdict.components.len(),
            debris: verdict.debris(),
            inside: verdict.inside(),
            largest_components: components,
            thin: verdict.params.thin,
            min_wall: verdict.params.min_wall,
            doubt: verdict.doubt,
            objects: verdict.objects.iter().map(ObjectRow::new).collect(),
            walls: verdict.walls().map(|(component, thinnest, mean)| WallRow {
                least: thinnest.least_wall,
                mean,
                component,
                at: thinnest.thinnest_at,
                sampled: verdict.samples_walls(),
            }),
        }
    }
}
