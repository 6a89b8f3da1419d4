//! Cutting the extracted surface: the part that belongs to the hole, cleaned to a manifold with simple boundary loops.

use std::collections::VecDeque;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxBuildHasher, FxHashMap, FxHashSet};

use super::StitchInput;
use crate::mesh::area_vector;
use crate::threads::CollectIndexed;

/// The kept part: vertices, faces, and boundary loops in the direction of its faces.
#[derive(Default)]
pub(super) struct Kept {
    pub(super) positions: Vec<DVec3>,
    /// Unit normals, from the faces of each vertex.
    pub(super) normals: Vec<DVec3>,
    pub(super) faces: Vec<[u32; 3]>,
    /// Connected component of each face.
    pub(super) component: Vec<usize>,
    /// Number of faces of each component.
    pub(super) component_len: Vec<usize>,
    /// Boundary loops.
    pub(super) loops: Vec<Vec<u32>>,
    /// The component that each loop bounds.
    pub(super) loop_component: Vec<usize>,
}

/// Cuts at `cut_depth` from the rim. Drops components without boundary, and components of a few faces next to a larger one.
pub(super) fn cut(input: &StitchInput) -> Kept {
    let least = input.params.cut_depth * input.voxel;
    let source = input.extracted;
    let deep: Vec<bool> = source
        .positions
        .par_iter()
        .map(|&p| p.is_finite() && input.surface.depth(p) > least)
        .collect_indexed();
    let mut faces: Vec<[u32; 3]> = source.faces.clone();
    faces.retain(|f| {
        f.iter().all(|&v| deep[v as usize]) && f[0] != f[1] && f[1] != f[2] && f[2] != f[0]
    });
    make_manifold(&mut faces, source.positions.len());
    drop_components(&mut faces);
    let mut kept = compact(&source.positions, faces);
    (kept.component, kept.component_len) = components(&kept.faces);
    boundary_loops(&mut kept);
    kept
}

/// Removes ears (faces with two boundary edges), faces on edges used twice in one direction, and all but one fan at each vertex.
fn make_manifold(faces: &mut Vec<[u32; 3]>, vertices: usize) {
    loop {
        let before = faces.len();
        let mut edges = FxHashSet::with_capacity_and_hasher(3 * faces.len(), FxBuildHasher);
        faces.retain(|f| {
            let free = (0..3).all(|k| !edges.contains(&(f[k], f[(k + 1) % 3])));
            if free {
                edges.extend((0..3).map(|k| (f[k], f[(k + 1) % 3])));
            }
            free
        });
        faces.retain(|f| {
            (0..3)
                .filter(|&k| !edges.contains(&(f[(k + 1) % 3], f[k])))
                .count()
                < 2
        });
        keep_one_fan(faces, vertices);
        if faces.len() == before {
            return;
        }
    }
}

/// At a vertex with several fans of faces, keeps the largest fan.
fn keep_one_fan(faces: &mut Vec<[u32; 3]>, vertices: usize) {
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); vertices];
    for (i, f) in faces.iter().enumerate() {
        f.iter().for_each(|&v| around[v as usize].push(i as u32));
    }
    let mut drop = vec![false; faces.len()];
    for (v, list) in around.iter().enumerate() {
        let fans = fans(v as u32, list, faces);
        if fans.len() > 1 {
            let largest = (0..fans.len())
                .rev()
                .max_by_key(|&i| fans[i].len())
                .unwrap_or(0);
            for (i, fan) in fans.iter().enumerate() {
                if i != largest {
                    fan.iter().for_each(|&f| drop[f as usize] = true);
                }
            }
        }
    }
    let mut i = 0;
    faces.retain(|_| {
        i += 1;
        !drop[i - 1]
    });
}

/// The faces around `v`, grouped into fans by the edges at `v` that they share.
fn fans(v: u32, list: &[u32], faces: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let sides = |f: u32| {
        let face = faces[f as usize];
        let k = face.iter().position(|&x| x == v).unwrap_or(0);
        (face[(k + 1) % 3], face[(k + 2) % 3])
    };
    let mut left: Vec<u32> = list.to_vec();
    let mut fans = Vec::new();
    while let Some(first) = left.pop() {
        let mut fan = vec![first];
        let (mut a, mut b) = sides(first);
        while let Some(i) = left
            .iter()
            .position(|&f| sides(f).0 == b || sides(f).1 == a)
        {
            let f = left.swap_remove(i);
            let (x, y) = sides(f);
            if x == b {
                b = y;
            } else {
                a = x;
            }
            fan.push(f);
        }
        fans.push(fan);
    }
    fans
}

/// Drops components without boundary, and components that are tiny next to the largest.
fn drop_components(faces: &mut Vec<[u32; 3]>) {
    let (component, len) = components(faces);
    let edges: FxHashSet<(u32, u32)> = faces
        .iter()
        .flat_map(|f| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])])
        .collect();
    let mut open = vec![false; len.len()];
    for (f, &p) in faces.iter().zip(&component) {
        open[p] |= (0..3).any(|k| !edges.contains(&(f[(k + 1) % 3], f[k])));
    }
    let most = len.iter().copied().max().unwrap_or(0);
    let mut i = 0;
    faces.retain(|_| {
        i += 1;
        let p = component[i - 1];
        open[p] && (len[p] >= 6 || len[p] * 20 >= most)
    });
}

/// The connected component of each face, and the number of faces of each component.
fn components(faces: &[[u32; 3]]) -> (Vec<usize>, Vec<usize>) {
    let mut by_edge = FxHashMap::with_capacity_and_hasher(3 * faces.len(), FxBuildHasher);
    for (i, f) in faces.iter().enumerate() {
        (0..3).for_each(|k| {
            by_edge.insert((f[k], f[(k + 1) % 3]), i);
        });
    }
    let mut component = vec![usize::MAX; faces.len()];
    let mut len = Vec::new();
    for start in 0..faces.len() {
        if component[start] != usize::MAX {
            continue;
        }
        let mut queue = VecDeque::from([start]);
        component[start] = len.len();
        let mut count = 0;
        while let Some(i) = queue.pop_front() {
            count += 1;
            for k in 0..3 {
                let beyond = by_edge.get(&(faces[i][(k + 1) % 3], faces[i][k])).copied();
                if let Some(j) = beyond.filter(|&j| component[j] == usize::MAX) {
                    component[j] = len.len();
                    queue.push_back(j);
                }
            }
        }
        len.push(count);
    }
    (component, len)
}

fn compact(positions: &[DVec3], mut faces: Vec<[u32; 3]>) -> Kept {
    let mut renumber = vec![u32::MAX; positions.len()];
    let mut used = Vec::new();
    for v in faces.iter_mut().flatten() {
        if renumber[*v as usize] == u32::MAX {
            renumber[*v as usize] = used.len() as u32;
            used.push(positions[*v as usize]);
        }
        *v = renumber[*v as usize];
    }
    let mut normals = vec![DVec3::ZERO; used.len()];
    for f in &faces {
        let normal = area_vector(f.map(|v| used[v as usize]));
        f.iter().for_each(|&v| normals[v as usize] += normal);
    }
    Kept {
        positions: used,
        normals: normals.into_iter().map(DVec3::normalize_or_zero).collect(),
        faces,
        ..Kept::default()
    }
}

/// Finds the boundary loops, each with the component that it bounds.
fn boundary_loops(kept: &mut Kept) {
    let mut owner = FxHashMap::with_capacity_and_hasher(3 * kept.faces.len(), FxBuildHasher);
    for (i, f) in kept.faces.iter().enumerate() {
        (0..3).for_each(|k| {
            owner.insert((f[k], f[(k + 1) % 3]), i);
        });
    }
    let mut next = vec![None; kept.positions.len()];
    for f in &kept.faces {
        for k in 0..3 {
            let (a, b) = (f[k], f[(k + 1) % 3]);
            if !owner.contains_key(&(b, a)) {
                next[a as usize] = Some(b);
            }
        }
    }
    for start in 0..next.len() {
        let mut lp = Vec::new();
        let mut at = start;
        while let Some(to) = next[at].take() {
            lp.push(at as u32);
            at = to as usize;
        }
        if lp.len() >= 3 {
            kept.loop_component
                .push(kept.component[owner[&(lp[0], lp[1])]]);
            kept.loops.push(lp);
        }
    }
}
