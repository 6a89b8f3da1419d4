//! A binary bounding volume hierarchy by parallel locally-ordered clustering (Meister and Bittner, "Parallel locally-ordered
//! clustering for bounding volume hierarchy construction", 2018). A fallback keeps the build time from becoming quadratic for any
//! arrangement of boxes.

use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, node::Bvh2Node, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::morton::morton_encode_u64_unorm;

/// Number of neighbours on each side along the Morton curve with which a node is compared.
const REACH: usize = 6;
/// The first rounds, with the most nodes, compare adjacent neighbours only.
const QUICK_ROUNDS: usize = 2;
/// A round that joins fewer than one node in this many has stalled: equal or nested boxes all prefer the same partner. On scanned
/// meshes every round joins at least one node in four.
const STALLED: usize = 16;
/// Below this many nodes stalled rounds are too cheap to matter.
const FEW: usize = 128;
/// Fraction of the nodes that the optimiser moves to better places after the clustering.
const REINSERTED: f32 = 0.02;

/// The hierarchy over boxes, one box per leaf. Takes ownership of the boxes, so that they are freed before the peak of memory
/// use.
pub(super) fn binary(boxes: Vec<Aabb>) -> Bvh2 {
    let (mut built, stalled) = clustered(boxes);
    // The optimiser's search does not terminate early among equal boxes.
    if !stalled {
        ReinsertionOptimizer::default().run(&mut built, REINSERTED, None);
    }
    built
}

/// The hierarchy by clustering alone, without the optimiser, and whether a round stalled.
fn clustered(boxes: Vec<Aabb>) -> (Bvh2, bool) {
    let count = boxes.len();
    // One cluster per box, in Morton order of the centres.
    let mut current = leaves(&boxes);
    drop(boxes);
    let mut next = Vec::with_capacity(current.len());
    let mut partner: Vec<u32> = Vec::new();
    let mut nodes = vec![Bvh2Node::default(); (2 * count).saturating_sub(1)];
    // Children are stored in pairs from the end of the array, so that they come after their parents.
    let mut free = nodes.len();
    let (mut rounds, mut stalled) = (0, false);
    while current.len() > 1 {
        let reach = if rounds < QUICK_ROUNDS { 1 } else { REACH };
        // Each cluster chooses as partner the neighbour whose joint bounding box has the smallest area.
        choose_partners(&current, reach, &mut partner);
        let agreed = (0..current.len()).filter(|&i| partner[partner[i] as usize] == i as u32);
        let joined = agreed.count() / 2;
        // If few choices are mutual, adjacent clusters are joined in pairs, which also halves their number.
        if current.len() > FEW && joined < current.len() / STALLED {
            stalled = true;
            pair_up(&mut partner);
        }
        // Mutual partners move to the array; their parent replaces the second one.
        for (i, node) in current.iter().enumerate() {
            let other = partner[i] as usize;
            if partner[other] != i as u32 || other == i {
                next.push(*node);
            } else if other < i {
                free -= 2;
                nodes[free] = *node;
                nodes[free + 1] = current[other];
                let around = node.aabb().union(current[other].aabb());
                next.push(Bvh2Node::new(around, 0, free as u32));
            }
        }
        std::mem::swap(&mut current, &mut next);
        next.clear();
        rounds += 1;
    }
    // The last cluster is the root, at the front of the array.
    if let (Some(root), Some(top)) = (nodes.first_mut(), current.first()) {
        *root = *top;
    }
    let built = Bvh2 {
        nodes,
        primitive_indices: (0..count as u32).collect(),
        children_are_ordered_after_parents: true,
        max_depth: Bvh2::default().max_depth.max(rounds + 1),
        ..Bvh2::default()
    };
    (built, stalled)
}

/// Places of points along the Morton curve through a box.
pub(super) fn places_along_curve(low: DVec3, high: DVec3) -> impl Fn(DVec3) -> u64 {
    let scale = 1.0 / (high - low);
    let offset = -low * scale;
    move |p| morton_encode_u64_unorm(p * scale + offset)
}

/// One leaf per box, sorted along the Morton curve of the box centres.
fn leaves(boxes: &[Aabb]) -> Vec<Bvh2Node> {
    let all = boxes.iter().fold(Aabb::empty(), |all, b| all.union(b));
    let place = places_along_curve(all.min.as_dvec3(), all.max.as_dvec3());
    let centres = boxes.iter().map(|b| b.center().as_dvec3());
    let mut order: Vec<(u64, u32)> = centres.map(place).zip(0u32..).collect();
    order.sort_unstable_by_key(|o| o.0);
    order
        .iter()
        .map(|&(_, i)| Bvh2Node::new(boxes[i as usize], 1, i))
        .collect()
}

/// For each node the neighbour, at most `reach` places away, with the smallest joint box; the last one in case of a tie.
fn choose_partners(nodes: &[Bvh2Node], reach: usize, partner: &mut Vec<u32>) {
    let cost = |i: usize, j: usize| nodes[i].aabb().union(nodes[j].aabb()).half_area();
    let count = nodes.len();
    // Costs computed for earlier nodes are kept, since they are symmetric.
    let mut kept = [[0.0f32; REACH]; REACH];
    partner.clear();
    for i in 0..count {
        let (mut best, mut lowest) = (i, f32::INFINITY);
        let mut look = |j: usize, cost: f32| {
            if cost <= lowest {
                (best, lowest) = (j, cost);
            }
        };
        for j in i.saturating_sub(reach)..i {
            look(j, kept[j % REACH][i % REACH]);
        }
        for j in i + 1..(i + reach + 1).min(count) {
            let cost = cost(i, j);
            kept[i % REACH][j % REACH] = cost;
            look(j, cost);
        }
        partner.push(best as u32);
    }
}

/// Pairs adjacent nodes along the curve.
fn pair_up(partner: &mut [u32]) {
    let count = partner.len();
    for (i, partner) in partner.iter_mut().enumerate() {
        *partner = if i ^ 1 < count { i ^ 1 } else { i } as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The depth of a hierarchy. Asserts that every box is in exactly one leaf and inside all boxes above it.
    fn checked_depth(built: &Bvh2, boxes: &[Aabb]) -> usize {
        let mut seen = vec![0; boxes.len()];
        let mut deepest = 0;
        let mut waiting = vec![(0usize, 1usize)];
        while let Some((index, depth)) = waiting.pop() {
            let node = &built.nodes[index];
            deepest = deepest.max(depth);
            if node.prim_count > 0 {
                let i = built.primitive_indices[node.first_index as usize] as usize;
                seen[i] += 1;
                assert_eq!(node.aabb(), &boxes[i]);
                continue;
            }
            for child in [node.first_index as usize, node.first_index as usize + 1] {
                let inner = built.nodes[child].aabb();
                assert_eq!(node.aabb().union(inner), *node.aabb());
                waiting.push((child, depth + 1));
            }
        }
        assert!(seen.iter().all(|&n| n == 1));
        deepest
    }

    #[test]
    fn equal_and_nested_boxes_give_a_shallow_hierarchy_soon() {
        let equal = |_: u32| Aabb::new([0.0; 3].into(), [1.0; 3].into());
        let nested = |i: u32| Aabb::new([0.0; 3].into(), [1.0 + i as f32; 3].into());
        let flat = |i: u32| Aabb::new([0.0; 3].into(), [i as f32, 0.0, 0.0].into());
        for shape in [&equal as &dyn Fn(u32) -> Aabb, &nested, &flat] {
            let boxes: Vec<Aabb> = (0..40_000).map(shape).collect();
            let begun = std::time::Instant::now();
            let built = binary(boxes.clone());
            // Without the fallback this takes over ten seconds.
            assert!(begun.elapsed().as_secs_f64() < 3.0);
            assert!(checked_depth(&built, &boxes) < 200);
        }
    }

    #[test]
    fn ordinary_boxes_do_not_stall() {
        let mut boxes = Vec::new();
        for i in 0..120 {
            for j in 0..120 {
                let (x, y) = (i as f32, j as f32);
                let z = (0.3 * x).sin() * (0.2 * y).cos();
                boxes.push(Aabb::new(
                    [x, y, z].into(),
                    [x + 1.0, y + 1.0, z + 0.3].into(),
                ));
            }
        }
        let (built, stalled) = clustered(boxes.clone());
        assert!(!stalled);
        checked_depth(&built, &boxes);
    }

    #[test]
    fn no_box_and_one_box() {
        assert!(binary(Vec::new()).nodes.is_empty());
        let one = vec![Aabb::new([0.0; 3].into(), [1.0; 3].into())];
        assert_eq!(binary(one).nodes.len(), 1);
    }
}
