//! API requests for values that colour a mesh (curvature, distance, deviation, expected error, attributes), for textures, and for the
//! check for defects.

use std::sync::{Arc, PoisonError};

use axum::extract::{Path, Query, State};
use axum::http::header::CONTENT_TYPE;
use axum::response::IntoResponse;
use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::super::app::{App, error_text};
use super::super::container::Container;
use super::super::deviation::deviation;
use super::super::files::to_read;
use super::super::state::{Origin, State as MeshState};
use super::super::texture::{uv, v_points_up};
use super::http::{Answer, Refused, bytes_answer, json_answer, long_work, work};
use super::mesh::state_of;
use isomend_core::check::CheckParams;
use isomend_core::mend::Control;
use isomend_core::mesh::attributes::{Attribute, Role};
use isomend_core::mesh::connected;
use isomend_files::io::read_path;
use isomend_files::job::{Drawings, check as check_mesh};
use isomend_files::report::scene::{curvature, distances};

/// Fraction of the values that the range of the colour scale leaves out: half at each end, for expected errors all at the upper end.
pub const OUTLIERS: f64 = 0.03;
/// Upper bound of the number of listed faces of each kind of defect.
const MARKED: usize = 10_000;

#[derive(Deserialize)]
pub struct ValuesQuery {
    name: String,
    /// The mesh that distances are measured from; none for the mesh before the step.
    to: Option<u32>,
    /// A file below the folder that deviations are measured from, instead of a mesh of the session.
    file: Option<String>,
}

/// Values of vertices, faces or corners.
struct Values {
    on: &'static str,
    unit: &'static str,
    components: usize,
    values: Vec<f32>,
    /// Whether the values are colours, from 0 to 1.
    are_colours: bool,
    /// The range of the colour scale; none for the range of the values.
    range: Option<[f32; 2]>,
}

impl Values {
    fn of_vertices(values: Vec<f32>, unit: &'static str) -> Self {
        Self {
            on: "vertex",
            unit,
            components: 1,
            values,
            are_colours: false,
            range: None,
        }
    }

    fn packed(self, id: u32, name: &str) -> Vec<u8> {
        let [low, high] = self.range.unwrap_or_else(|| range(&self.values));
        let container = Container::new(json!({
            "id": id, "name": name, "on": self.on, "unit": self.unit, "low": low, "high": high,
        }));
        let byte = |x: &f32| (255.0 * x.clamp(0.0, 1.0)).round() as u8;
        match self.are_colours {
            true => {
                let colours = self.values.chunks_exact(self.components).flat_map(|c| {
                    let opacity = c.get(3).map_or(255, byte);
                    [byte(&c[0]), byte(&c[1]), byte(&c[2]), opacity]
                });
                container.with("values", 4, colours).bytes()
            }
            false => container
                .with("values", self.components, self.values)
                .bytes(),
        }
    }
}

/// The range of the finite values without the outliers at both ends.
fn range(values: &[f32]) -> [f32; 2] {
    let mut sorted: Vec<f32> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    let out = (sorted.len() as f64 * OUTLIERS / 2.0) as usize;
    let at = |i: usize| sorted.get(i).copied().unwrap_or(0.0);
    let (low, high) = (at(out), at(sorted.len().saturating_sub(1 + out)));
    match low < high {
        true => [low, high],
        // Nearly all values are equal: the outliers give the range.
        false => [at(0), at(sorted.len().saturating_sub(1))],
    }
}

/// `GET api/values/ID?name=…`: values that colour a mesh.
pub async fn values(
    State(app): State<Arc<App>>,
    Path((_, id)): Path<(String, u32)>,
    Query(ValuesQuery { name, to, file }): Query<ValuesQuery>,
) -> Answer {
    let bytes = long_work(&app, move |app| {
        let state = state_of(app, id)?;
        let mesh = &state.loaded.mesh;
        let values = match &name[..] {
            "curvature" => Values::of_vertices(curvature(mesh), "1/length"),
            "distance" => {
                let other = match to {
                    Some(id) => Some(state_of(app, id)?),
                    None => state.parent.clone(),
                };
                Values::of_vertices(distance(&state, other.as_deref()), "length")
            }
            "deviation" => deviations(app, &state, to, file.as_deref())?,
            "sigma" => expected_errors(&state)?,
            name => attribute(&state, name)?,
        };
        Ok(values.packed(id, &name))
    });
    Ok(bytes_answer(bytes.await?))
}

/// Distances of the new vertices from another mesh, 0 for the kept ones; of all vertices if this mesh was not made from the other.
fn distance(state: &MeshState, other: Option<&MeshState>) -> Vec<f32> {
    let mesh = &state.loaded.mesh;
    let Some(other) = other else {
        return vec![0.0; mesh.positions.len()];
    };
    distances(mesh, &is_new(state, other), &other.loaded.mesh)
}

/// For each vertex whether it is new relative to another mesh; all are new if this mesh was not made from it.
fn is_new(state: &MeshState, other: &MeshState) -> Vec<bool> {
    let is_parent = state.parent.as_ref().is_some_and(|p| p.id == other.id);
    let kept = state.delta.as_ref().filter(|_| is_parent);
    let kept = kept.map_or(0, |delta| delta.vertices.count());
    (0..state.loaded.mesh.positions.len())
        .map(|v| v >= kept)
        .collect()
}

/// Signed distances: of all vertices from a file, or of the new vertices from a mesh of the session.
fn deviations(
    app: &App,
    state: &MeshState,
    to: Option<u32>,
    file: Option<&str>,
) -> Result<Values, Refused> {
    let mesh = &state.loaded.mesh;
    let values = match file {
        Some(name) => {
            let path = to_read(&app.host.root, name)?;
            let reference = read_path(&path, None);
            let reference =
                reference.map_err(|error| Refused::wrong(error_text(&error), "file"))?;
            let all = vec![true; mesh.positions.len()];
            deviation(mesh, &all, &reference.mesh)
        }
        None => {
            let other = to.map(|id| state_of(app, id)).transpose()?;
            let other = other.or_else(|| state.parent.clone());
            let other = other
                .ok_or_else(|| Refused::missing("there is no earlier mesh to measure from"))?;
            deviation(mesh, &is_new(state, &other), &other.loaded.mesh)
        }
    };
    let mut values = Values::of_vertices(values, "length");
    let [low, high] = range(&values.values);
    let most = low.abs().max(high.abs());
    values.range = Some([-most, most]);
    Ok(values)
}

/// The expected errors of the vertices, or of the corners of faces where patches have no vertices of their own: 0 for vertices of the file,
/// NaN where unknown.
fn expected_errors(state: &MeshState) -> Result<Values, Refused> {
    let errors = &state.errors;
    if !errors.is_known() {
        return Err(Refused::missing(
            "the mesh has no expected errors: no step has estimated any",
        ));
    }
    let mut values = Values::of_vertices(errors.0.clone(), "in the mesh's units");
    let mesh = &state.loaded.mesh;
    let unknown = unknown_faces(state);
    if !unknown.is_empty() {
        let corners = mesh.faces.iter().flatten();
        values.on = "corner";
        values.values = corners.map(|v| errors.0[*v as usize]).collect();
        for face in unknown {
            values.values[3 * face as usize..][..3].fill(f32::NAN);
        }
    }
    values.range = Some([0.0, errors.high(OUTLIERS)]);
    Ok(values)
}

/// The faces of patches whose errors are unknown although their vertices are the input's, as of a triangulation of a rim: those that no
/// other faces of patches join with a vertex whose error is known.
fn unknown_faces(state: &MeshState) -> Vec<u32> {
    let (mesh, errors) = (&state.loaded.mesh, &state.errors.0);
    let own = |f: &u32| state.origin[*f as usize] != Origin::File;
    let patches: Vec<u32> = (0..mesh.faces.len() as u32).filter(own).collect();
    let errors_of = |f: u32| mesh.faces[f as usize].map(|v| errors[v as usize]);
    let is_bare = |f: &u32| errors_of(*f).iter().all(|e| *e == 0.0);
    if !patches.iter().any(is_bare) {
        return Vec::new();
    }
    let is_unknown =
        |patch: &Vec<u32>| !patch.iter().any(|f| errors_of(*f).iter().any(|e| *e > 0.0));
    let unknown = connected(mesh, &patches).into_iter().filter(is_unknown);
    unknown.flatten().filter(is_bare).collect()
}

/// The values of an attribute of vertices, faces or corners; `name` is such as `attribute:quality`.
fn attribute(state: &MeshState, name: &str) -> Result<Values, Refused> {
    let missing = || Refused::missing(format!("the mesh has no values named {name}"));
    let name = name.strip_prefix("attribute:").ok_or_else(missing)?;
    let attributes = &state.loaded.attributes;
    let named = |list: &[Attribute]| list.iter().find(|a| a.name == name).cloned();
    let faces = state.loaded.mesh.faces.len();
    let corners = attributes.corner.iter().find(|c| c.pool.name == name);
    let (on, count, found) = match (named(&attributes.vertex), corners) {
        (Some(found), _) => ("vertex", state.loaded.mesh.positions.len(), found),
        (None, Some(corners)) => ("corner", 3 * faces, corners.pool.clone()),
        (None, None) => ("face", faces, named(&attributes.face).ok_or_else(missing)?),
    };
    let corners = corners.filter(|_| on == "corner");
    let value = |item: usize| match corners {
        Some(corners) => corners.get(item / 3, item % 3),
        None => found.get(item),
    };
    let unit = found.unit();
    let components = found.components;
    let mut values = Vec::with_capacity(components * count);
    for item in 0..count {
        match value(item) {
            Some(value) => values.extend(value.iter().map(|x| (x / unit) as f32)),
            None => values.extend(std::iter::repeat_n(f32::NAN, components)),
        }
    }
    Ok(Values {
        on,
        unit: "",
        components,
        values,
        are_colours: found.role == Role::Colour && matches!(components, 3 | 4),
        range: None,
    })
}

/// `GET api/uv/ID`: the texture coordinates of each corner, and the image of each face.
pub async fn uvs(State(app): State<Arc<App>>, Path((_, id)): Path<(String, u32)>) -> Answer {
    let bytes = work(&app, move |app| {
        let state = state_of(app, id)?;
        let textures = state.textures();
        if textures.count() == 0 {
            return Err(Refused::missing("the mesh has no texture"));
        }
        let loaded = &state.loaded;
        let faces = 0..loaded.mesh.faces.len();
        let corners = faces.flat_map(|face| (0..3).map(move |corner| (face, corner)));
        let values =
            corners.flat_map(|(face, corner)| uv(loaded, face, corner).unwrap_or([f32::NAN; 2]));
        let header =
            json!({ "id": id, "v_up": v_points_up(loaded.format), "textures": textures.count() });
        Ok(Container::new(header)
            .with("uv", 2, values)
            .with("texture", 1, textures.of_face.iter().copied())
            .bytes())
    });
    Ok(bytes_answer(bytes.await?))
}

/// `GET api/texture/N`: an image of the current mesh.
pub async fn texture(
    State(app): State<Arc<App>>,
    Path((_, number)): Path<(String, usize)>,
) -> Answer {
    let (kind, bytes) = work(&app, move |app| {
        let state = app.session().current().clone();
        let image = state.textures().image(number, &state.loaded, &app.input);
        image.ok_or_else(|| Refused::missing("the image is missing, or a browser cannot show it"))
    })
    .await?;
    Ok(([(CONTENT_TYPE, kind)], bytes).into_response())
}

/// `GET api/check/ID`: the check for defects.
pub async fn check(
    State(app): State<Arc<App>>,
    Path((_, id)): Path<(String, u32)>,
    Query(params): Query<CheckQuery>,
) -> Answer {
    let value = work(&app, move |app| {
        let (state, params) = (state_of(app, id)?, params.params()?);
        // Lock outside of the rayon pool: a thread of the pool that waits may take up another request, and wait for itself.
        let mut known = state.checked.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, value)) = known.as_ref().filter(|(p, _)| *p == params) {
            return Ok(value.clone());
        }
        let value = app.host.aside.install(|| checked(app, &state, &params))?;
        *known = Some((params, value.clone()));
        Ok(value)
    });
    Ok(json_answer(&value.await?))
}

#[derive(Deserialize)]
pub struct CheckQuery {
    thin: Option<f64>,
    debris: Option<f64>,
    min_wall: Option<f64>,
}

impl CheckQuery {
    fn params(&self) -> Result<CheckParams, Refused> {
        let mut params = CheckParams::default();
        params.thin = self.thin;
        params.debris = self.debris.unwrap_or(params.debris);
        params.min_wall = self.min_wall;
        for (length, name) in [(self.thin, "thin"), (self.min_wall, "min_wall")] {
            if length.is_some_and(|l| !(l.is_finite() && l > 0.0)) {
                return Err(Refused::wrong("the length must be positive", name));
            }
        }
        match (0.0..=1.0).contains(&params.debris) {
            true => Ok(params),
            false => Err(Refused::wrong("the number must be from 0 to 1", "debris")),
        }
    }
}

/// The document of `isomend check`, with the faces of each kind of defect added.
fn checked(app: &App, state: &MeshState, params: &CheckParams) -> Result<Value, Refused> {
    let source = app.source_of(state);
    let (drawings, control) = (Drawings::default(), Control::new());
    let checked = check_mesh(&source, &state.loaded, params, None, &drawings, &control);
    let checked = checked.map_err(|error| Refused::failed(error_text(&error)))?;
    let mut value = serde_json::to_value(checked.document()).unwrap_or_default();
    let mut marks = Map::new();
    for defect in &checked.verdict.defects {
        let faces = &defect.faces[..defect.faces.len().min(MARKED)];
        let kind = serde_json::to_value(defect.kind).unwrap_or_default();
        let name = kind.as_str().unwrap_or_default().to_owned();
        marks.insert(name, json!({ "all": defect.faces.len(), "faces": faces }));
    }
    value["marks"] = Value::Object(marks);
    judged_by_repair(&mut value, state);
    Ok(value)
}

/// Puts the verdict of the repair that made the mesh in place of the check's: it knows which walls it has made, and how far the shape is
/// doubtful. Only if both judge by the same minimum wall, or the check by none: the repair has chosen its own then.
fn judged_by_repair(value: &mut Value, state: &MeshState) {
    let Some(step) = &state.step else { return };
    let after = &step.document["after"];
    let judges = value["min_wall"].is_null() || after["min_wall"] == value["min_wall"];
    if after.is_null() || !judges {
        return;
    }
    for name in ["sound", "reasons", "doubt", "defects"] {
        value[name] = after[name].clone();
    }
}

#[cfg(test)]
mod tests {
    use super::range;

    #[test]
    fn a_range_leaves_out_outliers() {
        let mut values: Vec<f32> = (0..1000).map(|i| i as f32).collect();
        values.extend([1e9, -1e9, f32::NAN, f32::INFINITY]);
        let [low, high] = range(&values);
        assert!((0.0..50.0).contains(&low) && (950.0..1000.0).contains(&high));
        assert_eq!(range(&[0.0; 9]), [0.0, 0.0]);
        let mut few = vec![0.0; 1000];
        few[7] = 2.0;
        assert_eq!(range(&few), [0.0, 2.0]);
        assert_eq!(range(&[]), [0.0, 0.0]);
    }
}
