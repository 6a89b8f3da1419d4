//! Joins the reports and plans of several bodies into one for the mesh that contains them.

use std::collections::HashMap;

use super::report::{FairObject, FairReport, FillReport, InputReport, RestoreReport};
use super::{FairPlan, FillPlan, Inspection, RestorePlan};
use crate::mesh::{Defects, Hole, HoleId};

/// The numbers that the vertices and holes of a body have in the mesh that contains it.
pub struct BodyNumbers {
    /// For each vertex of the body, its number in the whole.
    pub vertices: Vec<u32>,
    /// For each hole of the body, its number in the whole.
    pub holes: HashMap<HoleId, HoleId>,
    /// The name of the body.
    name: String,
}

/// The holes of a mesh by their rims.
pub struct HolesByRim(HashMap<Vec<u32>, HoleId>);

impl HolesByRim {
    pub fn new(whole: &Inspection) -> Self {
        let known = whole.holes.iter();
        Self(known.map(|h| (key(h.rim.iter().copied()), h.id)).collect())
    }
}

/// The vertices of a rim in ascending order.
fn key(rim: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut rim: Vec<u32> = rim.collect();
    rim.sort_unstable();
    rim
}

impl BodyNumbers {
    /// The numbers of a body with this name: holes with the same rim vertices are the same.
    pub fn new(whole: &HolesByRim, body: &Inspection, vertices: &[u32], name: &str) -> Self {
        let in_whole = |hole: &Hole| {
            let rim = hole.rim.iter().map(|v| vertices[*v as usize]);
            Some((hole.id, *whole.0.get(&key(rim))?))
        };
        Self {
            vertices: vertices.to_vec(),
            holes: body.holes.iter().filter_map(in_whole).collect(),
            name: name.to_owned(),
        }
    }
}

/// Renumbers the holes and regions of one body after the other.
struct Joining {
    numbers: BodyNumbers,
    /// The number of the next hole that only a body's report has.
    next: usize,
    /// The largest number of a region of the bodies before.
    regions: usize,
    /// Number of components of the bodies before.
    components: usize,
}

impl Joining {
    /// Holes that are not in the whole mesh are numbered from `next`.
    fn new(next: usize) -> Self {
        Self {
            numbers: BodyNumbers {
                vertices: Vec::new(),
                holes: HashMap::new(),
                name: String::new(),
            },
            next,
            regions: 0,
            components: 0,
        }
    }

    /// Renumbers the holes, each with its region, and the regions of the next body, which has this many components.
    fn body<'a>(
        &mut self,
        numbers: BodyNumbers,
        components: usize,
        holes: impl Iterator<Item = (&'a mut Hole, &'a mut usize)>,
        regions: impl Iterator<Item = (&'a mut usize, &'a mut Vec<HoleId>)>,
    ) {
        self.numbers = numbers;
        holes.for_each(|(hole, region)| self.hole(hole, region));
        let mut last = self.regions;
        for (id, holes) in regions {
            self.region(id, holes);
            last = last.max(*id);
        }
        self.regions = last;
        self.components += components;
    }

    fn number(&mut self, id: &mut HoleId) {
        let next = &mut self.next;
        *id = *self.numbers.holes.entry(*id).or_insert_with(|| {
            *next += 1;
            HoleId(*next - 1)
        });
    }

    fn hole(&mut self, hole: &mut Hole, region: &mut usize) {
        self.number(&mut hole.id);
        let vertices = &self.numbers.vertices;
        let rim = hole.rim.iter_mut();
        rim.for_each(|v| *v = vertices.get(*v as usize).copied().unwrap_or(*v));
        hole.component += self.components as u32;
        hole.object = Some(self.numbers.name.clone());
        if *region > 0 {
            *region += self.regions;
        }
    }

    fn region(&mut self, id: &mut usize, holes: &mut [HoleId]) {
        *id += self.regions;
        holes.iter_mut().for_each(|id| self.number(id));
    }
}

impl InputReport {
    /// Adds the report on another body.
    fn add(&mut self, own: Self) {
        self.vertices += own.vertices;
        self.faces += own.faces;
        self.components += own.components;
        add_defects(&mut self.defects, &own.defects);
        self.open_chains.extend(own.open_chains);
    }
}

fn add_defects(sum: &mut Defects, own: &Defects) {
    sum.degenerate_faces += own.degenerate_faces;
    sum.non_manifold_edges += own.non_manifold_edges;
    sum.misoriented_edges += own.misoriented_edges;
    sum.non_manifold_boundary_vertices += own.non_manifold_boundary_vertices;
    sum.duplicate_vertices += own.duplicate_vertices;
    sum.small_components += own.small_components;
    sum.reoriented_faces += own.reoriented_faces;
}

impl FillReport {
    /// Joins the reports on bodies. Holes that are not in the whole mesh are numbered from `next`.
    pub fn of_bodies(parts: Vec<(Self, BodyNumbers)>, next: usize) -> Self {
        let mut all = Self {
            all_holes: parts.iter().all(|(r, _)| r.all_holes),
            ..Self::default()
        };
        let mut joining = Joining::new(next);
        for (mut own, numbers) in parts {
            let holes = own.holes.iter_mut().map(|h| (&mut h.hole, &mut h.region));
            let regions = own.regions.iter_mut().map(|r| (&mut r.id, &mut r.holes));
            joining.body(numbers, own.input.components, holes, regions);
            all.holes.extend(own.holes);
            all.regions.extend(own.regions);
            all.input.add(own.input);
            all.seconds += own.seconds;
        }
        all.holes.sort_by_key(|h| h.hole.id);
        all
    }
}

impl RestoreReport {
    /// Numbers the joined holes of a body as in the mesh that contains it.
    pub fn number_in_whole(&mut self, numbers: &BodyNumbers) {
        for id in &mut self.joined_holes {
            *id = numbers.holes.get(id).copied().unwrap_or(*id);
        }
    }

    /// Joins the reports of bodies.
    pub fn of_bodies(reports: Vec<Self>) -> Self {
        let mut all = Self::default();
        for own in reports {
            all.marked_faces += own.marked_faces;
            all.removed_faces += own.removed_faces;
            all.removed_vertices += own.removed_vertices;
            all.joined_holes.extend(own.joined_holes);
            all.keep_shape = own.keep_shape;
        }
        all
    }
}

impl FairReport {
    /// Joins the reports of bodies, which have names.
    pub fn of_bodies(bodies: Vec<(String, Self)>) -> Self {
        let mut all = Self {
            whole: bodies.iter().all(|(_, own)| own.whole),
            volume_before: Some(0.0),
            volume_after: Some(0.0),
            ..Self::default()
        };
        let sum = |a: Option<f64>, b: Option<f64>| Some(a? + b?);
        let (mut squares, mut points) = (0.0, 0);
        for (_, own) in &bodies {
            // Strength, time and voxel are the largest of a body.
            all.strength = all.strength.max(own.strength);
            all.time = all.time.max(own.time);
            all.voxel = all.voxel.max(own.voxel);
            all.marked_faces += own.marked_faces;
            all.removed_faces += own.removed_faces;
            all.removed_vertices += own.removed_vertices;
            all.components_left += own.components_left;
            all.volume_before = sum(all.volume_before, own.volume_before);
            all.volume_after = sum(all.volume_after, own.volume_after);
            all.moved_max = all.moved_max.max(own.moved_max);
            squares += own.moved_rms.powi(2) * own.moved_points as f64;
            points += own.moved_points;
        }
        all.moved_rms = (squares / points.max(1) as f64).sqrt();
        all.moved_points = points;
        let objects = bodies.into_iter();
        let objects = objects.map(|(name, report)| FairObject { name, report });
        all.objects = objects.collect();
        all
    }
}

impl FairPlan {
    /// Joins the plans for bodies. Strength, time and voxel are the largest of a body.
    pub fn of_bodies(plans: &[Self]) -> Self {
        let sum = |count: fn(&Self) -> usize| plans.iter().map(count).sum();
        let largest = |of: fn(&Self) -> f64| plans.iter().map(of).fold(0.0, f64::max);
        Self {
            strength: largest(|p| p.strength),
            time: largest(|p| p.time),
            voxel: largest(|p| p.voxel),
            whole: plans.iter().all(|p| p.whole),
            marked_faces: sum(|p| p.marked_faces),
            removed_faces: sum(|p| p.removed_faces),
            removed_vertices: sum(|p| p.removed_vertices),
            components_left: sum(|p| p.components_left),
            kept_objects: Vec::new(),
        }
    }
}

impl FillPlan {
    /// The plan for a mesh that is left as it is.
    pub fn nothing(found: &Inspection) -> Self {
        Self {
            input: InputReport::of(found),
            ..Self::default()
        }
    }

    /// Joins the plans for bodies. Holes that are not in the whole mesh are numbered from `next`.
    pub fn of_bodies(parts: Vec<(Self, BodyNumbers)>, next: usize) -> Self {
        let mut all = Self::default();
        let mut joining = Joining::new(next);
        for (mut own, numbers) in parts {
            let holes = own.holes.iter_mut().map(|h| (&mut h.hole, &mut h.region));
            let regions = own.regions.iter_mut().map(|r| (&mut r.id, &mut r.holes));
            joining.body(numbers, own.input.components, holes, regions);
            all.holes.extend(own.holes);
            all.regions.extend(own.regions);
            all.input.add(own.input);
        }
        all.holes.sort_by_key(|h| h.hole.id);
        all
    }
}

impl RestorePlan {
    /// Joins the cuts of bodies, with the joined plan of the fill.
    pub fn of_bodies(cuts: Vec<RestoreReport>, fill: FillPlan) -> Self {
        Self {
            cut: RestoreReport::of_bodies(cuts),
            fill,
        }
    }
}
