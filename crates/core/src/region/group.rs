//! Groups holes that are filled together, and chooses the voxel size and the box of their lattice.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::elementary::log2;
use crate::grid::{Lattice, NodeIndex};
use crate::mesh::{DisjointSets, Hole, Mesh, bounds};
use crate::spatial::{Bounds, BoxTree};
use crate::tuning::{Tunable, tunable};

/// Diameters of the larger rim. Rims that face each other belong to one opening up to this gap.
const FACING_GAP: Tunable<f64> = tunable("region.facing_gap", 1.0);

/// Diameters of the smaller rim. Rims closer than this share a region.
const NEAR_GAP: Tunable<f64> = tunable("region.near_gap", 0.1);

/// Rims. Upper bound of the larger rims that a rim is compared with. In a mesh of loose triangles all rims are near all
/// others; in scans a rim has a few neighbours.
const MOST_NEARBY: Tunable<usize> = tunable("region.most_nearby", 128);

/// Edge midpoints of each rim that are compared, at most.
const RIM_SAMPLES: Tunable<usize> = tunable("region.rim_samples", 240);

/// Voxels across a hole.
const ACROSS: Tunable<f64> = tunable("region.across", 32.0);

/// Voxels across a hole where the patch is finished on its own triangles. On 143 holes of scans finished patches with 12
/// and a margin of 6 nodes were 1.3 % farther from the true surface, with 24 and more no closer.
const ACROSS_COARSE: Tunable<f64> = tunable("region.across_coarse", 16.0);

/// Edges. A single rim of at most this many edges is simple: its patch has about fifty vertices, for which coarser voxels
/// suffice.
const SHORT_RIM: Tunable<usize> = tunable("region.short_rim", 25);

/// Edges. A single rim of at most this many edges is simple if the surface around it bends little.
const MEDIUM_RIM: Tunable<usize> = tunable("region.medium_rim", 60);

/// Sine of the angle between the surface around a hole and the plane of its rim. Up to this angle the surface bends little.
/// Patches that bend more had other, wrong shapes with coarser voxels, with seams three times as sharp.
const SLIGHT_TILT: Tunable<f64> = tunable("region.slight_tilt", 0.5);

/// Voxels across a hole with a simple rim whose patch is finished. On 99 holes of scans with at most 60 edges patches were
/// as close to the true surface as with 16 and a margin of 7 nodes; with 8 or 12 they were 1 % farther from it.
const ACROSS_SIMPLE: Tunable<f64> = tunable("region.across_simple", 10.0);

/// Ratio of diameter to width. Slots are resolved across their width up to this ratio; where the patch is finished,
/// across the geometric mean of both: on 143 holes of scans that gave patches as close to the true surface in three
/// quarters of the time.
const NARROWEST: Tunable<f64> = tunable("region.narrowest", 2.0);

/// Voxels across a hole on the coarsest level.
const COARSEST: Tunable<f64> = tunable("region.coarsest", 16.0);

/// Voxels across the smallest loop of a region of several loops, at least.
const ACROSS_SMALLEST: Tunable<f64> = tunable("region.across_smallest", 14.0);

/// Voxels across a hole in a finer retry, at most, unless the first attempt had more.
const ACROSS_RETRY: Tunable<f64> = tunable("region.across_retry", 72.0);

/// Voxels across a hole where the voxel is chosen automatically, at most.
const ACROSS_LIMIT: Tunable<f64> = tunable("region.across_limit", 160.0);

/// Voxels across a hole where the voxel is given, at most.
const FINEST: Tunable<f64> = tunable("region.finest", 1024.0);

/// Widths of the widest hole. Free space around the rims.
const MARGIN_PART: Tunable<f64> = tunable("region.margin_part", 0.5);

/// Coarse voxels. Free space around the rims in addition to `MARGIN_PART`.
const MARGIN_NODES: Tunable<f64> = tunable("region.margin_nodes", 7.0);

/// The same for a simple rim whose patch is finished. With 4 patches were 1 % farther from the true surface.
const MARGIN_SIMPLE: Tunable<f64> = tunable("region.margin_simple", 5.0);

/// Blocks of nodes in a box on its coarsest level, at most: 16 million nodes. The box of a hole has about 1300, the box
/// of facing rims a few diameters apart up to 1e5.
const MOST_BLOCKS: Tunable<f64> = tunable("region.most_blocks", 2.5e5);

/// Blocks of nodes in a box on its coarsest level. Above this, four times the count of a round hole, the box gets a
/// coarser level if the hole is wide enough there.
const MANY_BLOCKS: Tunable<f64> = tunable("region.many_blocks", 5000.0);

/// Extents of the rims along an axis. The margin of `MARGIN_PART` is reduced by this along that axis.
const MARGIN_TAKEN: Tunable<f64> = tunable("region.margin_taken", 0.35);

/// Widths of the widest hole. Lower bound of the margin.
const LEAST_MARGIN: Tunable<f64> = tunable("region.least_margin", 0.15);

/// The voxel size of a region.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum VoxelSize {
    /// Chosen from the hole. With a finish: 16 voxels across the hole, 10 where its rim has at most 25 edges, or at most 60 and the
    /// surface bends little around it, more where it is a slot, up to 96 where a region has a small loop. Without a finish: 32
    /// voxels, up to 64 where the rim is finer or the hole is a slot. With the curvature-variation energy 2.5 times as many, at most 128.
    #[default]
    Auto,
    /// A length in the mesh's units; at least 1/1024 of the widest hole, at most its diameter. Holes narrower than the length get an
    /// automatic voxel.
    Length(f64),
}

/// A length in the mesh's units.
impl From<f64> for VoxelSize {
    fn from(length: f64) -> Self {
        Self::Length(length)
    }
}

impl VoxelSize {
    /// The requested length.
    pub fn length(self) -> Option<f64> {
        match self {
            Self::Auto => None,
            Self::Length(length) => Some(length),
        }
    }
}

/// The lattice on which a group of holes is filled.
#[derive(Clone, Debug)]
pub struct Region {
    /// Largest diameter of its holes or of the given initial surface, in world units.
    pub diameter: f64,
    /// Voxel size on the finest level, in world units.
    pub voxel: f64,
    /// Number of refinements from the coarsest level.
    pub refinements: usize,
    /// The coarsest lattice.
    pub lattice: Lattice,
    /// Its box, in nodes.
    pub dims: NodeIndex,
}

/// Groups holes that belong together: lists of indices into `holes`, each of `chosen` in exactly one, in the order of `chosen`.
///
/// Two rims belong together if they face each other (an island in a hole, or the two sides of a gap: their conormals, the
/// directions in which the surface continues, point at one another), if they nearly touch, or if the caller says so. Two rims for
/// which `is_small` holds belong together only if they touch: comparing all pairs of small components outside of holes would cost
/// too much.
pub fn group_holes(
    mesh: &Mesh,
    holes: &[Hole],
    chosen: &[usize],
    forced: &[Vec<usize>],
    is_small: &dyn Fn(usize) -> bool,
) -> Vec<Vec<usize>> {
    let mut sets = DisjointSets::new(holes.len());
    // Pairs to compare: large rims with all, small ones with large ones, each pair once.
    let rims: Vec<RimSamples> = chosen
        .iter()
        .map(|&h| RimSamples::new(mesh, &holes[h]))
        .collect();
    let (small, large): (Vec<usize>, Vec<usize>) =
        (0..chosen.len()).partition(|&i| is_small(chosen[i]));
    let all: Vec<usize> = (0..chosen.len()).collect();
    for (looking, among) in [(&large, &all), (&small, &large)] {
        let nearby = Nearby::new(&rims, among);
        for &i in looking {
            for j in nearby.larger(&rims, i) {
                let (first, second) = (i.min(j), i.max(j));
                let (a, b) = (chosen[i] as u32, chosen[j] as u32);
                let apart = sets.find(a) != sets.find(b);
                if apart && rims[first].belongs_with(&rims[second]) {
                    sets.join(a, b);
                }
            }
        }
    }
    in_sets(holes, chosen, forced, sets)
}

/// Groups only the holes that share a vertex, and those that the caller names.
pub fn group_named(holes: &[Hole], chosen: &[usize], forced: &[Vec<usize>]) -> Vec<Vec<usize>> {
    in_sets(holes, chosen, forced, DisjointSets::new(holes.len()))
}

/// The groups of holes of the same set, after loops that share a vertex and those that the caller names are joined.
fn in_sets(
    holes: &[Hole],
    chosen: &[usize],
    forced: &[Vec<usize>],
    mut sets: DisjointSets,
) -> Vec<Vec<usize>> {
    join_touching(holes, chosen, &mut sets);
    for group in forced {
        for pair in group.windows(2) {
            sets.join(pair[0] as u32, pair[1] as u32);
        }
    }
    // Lists of the sets, in the order of their first holes.
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut of_root = std::collections::BTreeMap::new();
    for &h in chosen {
        let root = sets.find(h as u32);
        let at = *of_root.entry(root).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[at].push(h);
    }
    groups
}

/// Search structure for rims that may belong together: each rim's bounding box, widened by its diameter on all sides.
struct Nearby<'a> {
    among: &'a [usize],
    tree: BoxTree,
}

impl<'a> Nearby<'a> {
    fn new(rims: &[RimSamples], among: &'a [usize]) -> Self {
        let wide = |&i: &usize| rims[i].bounds.widened(FACING_GAP.get() * rims[i].diameter);
        let boxes: Vec<Bounds> = among.iter().map(wide).collect();
        let tree = BoxTree::new(&boxes);
        Self { among, tree }
    }

    /// The rims larger than rim `i` that it may belong with; of too many the nearest, of equally near ones the smallest.
    fn larger(&self, rims: &[RimSamples], i: usize) -> Vec<usize> {
        let own = &rims[i];
        let mut found: Vec<(f64, f64, usize)> = Vec::new();
        self.tree.for_each(&own.bounds, |at| {
            let j = self.among[at as usize];
            let other = &rims[j];
            if (other.diameter, j) > (own.diameter, i) {
                found.push((own.bounds.gap(&other.bounds), other.diameter, j));
            }
        });
        let order = |a: &(f64, f64, usize), b: &(f64, f64, usize)| {
            a.0.total_cmp(&b.0)
                .then(a.1.total_cmp(&b.1))
                .then(a.2.cmp(&b.2))
        };
        if found.len() > MOST_NEARBY.get() {
            found.select_nth_unstable_by(MOST_NEARBY.get(), order);
            found.truncate(MOST_NEARBY.get());
        }
        found.into_iter().map(|(_, _, j)| j).collect()
    }
}

/// Joins loops that share a vertex.
fn join_touching(holes: &[Hole], chosen: &[usize], sets: &mut DisjointSets) {
    let mut users: Vec<(u32, usize)> = chosen
        .iter()
        .flat_map(|&h| holes[h].rim.iter().map(move |&v| (v, h)))
        .collect();
    users.sort_unstable();
    for pair in users.windows(2) {
        if pair[0].0 == pair[1].0 {
            sets.join(pair[0].1 as u32, pair[1].1 as u32);
        }
    }
}

/// Edge midpoints of a rim, with the conormals there.
struct RimSamples {
    points: Vec<(DVec3, DVec3)>,
    bounds: Bounds,
    diameter: f64,
}

impl RimSamples {
    fn new(mesh: &Mesh, hole: &Hole) -> Self {
        let n = hole.rim.len();
        let stride = n.div_ceil(RIM_SAMPLES.get());
        let points: Vec<(DVec3, DVec3)> = (0..n)
            .step_by(stride)
            .map(|i| {
                let a = mesh.positions[hole.rim[i] as usize];
                let b = mesh.positions[hole.rim[(i + 1) % n] as usize];
                (0.5 * (a + b), hole.conormals[i])
            })
            .collect();
        let (low, high) = bounds(points.iter().map(|p| p.0));
        Self {
            points,
            bounds: Bounds { low, high },
            diameter: hole.diameter,
        }
    }

    fn belongs_with(&self, other: &Self) -> bool {
        let larger = self.diameter.max(other.diameter);
        if self.bounds.gap(&other.bounds) > FACING_GAP.get() * larger {
            return false;
        }
        // For each sample of the rim with fewer samples, the nearest sample of the other rim.
        let (mut facing, mut nearest) = (0, f64::INFINITY);
        let (few, many) = if self.points.len() <= other.points.len() {
            (self, other)
        } else {
            (other, self)
        };
        for (p, t) in &few.points {
            let (d, q, u) = many
                .points
                .iter()
                .map(|(q, u)| (p.distance_squared(*q), *q, *u))
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .unwrap_or((f64::INFINITY, *p, *t));
            let d = d.sqrt();
            nearest = nearest.min(d);
            // Two samples face each other if both conormals are within 66° of the line between them (cosine 0.4).
            let along = (q - *p).normalize_or_zero();
            let towards = t.dot(along) > 0.4 && u.dot(-along) > 0.4;
            facing += usize::from(towards && d < FACING_GAP.get() * larger);
        }
        // The rims nearly touch, or more than half of the samples face the other rim.
        nearest < NEAR_GAP.get() * self.diameter.min(other.diameter)
            || 2 * facing > few.points.len()
    }
}

/// Settings from which a region's lattice is chosen.
#[derive(Clone, Copy, Debug)]
pub struct BoxSize {
    /// The voxel size.
    pub voxel: VoxelSize,
    /// Whether an automatic voxel only has to resolve the surface's topology and rough shape, because the patch is finished on
    /// its own triangles.
    pub coarse: bool,
    /// Factor of the box's margin; 1 at first.
    pub growth: f64,
    /// Divisor of the voxel, and, up to 2, of the coarsest voxel too; 1 at first.
    pub refine: f64,
}

/// Whether a region has a single rim with a patch of few vertices, or of some hundred around which the surface bends little.
fn has_simple_rim(holes: &[&Hole]) -> bool {
    matches!(holes, [hole] if hole.edges <= SHORT_RIM.get()
        || hole.edges <= MEDIUM_RIM.get() && tilt(hole) < SLIGHT_TILT.get())
}

/// The sine of the angle between the surface around a hole and the plane of its rim, root mean square over the rim's edges.
fn tilt(hole: &Hole) -> f64 {
    let squares = hole.conormals.iter().map(|c| c.dot(hole.normal).powi(2));
    (squares.sum::<f64>() / hole.edges as f64).sqrt()
}

impl Region {
    /// The smallest voxel for holes of this largest diameter. The cost of a grid is proportional to the square of the diameter in
    /// voxels: with the smallest voxel it has about ten million unknowns of about a kilobyte each.
    pub fn finest(diameter: f64) -> f64 {
        diameter / FINEST.get()
    }

    /// Nodes of its box on the finest level along each axis.
    pub fn finest_dims(&self) -> [usize; 3] {
        let finer = 1 << self.refinements.min(16);
        self.dims.map(|n| n as usize * finer)
    }

    /// The automatic voxel for holes whose largest and smallest diameters are given.
    fn automatic(holes: &[&Hole], diameter: f64, smallest: f64, size: &BoxSize) -> f64 {
        let edges: f64 = holes.iter().map(|h| h.edges as f64).sum();
        let edge = holes.iter().map(|h| h.length).sum::<f64>() / edges;
        let narrow = holes
            .iter()
            .filter(|h| h.edges > 8)
            .map(|h| (h.diameter / h.width.max(1e-3 * h.diameter)).min(NARROWEST.get()))
            .fold(1.0, f64::max);
        let coarse = match has_simple_rim(holes) {
            true => ACROSS_SIMPLE.get(),
            false => ACROSS_COARSE.get(),
        };
        let (across, by_edges) = match size.coarse {
            true => (coarse * narrow.sqrt(), 0.0),
            false => (ACROSS.get() * narrow, (diameter / edge).min(64.0)),
        };
        // A region of several loops resolves the smallest of them.
        let by_loops = match holes {
            [_] => 0.0,
            _ => (ACROSS_SMALLEST.get() * diameter / smallest).min(96.0),
        };
        let wanted = across.max(by_edges).max(by_loops);
        let refined = (wanted * size.refine).min(ACROSS_RETRY.get().max(wanted));
        diameter / refined.min(ACROSS_LIMIT.get())
    }

    /// The lattice of holes that are filled together. The box also holds `part`, the bounds of an initial surface, if there is
    /// one.
    pub fn new(mesh: &Mesh, holes: &[&Hole], size: &BoxSize, part: Option<(DVec3, DVec3)>) -> Self {
        let BoxSize {
            voxel,
            coarse: is_coarse,
            growth,
            refine,
        } = *size;
        let chosen = || holes.iter();
        // Largest and smallest diameter in world units; loops of at most eight edges do not count as the smallest.
        let extent = part.map_or(0.0, |(low, high)| (high - low).max_element());
        let diameter = chosen().map(|h| h.diameter).fold(extent, f64::max);
        let smallest = chosen()
            .filter(|h| h.edges > 8)
            .map(|h| h.diameter)
            .fold(diameter, f64::min);
        let voxel = match voxel {
            // No grid of wider voxels holds a surface across the hole.
            VoxelSize::Length(v) if v <= diameter => v.max(Self::finest(diameter)),
            _ => Self::automatic(holes, diameter, smallest, size),
        };
        // The voxel is doubled from level to level while about 16 voxels remain across the hole, for slots more.
        let across = diameter / voxel;
        let narrow = chosen()
            .map(|h| (h.diameter / h.width.max(1e-3 * h.diameter)).min(NARROWEST.get()))
            .fold(f64::INFINITY, f64::min);
        let coarsest = COARSEST.get() * narrow.max(refine.min(2.0));
        let mut refinements = log2(across / coarsest).floor().max(0.0) as usize;
        let mut coarse = voxel * f64::from(1u32 << refinements.min(16));
        // The box: rims and initial surface, with a margin that grows with the width of the widest hole.
        let rims = chosen().flat_map(|h| &h.rim);
        let part = part.iter().flat_map(|p| [p.0, p.1]);
        let (low, high) = bounds(rims.map(|v| mesh.positions[*v as usize]).chain(part));
        let widest = chosen().map(|h| h.width).fold(0.25 * diameter, f64::max);
        // Along an axis on which the rims extend far, the surface bulges less beyond them.
        let bulge = (MARGIN_PART.get() * widest - MARGIN_TAKEN.get() * (high - low))
            .max(DVec3::splat(LEAST_MARGIN.get() * widest));
        let nodes = match is_coarse && has_simple_rim(holes) {
            true => MARGIN_SIMPLE.get(),
            false => MARGIN_NODES.get(),
        };
        let margin = |coarse: f64| growth * bulge + nodes * coarse;
        let blocks = |coarse: f64| Lattice::blocks(low, high, margin(coarse), coarse);
        // A box of many nodes gets a coarser level if the hole is wide enough there.
        if is_coarse && diameter > COARSEST.get() * coarse && blocks(coarse) > MANY_BLOCKS.get() {
            (refinements, coarse) = (refinements + 1, 2.0 * coarse);
        }
        // Rims that are far apart for their size, such as two tiny holes on opposite sides of a model, would need too many
        // blocks.
        let (mut voxel, mut coarse) = (voxel, coarse);
        while blocks(coarse) > MOST_BLOCKS.get() && coarse < (high - low).max_element() {
            (voxel, coarse) = (2.0 * voxel, 2.0 * coarse);
        }
        let (lattice, dims) = Lattice::around(low, high, margin(coarse), coarse);
        Self {
            diameter,
            voxel,
            refinements,
            lattice,
            dims,
        }
    }
}
