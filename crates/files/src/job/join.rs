//! Joins what was made of the bodies of a mesh: meshes, origins and reports.

use std::ops::Range;

use super::JobError;
use super::result::{KeptInput, Made, OperationReport, ReplacedBody};
use crate::io::Loaded;
use isomend_core::mend::{
    BodyNumbers, FairReport, FillReport, HolesByRim, Inspection, RestoreReport,
};
use isomend_core::mesh::attributes::{LabelKind, NONE};
use isomend_core::mesh::cut::Remainder;
use isomend_core::mesh::{Bodies, FaceOrigin, Mesh, Origins};
use isomend_core::repair::RepairReport;

/// What was made of a body.
pub(super) struct Part {
    pub(super) made: Made,
    /// The numbers of its vertices and holes in the whole input.
    pub(super) numbers: BodyNumbers,
}

/// Joins what was made of each body. Kept vertices and faces come first, in the order of the input; new ones follow, body by body.
pub(super) fn joined(
    input: &Loaded,
    bodies: &Bodies,
    mut parts: Vec<Part>,
    whole: &Inspection,
) -> Result<Made, JobError> {
    let mesh = Joined::new(bodies, &parts);
    for Part { made, numbers } in &mut parts {
        if let OperationReport::Region(cut) = &mut made.extent {
            cut.number_in_whole(numbers);
        }
    }
    let kept_input = mesh.kept_input(input, &parts);
    let mut next = whole.holes.len() + 1;
    if matches!(kept_input, KeptInput::Cut(_)) {
        next = renumber_after_cut(input, &kept_input, &mesh, (bodies, &mut parts))?;
    }
    let replaced = mesh.replaced(input, bodies, &parts);
    let (mut fills, mut repairs) = (Vec::new(), Vec::new());
    let (mut fairs, mut restores) = (Vec::new(), Vec::new());
    let (mut errors, mut components) = (Vec::new(), Vec::new());
    let mut extent = OperationReport::Holes;
    for (k, Part { made, mut numbers }) in parts.into_iter().enumerate() {
        numbers.vertices.clone_from(&mesh.vertices[k]);
        fills.push((made.report, numbers));
        errors.extend(made.expected_error);
        match made.extent {
            OperationReport::Repaired(report) => {
                repairs.push((bodies.names[k].clone(), *report));
                let found = Inspection::new(&made.mesh)?;
                components.push(found.topology.component_faces.len());
            }
            OperationReport::Faired(report) => fairs.push((bodies.names[k].clone(), report)),
            OperationReport::Region(report) => restores.push(report),
            _ => {}
        }
    }
    if !repairs.is_empty() {
        let report = RepairReport::of_bodies(repairs, &components);
        extent = OperationReport::Repaired(Box::new(report));
    } else if !fairs.is_empty() {
        extent = OperationReport::Faired(FairReport::of_bodies(fairs));
    } else if !restores.is_empty() {
        extent = OperationReport::Region(RestoreReport::of_bodies(restores));
    }
    Ok(Made {
        mesh: mesh.mesh,
        expected_error: errors,
        kept_input,
        extent,
        report: FillReport::of_bodies(fills, next),
        replaced,
    })
}

/// The joined mesh.
struct Joined {
    mesh: Mesh,
    /// The origins in the whole input of its kept vertices and faces.
    origins: Origins,
    /// For each vertex of each body's mesh, its number here.
    vertices: Vec<Vec<u32>>,
    /// For each body the range of its new faces.
    new_faces: Vec<Range<usize>>,
}

impl Joined {
    fn new(bodies: &Bodies, parts: &[Part]) -> Self {
        let own: Vec<Origins> = parts
            .iter()
            .enumerate()
            .map(|(k, part)| in_input(&part.made, [&bodies.vertices[k], &bodies.faces[k]]))
            .collect();
        // Kept vertices first.
        let order = merged(own.iter().map(|o| o.vertices.clone()).collect());
        let mut vertices: Vec<Vec<u32>> = parts
            .iter()
            .map(|part| vec![NONE; part.made.mesh.positions.len()])
            .collect();
        let (mut mesh, mut origins) = (Mesh::default(), Origins::default());
        for (k, i) in order {
            vertices[k][i] = mesh.positions.len() as u32;
            mesh.positions.push(parts[k].made.mesh.positions[i]);
            origins.vertices.push(own[k].vertices[i]);
        }
        for (k, part) in parts.iter().enumerate() {
            for i in own[k].vertices.len()..part.made.mesh.positions.len() {
                vertices[k][i] = mesh.positions.len() as u32;
                mesh.positions.push(part.made.mesh.positions[i]);
            }
        }
        // Kept faces first.
        let corners = |k: usize, i: usize| {
            let face = parts[k].made.mesh.faces[i];
            face.map(|v| vertices[k][v as usize])
        };
        let ids = own.iter().map(|o| o.faces.iter().map(|o| o.face).collect());
        for (k, i) in merged(ids.collect()) {
            mesh.faces.push(corners(k, i));
            origins.faces.push(own[k].faces[i]);
        }
        let mut new_faces = Vec::new();
        for (k, part) in parts.iter().enumerate() {
            let new = own[k].faces.len()..part.made.mesh.faces.len();
            let start = mesh.faces.len();
            mesh.faces.extend(new.map(|i| corners(k, i)));
            new_faces.push(start..mesh.faces.len());
        }
        Self {
            mesh,
            origins,
            vertices,
            new_faces,
        }
    }

    /// The bodies that were replaced as a whole.
    fn replaced(&self, input: &Loaded, bodies: &Bodies, parts: &[Part]) -> Vec<ReplacedBody> {
        let mut replaced = Vec::new();
        for (k, part) in parts.iter().enumerate() {
            if let KeptInput::Nothing = part.made.kept_input {
                let kinds = [LabelKind::Object, LabelKind::Part];
                let of_first = |kind| Some((kind, input.attributes.labels_of(kind)?));
                let labels = kinds.into_iter().filter_map(of_first);
                let first = bodies.faces[k][0] as usize;
                replaced.push(ReplacedBody {
                    faces: self.new_faces[k].clone(),
                    labels: labels.map(|(kind, l)| (kind, l.of_face[first])).collect(),
                });
            }
        }
        replaced
    }

    /// The kept part of the input.
    fn kept_input(&self, input: &Loaded, parts: &[Part]) -> KeptInput {
        let is_gone = |part: &Part| matches!(part.made.kept_input, KeptInput::Nothing);
        let is_cut =
            |part: &Part| matches!(part.made.kept_input, KeptInput::Cut(_) | KeptInput::Nothing);
        let is_repaired = |part: &Part| matches!(part.made.kept_input, KeptInput::Repaired { .. });
        let kept = Mesh::new(
            self.mesh.positions[..self.origins.vertices.len()].to_vec(),
            self.mesh.faces[..self.origins.faces.len()].to_vec(),
        );
        if parts.iter().any(is_repaired) {
            return KeptInput::Repaired {
                mesh: kept,
                origins: self.origins.clone(),
            };
        }
        if parts.iter().all(is_gone) {
            return KeptInput::Nothing;
        }
        if !parts.iter().any(is_cut) {
            return KeptInput::All;
        }
        let mut vertices = vec![false; input.mesh.positions.len()];
        let mut faces = vec![false; input.mesh.faces.len()];
        let old = self.origins.vertices.iter();
        old.for_each(|v| vertices[*v as usize] = true);
        let old = self.origins.faces.iter();
        old.for_each(|o| faces[o.face as usize] = true);
        KeptInput::Cut(Remainder {
            mesh: kept,
            faces,
            vertices,
        })
    }
}

/// The origins in the whole input of what a body keeps. `vertices` and `faces` are the numbers of the body's vertices and faces there.
fn in_input(made: &Made, [vertices, faces]: [&[u32]; 2]) -> Origins {
    let marked = |marks: &[bool]| -> Vec<u32> {
        (0..marks.len() as u32)
            .filter(|k| marks[*k as usize])
            .collect()
    };
    let own = match &made.kept_input {
        KeptInput::All => Origins {
            vertices: (0..vertices.len() as u32).collect(),
            faces: (0..faces.len() as u32).map(FaceOrigin::same).collect(),
        },
        KeptInput::Cut(kept) => Origins {
            vertices: marked(&kept.vertices),
            faces: marked(&kept.faces)
                .into_iter()
                .map(FaceOrigin::same)
                .collect(),
        },
        KeptInput::Nothing => Origins::default(),
        KeptInput::Repaired { origins, .. } => origins.clone(),
    };
    let old = |origin: &FaceOrigin| FaceOrigin {
        face: faces.get(origin.face as usize).copied().unwrap_or(NONE),
        ..*origin
    };
    Origins {
        vertices: own.vertices.iter().map(|v| vertices[*v as usize]).collect(),
        faces: own.faces.iter().map(old).collect(),
    }
}

/// Merges lists of old numbers, one for each body: pairs of body and index, sorted by old number. The order within each body stays.
fn merged(lists: Vec<Vec<u32>>) -> Vec<(usize, usize)> {
    let mut all: Vec<(u32, usize, usize)> = Vec::new();
    for (k, list) in lists.into_iter().enumerate() {
        let mut largest = 0;
        for (i, old) in list.into_iter().enumerate() {
            largest = largest.max(old);
            all.push((largest, k, i));
        }
    }
    all.sort_unstable();
    all.into_iter().map(|(_, k, i)| (k, i)).collect()
}

/// Numbers the holes of a restoration as after the cut, in the whole mesh. Returns the number after the last.
fn renumber_after_cut(
    input: &Loaded,
    kept: &KeptInput,
    mesh: &Joined,
    (bodies, parts): (&Bodies, &mut [Part]),
) -> Result<usize, JobError> {
    let KeptInput::Cut(kept) = kept else {
        return Ok(1);
    };
    let remaining = input.restricted(kept.mesh.clone(), [&kept.vertices, &kept.faces]);
    let whole = Inspection::of_bodies(&remaining.mesh, remaining.bodies().as_ref())?;
    let known = HolesByRim::new(&whole);
    for (k, part) in parts.iter_mut().enumerate() {
        if let KeptInput::Cut(own) = &part.made.kept_input {
            let found = Inspection::new(&own.mesh)?;
            part.numbers = BodyNumbers::new(&known, &found, &mesh.vertices[k], &bodies.names[k]);
        }
    }
    Ok(whole.holes.len() + 1)
}
