//! The tools of `isomend mcp`: their schemas, made from the tables of parameters, and their work on the files of one folder.

use std::path::PathBuf;

use anyhow::{anyhow, bail};
use isomend::Control;
use isomend::job::{JobSpec, Source, named_work, schema};
use isomend::parameters::Table;
use isomend_view::{Denied, to_read, to_write};
use serde::Serialize;
use serde_json::{Map, Value, json};

/// A tool.
struct Tool {
    name: &'static str,
    description: &'static str,
    /// Its table of parameters, if it has one.
    table: Option<&'static Table>,
    writes: bool,
}

const TOOLS: [Tool; 4] = [
    Tool {
        name: "inspect",
        description: "Lists the components, holes (with numbers, sizes and places) and defects of a mesh file.",
        table: None,
        writes: false,
    },
    Tool {
        name: "check",
        description: "Says whether a mesh file is watertight, manifold, oriented and free of self-intersections, and lists all defects.",
        table: Some(Table::CHECK),
        writes: false,
    },
    Tool {
        name: "fill",
        description: "Fills the holes of a mesh file with patches that continue the curvature round them, and writes another file. Faces of \
                      the input stay as they are.",
        table: Some(Table::FILL),
        writes: true,
    },
    Tool {
        name: "repair",
        description: "Repairs the defects of a mesh file (duplicates, orientation, non-manifold edges, self-intersections, holes) and writes \
                      another file.",
        table: Some(Table::REPAIR),
        writes: true,
    },
];

/// The tools for the files of a folder.
pub struct Tools {
    /// The folder, with links resolved.
    root: PathBuf,
    is_read_only: bool,
}

impl Tools {
    pub fn new(root: PathBuf, is_read_only: bool) -> Self {
        Self { root, is_read_only }
    }

    /// The tools that are offered.
    fn offered(&self) -> impl Iterator<Item = &'static Tool> {
        let is_read_only = self.is_read_only;
        let tools = TOOLS.iter();
        tools.filter(move |tool| !(is_read_only && tool.writes))
    }

    /// Whether a tool is offered.
    pub fn has(&self, name: &str) -> bool {
        self.offered().any(|tool| tool.name == name)
    }

    /// The tools as the protocol lists them.
    pub fn list(&self) -> Vec<Value> {
        self.offered().map(Tool::row).collect()
    }

    /// Does the work of a tool; returns its JSON document.
    pub fn call(
        &self,
        name: &str,
        mut given: Map<String, Value>,
        control: &Control,
    ) -> anyhow::Result<Value> {
        let path = taken(&mut given, "path")?.ok_or_else(|| anyhow!("\"path\" is missing"))?;
        let source = Source::from(self.readable(&path)?);
        if TOOLS.iter().any(|tool| tool.name == name && tool.writes) {
            return self.mend(name, source, given, control);
        }
        let (work, deliverables) = named_work(name, None, given)?;
        let mut spec = JobSpec::plan(source, work);
        spec.deliverables = deliverables;
        document(&spec.read()?.look(control)?.document())
    }

    /// Fills or repairs a mesh.
    fn mend(
        &self,
        name: &str,
        source: Source,
        mut given: Map<String, Value>,
        control: &Control,
    ) -> anyhow::Result<Value> {
        let output = taken(&mut given, "output")?;
        let overwrite = is_set(&mut given, "overwrite")?;
        let is_plan = is_set(&mut given, "dry_run")?;
        let (mut work, deliverables) = named_work(name, None, given)?;
        if let Some(file) = work.template() {
            let file = self.readable(&file.to_string_lossy())?;
            work = work.with_template(file);
        }
        if is_plan {
            let mut spec = JobSpec::plan(source, work);
            spec.deliverables = deliverables;
            return document(&spec.preview()?.document());
        }
        let Some(output) = output else {
            bail!("\"output\" is missing: name the file to write, or set \"dry_run\"");
        };
        let file = self.writable(&output, overwrite)?;
        let mut spec = JobSpec::new(source, file, work)?;
        spec.deliverables = deliverables;
        spec.check()?;
        let mended = spec.read()?.mend(control)?;
        // Meanwhile the file, or a link in its place, may have been made.
        self.writable(&output, overwrite)?;
        document(&mended.write()?.document())
    }

    /// The path of a file that may be written.
    fn writable(&self, name: &str, overwrite: bool) -> anyhow::Result<PathBuf> {
        to_write(&self.root, name, overwrite).map_err(|denied| {
            let advice = match denied {
                Denied::Exists(_) => "; name another file, or set \"overwrite\"",
                _ => "",
            };
            anyhow!("{}{advice}", denied.words())
        })
    }

    /// The path of a file that may be read.
    fn readable(&self, name: &str) -> anyhow::Result<PathBuf> {
        to_read(&self.root, name).map_err(|denied| anyhow!(denied.words()))
    }
}

impl Tool {
    /// The tool as the protocol lists it, with the schema of its arguments.
    fn row(&self) -> Value {
        let mut schema = match self.table {
            Some(table) => schema(table),
            None => {
                let mut schema = schema(Table::CHECK);
                if let Some(all) = schema["properties"].as_object_mut() {
                    all.retain(|name, _| name == "unit");
                }
                schema
            }
        };
        let text = |what: &str| json!({ "type": "string", "description": what });
        let flag = |what: &str| json!({ "type": "boolean", "description": what });
        let properties = &mut schema["properties"];
        properties["path"] = text("The mesh file, below the folder of the server.");
        if self.writes {
            properties["output"] = text(
                "The file to write, below the folder of the server, in the format of its extension: obj, ply, stl, gltf, glb, vtk, vtp, off, \
                 3mf, usda or usdz. Its folder must exist.",
            );
            properties["overwrite"] = flag("Replace the output if it exists. Default: false.");
            properties["dry_run"] =
                flag("Only say what would be done; nothing is written. Default: false.");
        }
        schema["required"] = json!(["path"]);
        json!({
            "name": self.name,
            "description": self.description,
            "inputSchema": schema,
            "annotations": { "readOnlyHint": !self.writes, "destructiveHint": self.writes, "openWorldHint": false },
        })
    }
}

/// Takes a text out of the arguments.
fn taken(given: &mut Map<String, Value>, name: &str) -> anyhow::Result<Option<String>> {
    match given.remove(name) {
        None | Some(Value::Null) => Ok(None),
        Some(Value::String(text)) => Ok(Some(text)),
        Some(other) => bail!("{name} must be a text, but is {other}"),
    }
}

/// Takes a flag out of the arguments.
fn is_set(given: &mut Map<String, Value>, name: &str) -> anyhow::Result<bool> {
    match given.remove(name) {
        None | Some(Value::Null) => Ok(false),
        Some(Value::Bool(flag)) => Ok(flag),
        Some(other) => bail!("{name} must be true or false, but is {other}"),
    }
}

fn document(document: &impl Serialize) -> anyhow::Result<Value> {
    Ok(serde_json::to_value(document)?)
}
