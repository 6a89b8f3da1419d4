//! The rows of a verdict.

use glam::DVec3;
use serde::Serialize;

use crate::check::{Component, Defect, DefectKind, Verdict};

/// Most faces, places and components that are listed.
const MOST_LISTED: usize = 1000;

/// A verdict on a mesh.
#[derive(Serialize)]
pub(in crate::job) struct VerdictRow<'a> {
    /// Whether it is watertight and can be printed.
    sound: bool,
    /// Why it is not, in words for people.
    reasons: Vec<String>,
    watertight: bool,
    closed: bool,
    manifold: bool,
    oriented: bool,
    holes: usize,
    open_chains: usize,
    /// Border vertices on border edges, and the holes that splitting these edges closes.
    t_junctions: usize,
    t_junction_holes: usize,
    weld: Option<WeldRow>,
    unused_vertices: usize,
    duplicate_vertices: usize,
    defects: Vec<DefectRow<'a>>,
    components: usize,
    debris: usize,
    inside: usize,
    largest_components: Vec<&'a Component>,
    thin: Option<f64>,
    /// The limit of wall thickness, and the least and the mean thickness of the walls of closed components.
    min_wall: Option<f64>,
    walls: Option<WallRow>,
}

/// The walls of closed components.
#[derive(Serialize)]
struct WallRow {
    least: Option<f64>,
    mean: f64,
    /// The number of the component with the thinnest one, from 1 in the order of their first faces, and where that is.
    component: usize,
    at: Option<DVec3>,
}

/// The length within which border vertices are to be merged, and how many border edges close so.
#[derive(Serialize)]
struct WeldRow {
    length: f64,
    edges: usize,
    /// Whether a repair does so by itself.
    by_default: bool,
}

#[derive(Serialize)]
struct DefectRow<'a> {
    kind: DefectKind,
    count: usize,
    /// The numbers of its first faces.
    faces: &'a [u32],
    /// The first places where it is.
    places: &'a [DVec3],
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
            walls: verdict.walls().map(|(component, thinnest, mean)| WallRow {
                least: thinnest.least_wall,
                mean,
                component,
                at: thinnest.thinnest_at,
            }),
        }
    }
}
