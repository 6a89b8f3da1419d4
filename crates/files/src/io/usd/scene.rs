//! Walks through the prims of a USD stage and collects its meshes with their transforms and materials.

use std::collections::BTreeMap;

use glam::DMat4;

use super::super::mesh_builder::{CutFrom, MeshBuilder};
use super::super::text::Distinct;
use super::super::{IoError, Loaded};
use super::attributes;
use super::layers::Layers;
use super::prim::Prim;
use super::stage::Scene;
use super::{mesh, transforms};

/// Most prims inside each other.
const DEEPEST: usize = 256;
/// Estimated memory in bytes of a prim.
const PRIM: usize = 256;

/// A prim whose children are still to be visited.
struct Visit {
    prim: Prim,
    transform: DMat4,
    material: Option<String>,
    depth: usize,
}

/// Collects the meshes below the prim without a name.
pub(super) fn read(root: &Prim, layers: &mut Layers<'_>) -> Result<Scene, IoError> {
    let mut scene = Scene {
        surface: MeshBuilder::new(layers.budget.format),
        meshes: Vec::new(),
        faces: Vec::new(),
        corners: Vec::new(),
        skipped: BTreeMap::new(),
        others: BTreeMap::new(),
        names: Distinct::default(),
    };
    let mut stack: Vec<Visit> = Vec::new();
    let start = |prim| Visit {
        prim,
        transform: DMat4::IDENTITY,
        material: None,
        depth: 0,
    };
    stack.extend(layers.children(root)?.into_iter().rev().map(start));
    while let Some(visit) = stack.pop() {
        layers.budget.spend(PRIM)?;
        let Some(own) = scene.visit(visit, layers)? else {
            continue;
        };
        if own.depth >= DEEPEST {
            scene.skip("prims that are too deep inside each other", 1);
            continue;
        }
        let below = layers
            .children(&own.prim)?
            .into_iter()
            .rev()
            .map(|prim| Visit {
                prim,
                transform: own.transform,
                material: own.material.clone(),
                depth: own.depth + 1,
            });
        stack.extend(below);
    }
    Ok(scene)
}

impl Scene {
    /// Visits a prim; returns it with its own transform and material if its children are to be visited.
    fn visit(
        &mut self,
        mut visit: Visit,
        layers: &mut Layers<'_>,
    ) -> Result<Option<Visit>, IoError> {
        let prim = &visit.prim;
        if !prim.is_there() {
            return Ok(None);
        }
        match prim.kind() {
            "Material" | "Shader" | "NodeGraph" => {
                let has_shaders = !layers.children(prim)?.is_empty();
                *self.others.entry("shaders of materials").or_default() += usize::from(has_shaders);
                return Ok(None);
            }
            "PointInstancer" => {
                self.skip("instances of point instancers", 1);
                return Ok(None);
            }
            "Cube" | "Sphere" | "Cylinder" | "Cone" | "Capsule" | "Plane" | "BasisCurves"
            | "NurbsCurves" | "NurbsPatch" | "Points" | "TetMesh" | "HermiteCurves" | "Volume" => {
                self.skip("shapes other than meshes", 1)
            }
            "Camera" => *self.others.entry("cameras").or_default() += 1,
            kind if kind.ends_with("Light") => *self.others.entry("lights").or_default() += 1,
            "Skeleton" | "SkelAnimation" => {
                *self
                    .others
                    .entry("skeletons and their animations")
                    .or_default() += 1
            }
            _ => {}
        }
        if prim.word("visibility").as_deref() == Some("invisible") {
            self.skip("invisible prims", 1);
            return Ok(None);
        }
        if matches!(prim.word("purpose").as_deref(), Some("guide" | "proxy")) {
            self.skip("prims for guidance or as proxies", 1);
            return Ok(None);
        }
        self.skip(
            "sets of variants without a chosen one",
            prim.node.unchosen(),
        );
        visit.transform = self.transform(prim, visit.transform);
        if let Some(material) = mesh::material(prim) {
            visit.material = Some(material);
        }
        if prim.kind() == "Mesh" {
            let (transform, material) = (visit.transform, visit.material.clone());
            let name = self.names.name(prim.name.clone());
            self.mesh(prim, (name, material), transform, layers)?;
        }
        Ok(Some(visit))
    }

    /// The transform of a prim below one with the given transform.
    fn transform(&mut self, prim: &Prim, above: DMat4) -> DMat4 {
        let own = transforms::local(prim);
        self.skip(
            "transforms that cannot be read, taken as none",
            usize::from(own.is_unread),
        );
        self.skip(
            "operations of transforms without a value",
            own.without_value,
        );
        match own.resets {
            true => own.matrix,
            false => above * own.matrix,
        }
    }

    /// Checks and triangulates the meshes, and gathers their attributes.
    pub(super) fn finish(mut self, layers: &mut Layers<'_>) -> Result<Loaded, IoError> {
        let mut cut = Some(CutFrom::identity(0));
        let surface = std::mem::replace(&mut self.surface, MeshBuilder::new(layers.budget.format));
        let mut loaded = surface.finish_with(&mut cut)?;
        let cut = cut.unwrap_or_else(|| CutFrom::identity(loaded.mesh.faces.len()));
        attributes::gather(&self, &cut, &mut loaded, layers)?;
        for (what, count) in &self.skipped {
            loaded.notes.push(format!("skipped: {what}: {count}"));
        }
        Ok(loaded)
    }
}
