//! Instances of glTF nodes by the extension `EXT_mesh_gpu_instancing`: each becomes a child node of its own, in the mesh that is
//! read and in the document that is written.

use gltf_json::Value;
use serde_json::{Map, json};

use super::super::{IoError, Location};
use super::accessor::{self, Raw};
use super::buffers::Buffers;
use super::rewritten::{Rewritten, parsed, rewritten, taken};

/// The extension that draws the mesh of a node once for each of several transforms.
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Estimated memory in bytes of a node, as text and parsed.
const NODE: usize = 1024;

/// Replaces instances by nodes; returns the file and the number of instances, or `None` if it has none.
pub(super) fn expanded(
    json: &[u8],
    buffers: &mut Buffers<'_>,
) -> Result<Option<(Rewritten, usize)>, IoError> {
    let Some(mut file) = parsed(json, INSTANCING, buffers)? else {
        return Ok(None);
    };
    let mut made: Vec<Value> = Vec::new();
    let nodes = file.get_mut("nodes").and_then(Value::as_array_mut);
    let Some(nodes) = nodes else {
        return Ok(None);
    };
    let first = nodes.len();
    for (index, node) in nodes.iter_mut().enumerate() {
        let instancing = taken(node, INSTANCING);
        let attributes = instancing.and_then(|i| i.get("attributes").cloned());
        let (Some(attributes), Some(node)) = (attributes, node.as_object_mut()) else {
            continue;
        };
        let transforms = transforms(&attributes, index, buffers)?;
        if transforms.is_empty() || !node.contains_key("mesh") {
            continue;
        }
        // The mesh, its skin and its weights go to the instances; their transforms are relative to the node.
        let moved = ["mesh", "skin", "weights"].map(|key| (key, node.remove(key)));
        let start = first + made.len();
        let numbers = (start..start + transforms.len()).map(|number| json!(number));
        let old = node.remove("children");
        let old = old.as_ref().and_then(Value::as_array).cloned();
        let children: Vec<Value> = numbers.chain(old.into_iter().flatten()).collect();
        node.insert("children".to_owned(), Value::Array(children));
        for mut instance in transforms {
            for (key, value) in &moved {
                if let Some(value) = value {
                    instance.insert((*key).to_owned(), value.clone());
                }
            }
            made.push(Value::Object(instance));
        }
    }
    let count = made.len();
    nodes.append(&mut made);
    Ok(Some((rewritten(file, INSTANCING, buffers.format)?, count)))
}

/// The transforms of the instances, as nodes without a mesh.
fn transforms(
    attributes: &Value,
    node: usize,
    buffers: &mut Buffers<'_>,
) -> Result<Vec<Map<String, Value>>, IoError> {
    let format = buffers.format;
    let fault = |what: String| IoError::malformed(format, Location::Item("node", node), what);
    let mut instances: Option<Vec<Map<String, Value>>> = None;
    for (name, key, components) in [
        ("TRANSLATION", "translation", 3),
        ("ROTATION", "rotation", 4),
        ("SCALE", "scale", 3),
    ] {
        let Some(index) = attributes.get(name).and_then(Value::as_u64) else {
            continue;
        };
        let Raw {
            components: own,
            values,
            scalar,
            normalized,
        } = accessor::attribute(buffers, usize::try_from(index).unwrap_or(usize::MAX))?;
        if own != components {
            let what = format!("the {key} of its instances has {own} components, not {components}");
            return Err(fault(what));
        }
        let count = values.len() / components;
        if instances.is_none() {
            buffers.spend(NODE.saturating_mul(count))?;
        }
        let all = instances.get_or_insert_with(|| vec![Map::new(); count]);
        if all.len() != count {
            let known = all.len();
            return Err(fault(format!(
                "it has {known} instances, but {count} of {name}"
            )));
        }
        let is_fraction = normalized && !scalar.is_float();
        let unit = if is_fraction { scalar.range()[1] } else { 1.0 };
        for (instance, value) in all.iter_mut().zip(values.chunks_exact(components)) {
            let value: Vec<f64> = value.iter().map(|x| x / unit).collect();
            if value.iter().any(|x| !x.is_finite()) {
                return Err(fault(format!("the {key} of an instance is not finite")));
            }
            instance.insert(key.to_owned(), json!(value));
        }
    }
    Ok(instances.unwrap_or_default())
}
