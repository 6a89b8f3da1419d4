//! The inspection of a mesh (holes, defects, crease ends), and its regions as tasks that other processes can solve.

use std::sync::Arc;

use isomend::io::Loaded;
use isomend::job::{self, Drawings, Place, Source, Unchanged};
use isomend::{Control, CreaseEnd, Inspection, RegionPatch, RegionTask};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::drawings::call;
use crate::errors::Failure;
use crate::mended::Mended;
use crate::packed::{json_of, packed, unpacked};
use crate::spec::{fill_params, spec, with_template, work};
use crate::worker;

/// The inspection of a mesh, with the mesh.
#[derive(Clone)]
#[pyclass(frozen, module = "isomend._isomend")]
pub struct Found {
    loaded: Arc<Loaded>,
    source: Place,
    found: Arc<Inspection<'static>>,
    crease_ends: Arc<Vec<CreaseEnd>>,
    document: String,
}

impl Found {
    /// Inspects a mesh.
    pub fn new(loaded: Arc<Loaded>, source: Place, control: &Control) -> Result<Self, Failure> {
        let read = Source::mesh(source.clone(), loaded.clone());
        let inspected = job::inspect(&read, &loaded, None, None, &Drawings::default(), control)?;
        let document = json_of(&inspected.document())?;
        let crease_ends = Arc::new(inspected.crease_ends);
        let found = Arc::new(inspected.found.into_owned());
        Ok(Self {
            loaded,
            source,
            found,
            crease_ends,
            document,
        })
    }
}

impl Found {
    /// What a page or a picture shows.
    fn drawn<'a>(&'a self) -> Unchanged<'a> {
        Unchanged {
            place: &self.source,
            loaded: &self.loaded,
            found: &self.found,
            crease_ends: &self.crease_ends,
            verdict: None,
            unit: None,
        }
    }
}

#[pymethods]
impl Found {
    fn document(&self) -> &str {
        &self.document
    }

    /// The HTML page that `isomend inspect --report` writes.
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let seen = self.clone();
        worker::run(py, None, None, move |_| {
            Ok(seen.drawn().page(&call("inspect")))
        })
    }

    /// The PNG file that `isomend inspect --picture` writes.
    fn picture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let seen = self.clone();
        let bytes = worker::run(py, None, None, move |_| Ok(seen.drawn().picture()?))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The vertex indices of each hole's rim, in order along the rim.
    fn rims<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyArray1<i64>>> {
        let holes = self.found.holes.iter();
        let rim = |rim: &[u32]| rim.iter().map(|v| i64::from(*v)).collect();
        holes.map(|h| PyArray1::from_vec(py, rim(&h.rim))).collect()
    }

    /// Does the work that the JSON describes, such as `{"fill": {}}`.
    #[pyo3(signature = (json, threads, progress))]
    fn mend(
        &self,
        py: Python<'_>,
        json: &str,
        threads: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Mended> {
        let spec = spec(&self.source, work(json)?);
        let (loaded, found) = (self.loaded.clone(), self.found.clone());
        worker::run(py, threads, progress, move |control| {
            spec.work.check()?;
            let read = spec.with(loaded);
            let mended = read.mend_found(&found, control)?.into_owned();
            Ok(Mended::new(mended.judged()?))
        })
    }

    /// The number of regions of a fill with these parameters (JSON).
    fn region_count(&self, params: &str) -> PyResult<usize> {
        let params = fill_params(params)?;
        let regions = self.found.regions(&params).map_err(Failure::from)?;
        Ok(regions.len())
    }

    /// Calls a function with each region's task as bytes, in the order of the regions.
    fn each_task(&self, params: &str, take: &Bound<'_, PyAny>) -> PyResult<()> {
        let py = take.py();
        let params = fill_params(params)?;
        let regions = self.found.regions(&params).map_err(Failure::from)?;
        let mut tasks = regions.tasks().map(|task| packed(&task));
        while let Some(bytes) = py.detach(|| tasks.next()) {
            py.check_signals()?;
            take.call1((PyBytes::new(py, &bytes?),))?;
        }
        Ok(())
    }

    /// The task of one region (its index, from 0) as bytes, with the largest part of the mesh that the region may use.
    fn wide_task<'py>(
        &self,
        py: Python<'py>,
        params: &str,
        region: usize,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let params = fill_params(params)?;
        let regions = self.found.regions(&params).map_err(Failure::from)?;
        let task = py.detach(|| regions.wide_task(region)).ok_or_else(|| {
            let count = regions.len();
            Failure::parameter(format!(
                "there is no region {region} of {count}, counted from 0"
            ))
        })?;
        Ok(PyBytes::new(py, &packed(&task)?))
    }

    /// Joins the patches of all regions, in the order of the regions, to the mesh.
    fn assemble(&self, py: Python<'_>, json: &str, patches: Vec<Vec<u8>>) -> PyResult<Mended> {
        let spec = spec(&self.source, work(json)?);
        let (loaded, found) = (self.loaded.clone(), self.found.clone());
        worker::run(py, None, None, move |_| {
            let isomend::job::Work::Fill(params) = &spec.work else {
                return Err(Failure::parameter(
                    "only the patches of a fill can be assembled",
                ));
            };
            let params = with_template(params.clone())?;
            let regions = found.regions(&params)?;
            let patch = |bytes: &Vec<u8>| unpacked::<RegionPatch>(bytes, "patch");
            let patches = patches.iter().map(patch).collect::<Result<_, _>>()?;
            let filled = regions.assemble(patches)?;
            let mended = spec.with(loaded).filled(filled);
            Ok(Mended::new(mended.into_owned()))
        })
    }
}

/// Solves the task of a region; returns its patch as bytes.
#[pyfunction]
#[pyo3(signature = (task, threads))]
pub fn solve_task<'py>(
    py: Python<'py>,
    task: &[u8],
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyBytes>> {
    let task = task.to_vec();
    let patch = worker::run(py, threads, None, move |control| {
        let task: RegionTask = unpacked(&task, "task")?;
        packed(&task.solve(control)?)
    })?;
    Ok(PyBytes::new(py, &patch))
}

/// Whether a region needed more of the mesh than its task contains; `patch` is the result of `solve_task`.
#[pyfunction]
pub fn is_cramped(patch: &[u8]) -> PyResult<bool> {
    Ok(unpacked::<RegionPatch>(patch, "patch")?.is_cramped())
}
