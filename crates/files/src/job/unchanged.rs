//! The HTML page and the picture of a mesh that was not changed, with its holes or with its defects marked.

use glam::DVec3;

use super::{JobError, Place};
use crate::io::Loaded;
use crate::report::html::{Badge, HtmlPage, MarkedDefect, page};
use crate::report::picture::{PictureError, picture_of_marked, picture_of_one};
use crate::report::scene::{LegendColour, Scene, SceneChange};
use crate::report::{Standing, crease_end_line, defect_lines, verdict_rows};
use isomend_core::check::{DefectKind, Verdict};
use isomend_core::mend::{CreaseEnd, HoleReport, Inspection};
use isomend_core::mesh::{Hole, Mesh, Unit, point};

/// Most faces of a drawing; larger meshes are simplified for it.
pub(super) const FACES: usize = 300_000;

/// A drawing of a mesh that was not changed: with its holes, or, if there is a verdict, with the faces that have defects.
#[derive(Clone, Copy)]
pub struct Unchanged<'a> {
    /// The place of the mesh.
    pub place: &'a Place,
    /// The mesh.
    pub loaded: &'a Loaded,
    /// Its topology, holes and defects.
    pub found: &'a Inspection<'a>,
    /// Rim vertices at which sharp edges end; they are marked.
    pub crease_ends: &'a [CreaseEnd],
    /// The verdict whose defects are drawn instead of the holes.
    pub verdict: Option<&'a Verdict>,
    /// The unit of its coordinates, where it was given.
    pub unit: Option<Unit>,
}

impl Unchanged<'_> {
    /// The HTML page; it shows the command line.
    pub fn page(&self, command_line: &str) -> String {
        self.page_of(&self.scene(), command_line)
    }

    /// The PNG picture.
    ///
    /// # Errors
    /// [`JobError::Picture`] if memory runs out.
    pub fn picture(&self) -> Result<Vec<u8>, JobError> {
        Ok(self.picture_of(&self.scene())?)
    }

    pub(super) fn scene(&self) -> Scene {
        let mesh = &self.loaded.mesh;
        if let Some(verdict) = self.verdict {
            return marked_scene(mesh, self.found, verdict);
        }
        let change = SceneChange {
            before: mesh,
            after: mesh,
            kept: mesh.faces.len(),
            gone: vec![false; mesh.faces.len()],
            patches: Vec::new(),
            rims: rims(mesh, self.found.holes.iter()),
            errors: &[],
        };
        let points = self.crease_ends.iter().map(|end| end.position);
        Scene::new(&change, FACES).with_points(points)
    }

    pub(super) fn picture_of(&self, scene: &Scene) -> Result<Vec<u8>, PictureError> {
        match self.verdict {
            Some(_) => picture_of_marked(scene),
            None => picture_of_one(scene),
        }
    }

    pub(super) fn page_of(&self, scene: &Scene, command_line: &str) -> String {
        let (command, facts) = match self.verdict {
            Some(verdict) => ("check", self.facts_of_verdict(verdict)),
            None => ("inspect", self.facts()),
        };
        let holes: Vec<HoleReport> = self.found.holes.iter().map(HoleReport::listed).collect();
        page(&HtmlPage {
            title: &title(self.place),
            command,
            command_line,
            version: env!("CARGO_PKG_VERSION"),
            facts: &facts,
            notes: &self.loaded.notes,
            holes: &holes,
            regions: &[],
            scene,
            single: true,
            badge: self.verdict.map(badge_of),
            defects: &self.verdict.map_or_else(Vec::new, marked_defects),
        })
    }

    /// Name and value of the facts on the page of a verdict.
    fn facts_of_verdict(&self, verdict: &Verdict) -> Vec<(&'static str, String)> {
        let [low, high] = self.loaded.mesh.bounds();
        let mut facts = vec![("input", self.place.name()), ("verdict", verdict.line())];
        facts.extend(verdict_rows(verdict, low.distance(high), self.unit));
        facts
    }

    /// Name and value of the facts on the page of a mesh without a verdict.
    fn facts(&self) -> Vec<(&'static str, String)> {
        let mesh = &self.loaded.mesh;
        let topology = &self.found.topology;
        let [low, high] = mesh.bounds();
        let size = low.distance(high);
        let mut facts = vec![
            ("input", self.place.name()),
            ("vertices", mesh.positions.len().to_string()),
            ("faces", mesh.faces.len().to_string()),
            ("components", topology.component_faces.len().to_string()),
            ("from", point(low, size)),
            ("to", point(high, size)),
        ];
        if let Some(unit) = self.unit {
            facts.push(("unit of lengths", unit.to_string()));
        }
        if let Some(line) = crease_end_line(self.crease_ends) {
            facts.push(("sharp edges", line));
        }
        let defects = defect_lines(&topology.defects);
        if !defects.is_empty() {
            facts.push(("defects", defects.join("; ")));
        }
        facts
    }
}

/// A verdict as a badge.
pub(super) fn badge_of(verdict: &Verdict) -> Badge {
    let standing = Standing::of_verdict(verdict);
    let text = match standing {
        Standing::Yes => "watertight and printable",
        Standing::InPart => "watertight, of doubtful shape",
        Standing::No => "not printable",
    };
    let (class, text) = (standing.class(), text.to_owned());
    Badge { class, text }
}

/// The defects of a verdict, with their colours.
fn marked_defects(verdict: &Verdict) -> Vec<MarkedDefect> {
    let marked = verdict.defects.iter().map(|d| MarkedDefect {
        text: d.kind.text(d.count),
        rgb: colour(d.kind).rgb,
        places: d.places.clone(),
    });
    marked.collect()
}

/// A scene in which the faces with defects are sorted to the end and drawn like new faces, each kind of defect as a region.
fn marked_scene(mesh: &Mesh, found: &Inspection, verdict: &Verdict) -> Scene {
    let marks = verdict.marks();
    let of_kind = |kind: DefectKind| marks.iter().filter(move |(_, k)| **k == kind);
    let is_plain = |f: &u32| !marks.contains_key(f);
    let mut faces: Vec<u32> = (0..mesh.faces.len() as u32).filter(is_plain).collect();
    let kept = faces.len();
    for kind in DefectKind::ALL {
        faces.extend(of_kind(kind).map(|(f, _)| *f));
    }
    let sorted = faces.iter().map(|f| mesh.faces[*f as usize]).collect();
    let sorted = Mesh::new(mesh.positions.clone(), sorted);
    let change = SceneChange {
        before: &sorted,
        after: &sorted,
        kept,
        gone: vec![false; faces.len()],
        patches: DefectKind::ALL.map(|kind| of_kind(kind).count()).to_vec(),
        rims: rims(mesh, found.holes.iter()),
        errors: &[],
    };
    Scene::new(&change, FACES).with_palette(&DefectKind::ALL.map(colour))
}

/// The colour of a kind of defect.
fn colour(kind: DefectKind) -> LegendColour {
    let (name, rgb) = match kind {
        DefectKind::BoundaryEdge => ("blue", [0x2b, 0x6c, 0xc4]),
        DefectKind::NonManifoldEdge => ("magenta", [0xd0, 0x2f, 0xa8]),
        DefectKind::NonManifoldVertex => ("violet", [0x7d, 0x3f, 0xc8]),
        DefectKind::Misoriented => ("teal", [0x12, 0x9c, 0x9a]),
        DefectKind::InsideOut => ("brown", [0x8a, 0x55, 0x2b]),
        DefectKind::Degenerate => ("black", [0x20, 0x20, 0x20]),
        DefectKind::Duplicate => ("green", [0x3c, 0x9a, 0x38]),
        DefectKind::SelfIntersection => ("red", [0xdd, 0x22, 0x18]),
        DefectKind::Thin | DefectKind::ThinWall => ("yellow", [0xe8, 0xb4, 0x10]),
    };
    LegendColour { name, rgb }
}

/// The name of the file without its folder.
pub(super) fn title(input: &Place) -> String {
    let name = input.path().and_then(|path| path.file_name());
    name.map_or_else(|| input.name(), |n| n.to_string_lossy().into_owned())
}

/// The rims of holes as lists of positions.
pub(super) fn rims<'a>(mesh: &Mesh, holes: impl Iterator<Item = &'a Hole>) -> Vec<Vec<DVec3>> {
    let points = |hole: &Hole| {
        let rim = hole.rim.iter();
        rim.map(|&v| mesh.positions[v as usize]).collect()
    };
    holes.map(points).collect()
}
