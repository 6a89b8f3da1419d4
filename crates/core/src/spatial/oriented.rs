//! Oriented boxes (Gottschalk, Lin and Manocha 1996), and a tree of them over triangles. Around long, thin triangles they are far
//! smaller than axis-aligned boxes.

use glam::{DMat3, DVec3, Vec3Swizzles};

use crate::mesh::bounds;
use crate::mesh::topology::NONE;

/// Maximum number of triangles in a leaf.
const LEAF: usize = 4;
/// Relative to the largest coordinate: margin of oriented boxes for rounding errors, which are about 1e-15.
pub(super) const ROUNDING: f64 = 1e-13;

/// An oriented box.
#[derive(Clone, Copy)]
pub(super) struct Oriented {
    centre: DVec3,
    /// The rotation into the box's own coordinates: its rows are the axes.
    turn: DMat3,
    /// Half of its sizes along the axes.
    half: DVec3,
}

impl Oriented {
    /// A box around points. Its first axis leads from the point farthest from the points' mean to the point farthest from that
    /// one, the second to the point farthest from the first axis.
    pub(super) fn around(points: &[DVec3], margin: f64) -> Self {
        let mean = points.iter().sum::<DVec3>() / points.len() as f64;
        let farthest = |from: DVec3| {
            let distance = |p: &&DVec3| p.distance_squared(from);
            let by = |p: &&DVec3, q: &&DVec3| distance(p).total_cmp(&distance(q));
            points.iter().max_by(by).copied().unwrap_or(from)
        };
        let from = farthest(mean);
        let first = (farthest(from) - from).try_normalize().unwrap_or(DVec3::X);
        let beside = |p: &DVec3| (*p - from).reject_from_normalized(first);
        let by = |p: &DVec3, q: &DVec3| p.length_squared().total_cmp(&q.length_squared());
        let wide = points.iter().map(beside).max_by(by).unwrap_or(DVec3::ZERO);
        let across = wide
            .try_normalize()
            .unwrap_or(first.any_orthonormal_vector());
        let second = across.reject_from_normalized(first).normalize();
        let axes = DMat3::from_cols(first, second, first.cross(second));
        let turn = axes.transpose();
        let (low, high) = bounds(points.iter().map(|p| turn * (*p - from)));
        Self {
            centre: from + axes * (0.5 * (low + high)),
            turn,
            half: 0.5 * (high - low) + margin,
        }
    }

    /// Whether two boxes may intersect: no axis of a box and no cross product of two of their axes separates them.
    pub(super) fn meets(&self, other: &Self) -> bool {
        /// Bound of the rounding errors of products of unit vectors. It also keeps cross products of nearly parallel axes, which
        /// are rounding errors, from separating boxes.
        const ERROR: f64 = 1e-12;
        let (own, its) = (self.half, other.half);
        // The other box in the coordinates of this one: its centre, its axes as columns, and the bounds of their components.
        let apart = self.turn * (other.centre - self.centre);
        let axes = self.turn * other.turn.transpose();
        let bounds = |axis: DVec3| axis.abs() + ERROR;
        let [a, b, c] = [axes.x_axis, axes.y_axis, axes.z_axis].map(bounds);
        // The axes of this box, then the other's.
        if apart
            .abs()
            .cmpgt(own + a * its.x + b * its.y + c * its.z)
            .any()
        {
            return false;
        }
        let along = axes.transpose() * apart;
        if along
            .abs()
            .cmpgt(its + DVec3::new(a.dot(own), b.dot(own), c.dot(own)))
            .any()
        {
            return false;
        }
        // The products of all axes of this box with one of the other's.
        let separates = |axis: DVec3, size: DVec3, reach: DVec3| {
            let reach = reach + own.yzx() * size.zxy() + own.zxy() * size.yzx();
            apart.cross(axis).abs().cmpgt(reach).any()
        };
        !(separates(axes.x_axis, a, its.y * c + its.z * b)
            || separates(axes.y_axis, b, its.z * a + its.x * c)
            || separates(axes.z_axis, c, its.x * b + its.y * a))
    }

    /// Squared distance of a point from the box; 0 inside.
    pub(super) fn distance_squared(&self, p: DVec3) -> f64 {
        let beyond = (self.turn * (p - self.centre)).abs() - self.half;
        beyond.max(DVec3::ZERO).length_squared()
    }

    /// Where a ray enters the box, in lengths of its direction; none if it misses the box.
    pub(super) fn entered(&self, from: DVec3, along: DVec3) -> Option<f64> {
        let at = self.turn * (from - self.centre);
        let inverse = (self.turn * along).recip();
        let (a, b) = ((-self.half - at) * inverse, (self.half - at) * inverse);
        let (mut near, mut far) = (0.0f64, f64::INFINITY);
        for k in 0..3 {
            // A ray along a side gives 0 times infinity, a NaN, which `f64::min` and `f64::max` ignore.
            near = near.max(a[k].min(b[k]));
            far = far.min(a[k].max(b[k]));
        }
        (near <= far * (1.0 + 1e-12)).then_some(near)
    }
}

/// A tree of oriented boxes over triangles, which are given by their numbers.
pub(super) struct OrientedTree {
    pub(super) nodes: Vec<Node>,
    triangles: Vec<u32>,
}

pub(super) struct Node {
    pub(super) bounds: Oriented,
    /// The group that all triangles below this node belong to, or `NONE`.
    pub(super) group: u32,
    /// Range in the triangles of the tree.
    start: u32,
    end: u32,
    /// Index of the second child; the first follows its parent. 0 for a leaf.
    pub(super) second: u32,
}

/// What the upper part of the tree is built of: a triangle without a group, or all triangles of a group.
struct Unit {
    centre: DVec3,
    group: u32,
    triangles: Vec<u32>,
}

/// What a tree is built over.
pub(super) struct Triangles<'a> {
    /// The corners of each triangle.
    pub(super) corners: &'a [[DVec3; 3]],
    /// The group of each triangle, or `NONE`. The triangles of a group lie in one subtree. Empty if there are no groups.
    pub(super) groups: &'a [u32],
    /// Margin of the boxes for rounding errors, in units of the corners.
    pub(super) margin: f64,
}

impl Triangles<'_> {
    fn group(&self, triangle: u32) -> u32 {
        self.groups.get(triangle as usize).copied().unwrap_or(NONE)
    }

    fn centre(&self, triangles: &[u32]) -> DVec3 {
        let all = triangles.iter().flat_map(|t| self.corners[*t as usize]);
        all.sum::<DVec3>() / (3 * triangles.len()) as f64
    }
}

impl OrientedTree {
    pub(super) fn new(all: &Triangles) -> Self {
        let mut order: Vec<u32> = (0..all.corners.len() as u32).collect();
        order.sort_by_key(|t| all.group(*t));
        let same = |s: &u32, t: &u32| all.group(*s) == all.group(*t) && all.group(*s) != NONE;
        let unit = |triangles: &[u32]| Unit {
            centre: all.centre(triangles),
            group: all.group(triangles[0]),
            triangles: triangles.to_vec(),
        };
        let mut units: Vec<Unit> = order.chunk_by(same).map(unit).collect();
        let mut tree = Self {
            nodes: Vec::new(),
            triangles: Vec::with_capacity(order.len()),
        };
        if !units.is_empty() {
            tree.build(all, &mut units, NONE);
        }
        tree
    }

    /// The triangles of a leaf.
    pub(super) fn triangles(&self, node: &Node) -> &[u32] {
        &self.triangles[node.start as usize..node.end as usize]
    }

    /// Adds a node over units, which all belong to `group` unless that is `NONE`.
    fn build(&mut self, all: &Triangles, units: &mut [Unit], group: u32) {
        if let [unit] = &*units
            && unit.group != group
        {
            let single = |&t: &u32| Unit {
                centre: all.centre(&[t]),
                group: unit.group,
                triangles: vec![t],
            };
            let mut singles: Vec<Unit> = unit.triangles.iter().map(single).collect();
            return self.build(all, &mut singles, unit.group);
        }
        let triangles = units.iter().flat_map(|unit| &unit.triangles);
        let corners: Vec<DVec3> = triangles.flat_map(|t| all.corners[*t as usize]).collect();
        let node = self.nodes.len();
        let start = self.triangles.len() as u32;
        let bounds = Oriented::around(&corners, all.margin);
        self.nodes.push(Node {
            bounds,
            group,
            start,
            end: start,
            second: 0,
        });
        if units.len() <= LEAF && units.iter().all(|unit| unit.group == group) {
            let own = units.iter().flat_map(|unit| &unit.triangles);
            self.triangles.extend(own);
            self.nodes[node].end = self.triangles.len() as u32;
            return;
        }
        let axis = widest(units, &bounds);
        let half = units.len() / 2;
        units.select_nth_unstable_by(half, |a, b| {
            let [p, q] = [a, b].map(|unit| unit.centre.dot(axis));
            p.total_cmp(&q).then(a.triangles[0].cmp(&b.triangles[0]))
        });
        let (low, high) = units.split_at_mut(half);
        self.build(all, low, group);
        self.nodes[node].second = self.nodes.len() as u32;
        self.build(all, high, group);
        self.nodes[node].end = self.triangles.len() as u32;
    }
}

/// The axis of a box along which the centres of units spread most.
fn widest(units: &[Unit], bounds: &Oriented) -> DVec3 {
    let spread = |axis: &DVec3| {
        let all = units.iter().map(|unit| unit.centre.dot(*axis));
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
            (l.min(x), h.max(x))
        });
        high - low
    };
    let axes = bounds.turn.transpose();
    let [first, others @ ..] = [axes.x_axis, axes.y_axis, axes.z_axis];
    let wider = |best: DVec3, axis: DVec3| match spread(&axis) > spread(&best) {
        true => axis,
        false => best,
    };
    others.into_iter().fold(first, wider)
}
