//! Segmentation of a collar into smooth sides by region growing.

use glam::DVec3;
use rustc_hash::FxHashSet;

use super::collar::{Collar, median};
use super::sheet::Sheet;
use crate::elementary::cos;
use crate::tuning::{Tunable, tunable};

/// A region is seeded at a face where smoothed normals within two rings differ by less than this, in 1 − cos.
const CALM: Tunable<f64> = tunable("creases.segment.calm", 0.1);
/// Neighbours join the seed region if their normals have at least this cosine with the first face's.
const SIMILAR: Tunable<f64> = tunable("creases.segment.similar", 0.93);
/// Minimum number of faces of a region.
const FEWEST: Tunable<usize> = tunable("creases.segment.fewest", 6);
/// A face joins a region if its corners are closer to the sheet than this, in edges,
const NEAR: Tunable<f64> = tunable("creases.segment.near", 0.15);
/// and its normal is within this angle of the sheet's normal, in degrees.
const TURNED: Tunable<f64> = tunable("creases.segment.turned", 20.0);
/// Maximum number of rounds; in each a region grows by up to two rings and its sheet is refitted.
const ROUNDS: Tunable<usize> = tunable("creases.segment.rounds", 25);
/// The outermost ring of a region, which may be a bevel, is removed; then faces of it return if their corners are closer than
/// this multiple of 1.5 times the median distance of the rest.
const TAKE_BACK: Tunable<f64> = tunable("creases.segment.take_back", 3.5);
/// Minimum number of faces that must remain without the outermost ring,
const FEWEST_OF_CORE: Tunable<usize> = tunable("creases.segment.fewest_of_core", 8);
/// and their minimum fraction of the region's faces.
const CORE: Tunable<f64> = tunable("creases.segment.core", 0.25);
/// Two regions are joined if their joint residual is less than this times the larger of their own.
const JOINT: Tunable<f64> = tunable("creases.segment.joint", 1.6);
/// Number of points of a region that are sampled to test whether it is off the sheet of another.
const SOME: Tunable<usize> = tunable("creases.segment.some", 48);
/// The sheets of a mesh are exact if their median residual is below this, in edges.
const EXACT: Tunable<f64> = tunable("creases.segment.exact", 0.02);
/// Minimum number of coplanar faces of an exact mesh that form a sheet though they are too few for a region,
const FEWEST_OF_FACET: Tunable<usize> = tunable("creases.segment.fewest_of_facet", 4);
/// and the maximum residual of that sheet, in edges.
const EXACT_FACET: Tunable<f64> = tunable("creases.segment.exact_facet", 0.003);
/// Minimum cosine of these faces' normals with the first face's.
const COPLANAR: Tunable<f64> = tunable("creases.segment.coplanar", 0.998);
/// Maximum number of sides that are found: beyond it, testing which of them are one takes seconds, and between more no creases were ever
/// continued (at most 36 around a rim of the benchmarks).
const MOST_SIDES: usize = 512;
/// Marks a face on no side.
const NONE: usize = usize::MAX;

/// A smooth side: faces of the collar in rising order, and the sheet that continues them.
pub(super) struct Side {
    pub(super) faces: Vec<usize>,
    pub(super) sheet: Sheet,
}

/// The smooth sides of a collar.
pub(super) struct Sides {
    pub(super) list: Vec<Side>,
    /// The side of each face of the collar; `usize::MAX` for none.
    pub(super) of_face: Vec<usize>,
}

impl Sides {
    /// Grows regions from the flattest faces, adds exact facets, and joins regions on the same sheet; `None` if there are too many.
    pub(super) fn new(collar: &Collar) -> Option<Self> {
        let mut growth = Growth {
            collar,
            of_face: vec![NONE; collar.len()],
            list: Vec::new(),
        };
        let variation = collar.variation();
        let mut order: Vec<usize> = (0..collar.len()).collect();
        order.sort_by(|a, b| variation[*a].total_cmp(&variation[*b]));
        for &first in &order {
            if variation[first] > CALM.get() || collar.cancel.is_cancelled() {
                break;
            }
            (growth.list.len() <= MOST_SIDES).then_some(())?;
            if growth.of_face[first] == NONE
                && let Some(side) = growth.region(first)
            {
                growth.add(side);
            }
        }
        growth.add_facets(&order);
        (growth.list.len() <= MOST_SIDES).then_some(())?;
        growth.join();
        Some(growth.finish())
    }

    /// Adds the kriged residuals of its vertices to the sheet of a side; returns whether there are any.
    pub(super) fn refine(&mut self, side: usize, collar: &Collar) -> bool {
        let side = &mut self.list[side];
        let points = collar.points_from_rim(&side.faces);
        side.sheet.refine(&points, collar.diameter, collar.edge)
    }

    /// Median residual of the sheets, in edges.
    pub(super) fn noise(&self, edge: f64) -> f64 {
        match self.list.is_empty() {
            true => 1.0,
            false => median_residual(&self.list) / edge,
        }
    }

    /// Fraction of the faces that are on no sheet.
    pub(super) fn free(&self) -> f64 {
        let free = self.of_face.iter().filter(|s| **s == NONE).count();
        free as f64 / self.of_face.len().max(1) as f64
    }
}

fn median_residual(list: &[Side]) -> f64 {
    let mut residuals: Vec<f64> = list.iter().map(|s| s.sheet.residual).collect();
    median(&mut residuals)
}

impl Collar {
    /// For each face, the largest difference of smoothed normals within two rings from its own, in 1 − cos; 9 if there are fewer
    /// than four.
    pub(super) fn variation(&self) -> Vec<f64> {
        let of = |f: usize| {
            let mut near: Vec<usize> = self.across(f).collect();
            let further: Vec<usize> = near.iter().flat_map(|&g| self.across(g)).collect();
            near.extend(further);
            near.sort_unstable();
            near.dedup();
            if near.len() < 4 {
                return 9.0;
            }
            let own = self.smoothed[f];
            let differences = near.iter().map(|&g| 1.0 - self.smoothed[g].dot(own));
            differences.fold(f64::NEG_INFINITY, f64::max)
        };
        (0..self.len()).map(of).collect()
    }

    /// Fits a sheet to the vertices of some faces.
    fn fit(&self, faces: &[usize]) -> Sheet {
        let (points, normals) = self.vertices(faces);
        Sheet::fit(points, normals, self.diameter, self.edge)
    }

    /// Largest distance of a corner of a face from a sheet.
    fn off(&self, face: usize, sheet: &Sheet) -> f64 {
        let off = self.corners(face).map(|p| sheet.distance(p).abs());
        off.into_iter().fold(0.0, f64::max)
    }
}

/// Pairs of regions that are on two sheets.
struct KnownPairs {
    /// How often each region grew: a pair is not tested again until one of them does.
    version: Vec<u32>,
    apart: FxHashSet<(usize, usize, u32, u32)>,
}

/// Growing regions.
struct Growth<'a> {
    collar: &'a Collar,
    of_face: Vec<usize>,
    list: Vec<Side>,
}

impl Growth<'_> {
    fn add(&mut self, side: Side) {
        side.faces
            .iter()
            .for_each(|&f| self.of_face[f] = self.list.len());
        self.list.push(side);
    }

    /// Grows a region from a face; `None` if it stays too small.
    fn region(&self, first: usize) -> Option<Side> {
        let collar = self.collar;
        let normal = collar.smoothed[first];
        let mut faces = Region::new(collar.len(), &[first]);
        for _ in 0..2 {
            for f in self.front(&faces) {
                if collar.smoothed[f].dot(normal) > SIMILAR.get() {
                    faces.insert(f);
                }
            }
        }
        (faces.list.len() >= FEWEST.get()).then_some(())?;
        let mut sheet = collar.fit(&faces.sorted());
        let mut off = Distances::new(collar);
        // Alternates growing by up to two rings with fitting the sheet, until the region no longer changes.
        for _ in 0..ROUNDS.get() {
            if collar.cancel.is_cancelled() {
                break;
            }
            off.forget();
            let mut grown = faces.clone();
            for _ in 0..2 {
                for f in self.front(&grown) {
                    if self.fits(f, &sheet, &mut off) {
                        grown.insert(f);
                    }
                }
            }
            grown.retain(|f| self.fits(f, &sheet, &mut off));
            if grown.list.len() < FEWEST.get() || grown.is_in == faces.is_in {
                break;
            }
            faces = grown;
            sheet = collar.fit(&faces.sorted());
        }
        let sheet = self.without_bevel(&faces).unwrap_or(sheet);
        Some(Side {
            faces: faces.sorted(),
            sheet,
        })
    }

    /// The sheet of a region without outermost faces that are off the rest; `None` if too few faces would remain.
    fn without_bevel(&self, faces: &Region) -> Option<Sheet> {
        let collar = self.collar;
        let sorted = faces.sorted();
        let is_core = |f: &usize| collar.across(*f).all(|g| faces.is_in[g]);
        let core: Vec<usize> = sorted.iter().copied().filter(is_core).collect();
        let fewest = f64::max(
            FEWEST_OF_CORE.get() as f64,
            CORE.get() * sorted.len() as f64,
        );
        (core.len() as f64 >= fewest).then_some(())?;
        let sheet = collar.fit(&core);
        let mut distances: Vec<f64> = sheet
            .points
            .iter()
            .map(|p| sheet.distance(*p).abs())
            .collect();
        let spread = (1.5 * median(&mut distances)).max(1e-6 * collar.edge);
        let stays = |f: &usize| is_core(f) || collar.off(*f, &sheet) < TAKE_BACK.get() * spread;
        let stay: Vec<usize> = sorted.iter().copied().filter(stays).collect();
        Some(collar.fit(&stay))
    }

    /// Whether a face is close enough to a sheet, in position and normal.
    fn fits(&self, face: usize, sheet: &Sheet, off: &mut Distances) -> bool {
        let most = NEAR.get() * self.collar.edge;
        let is_near = |v: u32| off.of(v, || sheet.distance(self.collar.position(v)).abs()) < most;
        self.collar.corners_of(face as u32).into_iter().all(is_near)
            && sheet
                .normal(self.collar.middle(face))
                .dot(self.collar.smoothed[face])
                > cos(TURNED.get().to_radians())
    }

    /// Faces across the edges of a region that are in no region, in rising order.
    fn front(&self, faces: &Region) -> Vec<usize> {
        let across = faces.list.iter().flat_map(|&f| self.collar.across(f));
        let mut front: Vec<usize> = across
            .filter(|&g| self.of_face[g] == NONE && !faces.is_in[g])
            .collect();
        front.sort_unstable();
        front.dedup();
        front
    }

    /// On exact meshes: adds coplanar faces that seeded no region, for example the narrow side of a thin wall.
    fn add_facets(&mut self, order: &[usize]) {
        let collar = self.collar;
        if self.list.is_empty() || median_residual(&self.list) >= EXACT.get() * collar.edge {
            return;
        }
        for &first in order {
            if self.of_face[first] != NONE {
                continue;
            }
            let normal = collar.normals[first];
            let mut faces = Region::new(collar.len(), &[first]);
            let mut at = 0;
            while let Some(&f) = faces.list.get(at) {
                for g in collar.across(f) {
                    if self.of_face[g] == NONE && collar.normals[g].dot(normal) > COPLANAR.get() {
                        faces.insert(g);
                    }
                }
                at += 1;
            }
            if faces.list.len() < FEWEST_OF_FACET.get() {
                continue;
            }
            let faces = faces.sorted();
            let (points, normals) = collar.vertices(&faces);
            let sheet = Sheet::plane(points, normals, collar.diameter);
            if sheet.residual < EXACT_FACET.get() * collar.edge {
                self.add(Side { faces, sheet });
            }
        }
    }

    /// Joins regions that are on one sheet.
    fn join(&mut self) {
        // Rows before `i` are done, but for the pairs of a region that has grown since.
        let mut known = KnownPairs {
            version: vec![0; self.list.len()],
            apart: FxHashSet::default(),
        };
        let mut i = 0;
        while i < self.list.len() {
            if self.list[i].faces.is_empty() || self.collar.cancel.is_cancelled() {
                i += 1;
                continue;
            }
            let after = (i + 1..self.list.len()).find(|&j| self.joins(i, j, &mut known));
            if after.is_none() {
                i += 1;
                continue;
            }
            // Of the earlier pairs only the grown region's may have become joint.
            while let Some(k) = (0..i).find(|&k| self.joins(k, i, &mut known)) {
                i = k;
            }
        }
        self.list.retain(|side| !side.faces.is_empty());
    }

    /// Joins the second region to the first if both have faces and are on one sheet; returns whether it did. The second keeps its index,
    /// without faces, so that other indices stay valid.
    fn joins(&mut self, i: usize, j: usize, known: &mut KnownPairs) -> bool {
        let has_faces = |k: usize| !self.list[k].faces.is_empty();
        let key = (i, j, known.version[i], known.version[j]);
        if !has_faces(i) || !has_faces(j) || known.apart.contains(&key) {
            return false;
        }
        let Some(sheet) = self.joint(&self.list[i].sheet, &self.list[j].sheet) else {
            known.apart.insert(key);
            return false;
        };
        let other = std::mem::take(&mut self.list[j].faces);
        let faces = &mut self.list[i].faces;
        faces.extend(other);
        faces.sort_unstable();
        self.list[i].sheet = sheet;
        known.version[i] += 1;
        true
    }

    /// The joint sheet of two regions, if they are on one sheet.
    fn joint(&self, a: &Sheet, b: &Sheet) -> Option<Sheet> {
        let collar = self.collar;
        let is_off = |sheet: &Sheet, of: &Sheet| {
            let some = of
                .points
                .iter()
                .step_by(of.points.len().div_ceil(SOME.get()).max(1));
            let far = |p: &&DVec3| sheet.distance(**p).abs() > 0.5 * collar.edge;
            2 * some.clone().filter(far).count() > some.count()
        };
        if is_off(a, b) && is_off(b, a) {
            return None;
        }
        let points = [&a.points[..], &b.points[..]].concat();
        let normals = [&a.normals[..], &b.normals[..]].concat();
        let sheet = Sheet::fit(points, normals, collar.diameter, collar.edge);
        let larger = a.residual.max(b.residual).max(1e-4 * collar.edge);
        let pairs = sheet.points.iter().zip(&sheet.normals);
        let agree = pairs
            .filter(|(p, n)| sheet.normal(**p).dot(**n) > 0.8)
            .count();
        let is_one = sheet.residual < JOINT.get() * larger
            && agree as f64 > 0.95 * sheet.points.len() as f64;
        is_one.then_some(sheet)
    }

    fn finish(mut self) -> Sides {
        self.of_face.fill(NONE);
        for (i, side) in self.list.iter().enumerate() {
            side.faces.iter().for_each(|&f| self.of_face[f] = i);
        }
        Sides {
            list: self.list,
            of_face: self.of_face,
        }
    }
}

/// Distances of vertices from a sheet, computed on demand.
struct Distances {
    /// NaN if not yet computed.
    of_vertex: Vec<f64>,
    known: Vec<u32>,
}

impl Distances {
    fn new(collar: &Collar) -> Self {
        Self {
            of_vertex: vec![f64::NAN; collar.vertex_count()],
            known: Vec::new(),
        }
    }

    /// The distance of a vertex, computed by `distance` if not yet known.
    fn of(&mut self, vertex: u32, distance: impl FnOnce() -> f64) -> f64 {
        let known = &mut self.of_vertex[vertex as usize];
        if known.is_nan() {
            *known = distance();
            self.known.push(vertex);
        }
        *known
    }

    /// Forgets all distances when the sheet changes.
    fn forget(&mut self) {
        for v in self.known.drain(..) {
            self.of_vertex[v as usize] = f64::NAN;
        }
    }
}

/// A set of faces of the collar.
#[derive(Clone)]
struct Region {
    is_in: Vec<bool>,
    list: Vec<usize>,
}

impl Region {
    fn new(count: usize, faces: &[usize]) -> Self {
        let mut region = Self {
            is_in: vec![false; count],
            list: Vec::new(),
        };
        faces.iter().for_each(|&f| region.insert(f));
        region
    }

    fn insert(&mut self, face: usize) {
        if !std::mem::replace(&mut self.is_in[face], true) {
            self.list.push(face);
        }
    }

    fn retain(&mut self, mut keeps: impl FnMut(usize) -> bool) {
        let is_in = &mut self.is_in;
        self.list.retain(|&f| {
            is_in[f] = keeps(f);
            is_in[f]
        });
    }

    fn sorted(&self) -> Vec<usize> {
        let mut sorted = self.list.clone();
        sorted.sort_unstable();
        sorted
    }
}
