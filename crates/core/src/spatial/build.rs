//! Building a bounding volume hierarchy: the order of its leaves, their boxes, and the nodes above them.

use glam::DVec3;
use obvhs::{aabb::Aabb, bvh2::Bvh2};

use super::bvh::{Bvh, Corners, LEAF, Node, WIDTH, round_down, round_up};
use super::ploc::{binary, places_along_curve};
use super::slivers::Slivers;
use crate::mesh::{Mesh, bounds};

/// Triangles of a leaf in a hierarchy for few queries; in others a leaf is one triangle. At most [`WIDTH`]. With four, a hierarchy is built
/// in two fifths of the time and takes a third of the memory, and a query takes twice the time.
const SEVERAL: usize = 4;

fn enclosing(corners: &[DVec3; 3]) -> Aabb {
    let low = corners[0].min(corners[1]).min(corners[2]);
    let high = corners[0].max(corners[1]).max(corners[2]);
    Aabb::new(
        [round_down(low.x), round_down(low.y), round_down(low.z)].into(),
        [round_up(high.x), round_up(high.y), round_up(high.z)].into(),
    )
}

/// Collapses a binary hierarchy into nodes with up to [`WIDTH`] children, depth first. Also returns the order of the leaves: that in
/// which they are reached, except that the last one stays the last.
fn collapsed(binary: &Bvh2) -> (Vec<Node>, Vec<u32>) {
    let last = binary.primitive_indices.len() as u32 - 1;
    let mut order = Vec::with_capacity(binary.primitive_indices.len());
    let mut nodes: Vec<Node> = Vec::with_capacity(binary.nodes.len() / 4);
    // Roots of binary subtrees to process, each with its parent node and its child slot there.
    let mut waiting = vec![(0usize, usize::MAX, 0usize)];
    while let Some((root, parent, at)) = waiting.pop() {
        let mut found = [root; WIDTH];
        let mut count = 1;
        // Replace the inner node of the largest area by its two children while there is room.
        while count < WIDTH {
            let inner = (0..count).filter(|i| binary.nodes[found[*i]].prim_count == 0);
            let area = |i: &usize| binary.nodes[found[*i]].aabb.half_area();
            let Some(i) = inner.max_by(|i, j| area(i).total_cmp(&area(j))) else {
                break;
            };
            let first = binary.nodes[found[i]].first_index as usize;
            found[i] = first;
            found[count] = first + 1;
            count += 1;
        }
        // Store the index of the new node in its parent.
        let index = nodes.len();
        if let Some(parent) = nodes.get_mut(parent) {
            parent.children[at] = index as u32;
        }
        // Store the boxes of its children.
        let mut node = Node::EMPTY;
        for (i, child) in found[..count].iter().enumerate() {
            let child = &binary.nodes[*child];
            node.set_box(i, &child.aabb);
            for p in child.first_index..child.first_index + child.prim_count {
                let leaf = binary.primitive_indices[p as usize];
                if leaf == last {
                    node.children[i] = LEAF | last;
                } else {
                    node.children[i] = LEAF | order.len() as u32;
                    order.push(leaf);
                }
            }
        }
        node.count = count as u32;
        nodes.push(node);
        // Push inner children in reverse, so that the first one is processed next.
        for (i, child) in found[..count].iter().enumerate().rev() {
            if binary.nodes[*child].prim_count == 0 {
                waiting.push((*child, index, i));
            }
        }
    }
    order.push(last);
    nodes.shrink_to_fit();
    (nodes, order)
}

/// The centre of the bounding box of some faces; the origin if there are none.
pub fn middle(mesh: &Mesh, faces: impl Iterator<Item = u32>) -> DVec3 {
    let (low, high) = bounds(faces.flat_map(|f| mesh.corners(f)));
    match low.x <= high.x {
        true => 0.5 * (low + high),
        false => DVec3::ZERO,
    }
}

/// The faces in the order of their centroids along a curve.
fn along_curve(mesh: &Mesh, faces: Vec<u32>) -> Vec<u32> {
    let (low, high) = bounds(faces.iter().flat_map(|&f| mesh.corners(f)));
    let place = places_along_curve(low, high);
    let place = |f: u32| place(mesh.corners(f).iter().sum::<DVec3>() / 3.0);
    let mut order: Vec<(u64, u32)> = faces.iter().map(|&f| (place(f), f)).collect();
    drop(faces);
    order.sort_unstable();
    order.iter().map(|(_, f)| *f).collect()
}

impl Corners {
    fn own(mesh: &Mesh, faces: &[u32], centre: DVec3) -> Self {
        let of = |&f: &u32| mesh.corners(f).map(|p| p - centre);
        Self::Own(faces.iter().map(of).collect())
    }

    /// The vertices are numbered in the order of their first use.
    fn shared(mesh: &Mesh, faces: &[u32], centre: DVec3) -> Self {
        // One more than the number of each vertex. Of zeroed memory only the pages that are written take room.
        let mut number = vec![0u32; mesh.positions.len()];
        let mut points = Vec::new();
        let mut of = |v: u32| {
            let number = &mut number[v as usize];
            if *number == 0 {
                points.push(mesh.positions[v as usize] - centre);
                *number = points.len() as u32;
            }
            *number - 1
        };
        let corners = faces.iter().map(|&f| mesh.faces[f as usize].map(&mut of));
        let corners = corners.collect();
        points.shrink_to_fit();
        Self::Shared(corners, points)
    }
}

impl Bvh {
    /// Builds the hierarchy over the given faces of a mesh.
    ///
    /// # Panics
    /// If a face's vertex index is out of range.
    pub fn new(mesh: &Mesh, faces: impl Iterator<Item = u32>) -> Self {
        let faces: Vec<u32> = faces.collect();
        let centre = middle(mesh, faces.iter().copied());
        Self::about(mesh, faces, centre)
    }

    /// Builds the hierarchy with coordinates relative to a given point. Hierarchies over parts of a mesh with the same point
    /// return bitwise equal distances.
    ///
    /// # Panics
    /// As [`Bvh::new`].
    pub fn about(mesh: &Mesh, faces: Vec<u32>, centre: DVec3) -> Self {
        Self::with_leaves(mesh, faces, centre, 1)
    }

    /// As [`Bvh::about`], for so few queries that building it takes most of the time.
    pub fn for_few(mesh: &Mesh, faces: Vec<u32>, centre: DVec3) -> Self {
        Self::with_leaves(mesh, faces, centre, SEVERAL)
    }

    fn with_leaves(mesh: &Mesh, faces: Vec<u32>, centre: DVec3, per_leaf: usize) -> Self {
        let split = Slivers::among(mesh, &faces, centre).map(|(slivers, others)| {
            let others = Self::of_all(mesh, others, centre, per_leaf);
            Box::new((others, slivers))
        });
        Self {
            split,
            ..Self::of_all(mesh, faces, centre, per_leaf)
        }
    }

    /// A single hierarchy over all faces.
    fn of_all(mesh: &Mesh, faces: Vec<u32>, centre: DVec3, per_leaf: usize) -> Self {
        if faces.is_empty() {
            return Self::over(mesh, Vec::new(), faces, centre, per_leaf);
        }
        let faces = along_curve(mesh, faces);
        let joined = |leaf: &[u32]| {
            let corners = leaf.iter().map(|&f| mesh.corners(f).map(|p| p - centre));
            let boxes = corners.map(|corners| enclosing(&corners));
            boxes.fold(Aabb::empty(), |all, one| all.union(&one))
        };
        let leaves = faces.chunks(per_leaf);
        let (nodes, order) = collapsed(&binary(leaves.map(joined).collect()));
        let leaf = |&i: &u32| faces.chunks(per_leaf).nth(i as usize).unwrap_or_default();
        let faces = order.iter().flat_map(leaf).copied().collect();
        Self::over(mesh, nodes, faces, centre, per_leaf)
    }

    fn over(
        mesh: &Mesh,
        nodes: Vec<Node>,
        faces: Vec<u32>,
        centre: DVec3,
        per_leaf: usize,
    ) -> Self {
        let corners = match per_leaf {
            1 => Corners::own(mesh, &faces, centre),
            _ => Corners::shared(mesh, &faces, centre),
        };
        Self {
            nodes,
            faces,
            corners,
            per_leaf,
            centre,
            split: None,
        }
    }
}
