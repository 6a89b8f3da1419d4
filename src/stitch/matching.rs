//! Which border loop of the kept part belongs to which rim loop.

use std::collections::BTreeSet;

use glam::DVec3;
use rayon::prelude::*;

use super::cut::Kept;
use super::liepa::{self, Polygon};
use super::rim::Rims;
use super::sector::nearest_pair;
use super::zip::Polyline;
use super::{StitchError, StitchInput, StitchReport};

/// A border loop whose mean distance to the rim is more than this many voxels does not belong to it.
const FAR: f64 = 6.0;
/// A loop the extracted surface does not reach is triangulated on its own if its area is at most this many voxels times its
/// perimeter.
const THIN: f64 = 2.0;
/// Pieces with fewer faces are dropped rather than joined to a larger one at the same rim.
const CRUMB: usize = 24;

/// What to do with each loop.
pub(super) struct Plan {
    /// Pairs of a rim loop and a border loop of the kept part; the latter may visit a vertex twice.
    pub(super) zips: Vec<(usize, Vec<u32>)>,
    /// Rim loops with a triangulation of their own, by position in the loop.
    pub(super) direct: Vec<(usize, Vec<[usize; 3]>)>,
    /// Pieces that are left out.
    pub(super) dropped: BTreeSet<usize>,
}

/// Matches the loops; may join rim loops of `rims` to each other (a joined one is left empty).
pub(super) fn plan(
    input: &StitchInput,
    rims: &mut Rims,
    kept: &Kept,
    report: &mut StitchReport,
) -> Result<Plan, StitchError> {
    let mut plan = Plan {
        zips: Vec::new(),
        direct: Vec::new(),
        dropped: BTreeSet::new(),
    };
    let mut of_rim = assign(input, rims, kept, &mut plan)?;
    serve_missing(input, rims, &mut of_rim, &mut plan, report)?;
    for (rim, loops) in of_rim.iter().enumerate() {
        if let Some(joined) = join(kept, loops, &mut plan.dropped, report) {
            check_direction(input, rims, kept, rim, &joined)?;
            plan.zips.push((rim, joined));
        }
    }
    Ok(plan)
}

/// The border loops nearest to each rim loop.
fn assign(
    input: &StitchInput,
    rims: &Rims,
    kept: &Kept,
    plan: &mut Plan,
) -> Result<Vec<Vec<usize>>, StitchError> {
    let nearest: Vec<(usize, f64, usize)> = kept
        .loops
        .iter()
        .map(|lp| nearest_rim(input, rims, kept, lp))
        .collect();
    let limit = FAR * input.voxel;
    let mut near = vec![false; kept.piece_len.len()];
    for (l, n) in nearest.iter().enumerate() {
        near[kept.loop_piece[l]] |= n.1 <= limit;
    }
    let mut of_rim = vec![Vec::new(); rims.loops.len()];
    for (l, &(rim, distance, worst)) in nearest.iter().enumerate() {
        if !near[kept.loop_piece[l]] {
            plan.dropped.insert(kept.loop_piece[l]);
        } else if distance > limit {
            let position = kept.positions[kept.loops[l][worst] as usize];
            return Err(StitchError::OpenBorder { position, distance });
        } else {
            of_rim[rim].push(l);
        }
    }
    Ok(of_rim)
}

/// The rim loop nearest to most vertices of a border loop, the mean distance, and the farthest vertex.
fn nearest_rim(input: &StitchInput, rims: &Rims, kept: &Kept, lp: &[u32]) -> (usize, f64, usize) {
    let found: Vec<(f64, usize)> = lp
        .par_iter()
        .map(|&v| {
            let p = kept.positions[v as usize];
            let mut best = (f64::INFINITY, 0);
            for (r, rim) in rims.loops.iter().enumerate() {
                for i in 0..rim.len() {
                    let [a, b] = [rim[i], rim[(i + 1) % rim.len()]]
                        .map(|v| input.mesh.positions[v as usize]);
                    let d = distance_to_segment(p, a, b);
                    if d < best.0 {
                        best = (d, r);
                    }
                }
            }
            best
        })
        .collect();
    let mut votes = vec![0usize; rims.loops.len()];
    found.iter().for_each(|f| votes[f.1] += 1);
    let rim = (0..votes.len())
        .rev()
        .max_by_key(|&r| votes[r])
        .unwrap_or(0);
    let mean = found.iter().map(|f| f.0).sum::<f64>() / found.len() as f64;
    let worst = (0..found.len())
        .max_by(|&a, &b| found[a].0.total_cmp(&found[b].0))
        .unwrap_or(0);
    (rim, mean, worst)
}

fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let d = b - a;
    let t = ((p - a).dot(d) / d.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    p.distance(a + t * d)
}

/// Rim loops without border loop: triangulated on their own, or joined to the nearest other rim loop.
fn serve_missing(
    input: &StitchInput,
    rims: &mut Rims,
    of_rim: &mut [Vec<usize>],
    plan: &mut Plan,
    report: &mut StitchReport,
) -> Result<(), StitchError> {
    for rim in 0..of_rim.len() {
        if !of_rim[rim].is_empty() || rims.loops[rim].is_empty() {
            continue;
        }
        if let Some(faces) = direct(input, rims, rim) {
            report.filled_directly += 1;
            plan.direct.push((rim, faces));
            continue;
        }
        let served: BTreeSet<usize> = plan.direct.iter().map(|d| d.0).collect();
        let Some(other) = bridge(input, rims, rim, &served) else {
            return Err(StitchError::RimNotReached {
                rim: rims.source[rim],
            });
        };
        report.bridged += 1;
        if of_rim[other].is_empty() && other < rim {
            let Some(faces) = direct(input, rims, other) else {
                return Err(StitchError::RimNotReached {
                    rim: rims.source[other],
                });
            };
            plan.direct.push((other, faces));
        }
    }
    Ok(())
}

/// A triangulation of one rim loop without new vertices, if the loop is thin and the faces follow the surface.
fn direct(input: &StitchInput, rims: &Rims, rim: usize) -> Option<Vec<[usize; 3]>> {
    let lp = &rims.loops[rim];
    let n = lp.len();
    let position: Vec<DVec3> = lp
        .iter()
        .map(|&v| input.mesh.positions[v as usize])
        .collect();
    let beyond: Vec<_> = (0..n)
        .map(|i| rims.face_normal.get(&(lp[i], lp[(i + 1) % n])).copied())
        .collect();
    let blocked = |i: usize, j: usize| lp[i] == lp[j] || rims.has_edge(lp[i], lp[j]);
    let faces = liepa::triangulate(&Polygon {
        position: &position,
        beyond: &beyond,
        blocked: &blocked,
    })?;
    let mut area = 0.0;
    let mut lean = 0.0;
    for f in &faces {
        let [a, b, c] = f.map(|i| position[i]);
        let cross = (b - a).cross(c - a);
        let normal = f
            .iter()
            .map(|&i| rims.normal[&lp[i]])
            .sum::<DVec3>()
            .normalize_or_zero();
        area += cross.length() / 2.0;
        lean += cross.dot(normal) / 2.0;
    }
    let perimeter: f64 = (0..n)
        .map(|i| position[i].distance(position[(i + 1) % n]))
        .sum();
    (lean > 0.3 * area && area <= THIN * input.voxel * perimeter).then_some(faces)
}

/// Joins rim loop `rim` to the nearest other that is not in `served`, by an edge that both use in both directions.
fn bridge(
    input: &StitchInput,
    rims: &mut Rims,
    rim: usize,
    served: &BTreeSet<usize>,
) -> Option<usize> {
    let outline = |r: usize| -> (Vec<DVec3>, Vec<DVec3>) {
        rims.loops[r]
            .iter()
            .map(|v| (input.mesh.positions[*v as usize], rims.normal[v]))
            .unzip()
    };
    let (p, normal) = outline(rim);
    let sectors = Polyline {
        position: &p,
        normal: &normal,
    }
    .sectors(false);
    let mut best: Option<(f64, usize, usize, usize)> = None;
    for other in (0..rims.loops.len()).filter(|&o| o != rim && !served.contains(&o)) {
        let (q, normal) = outline(other);
        let others = Polyline {
            position: &q,
            normal: &normal,
        }
        .sectors(false);
        let limit = best.map_or(FAR * input.voxel, |b| b.0);
        let allowed = |i: usize, j: usize| {
            let (a, b) = (rims.loops[rim][i], rims.loops[other][j]);
            a != b && !rims.has_edge(a, b)
        };
        if let Some((d, i, j)) = nearest_pair([&p, &q], [&sectors, &others], limit, allowed) {
            best = Some((d, other, i, j));
        }
    }
    let (_, other, i, j) = best?;
    let mut island = std::mem::take(&mut rims.loops[rim]);
    let (a, b) = (island[i], rims.loops[other][j]);
    rims.edges.insert((a.min(b), a.max(b)));
    island.rotate_left(i);
    island.push(a);
    island.push(b);
    rims.loops[other].splice(j + 1..j + 1, island);
    Some(other)
}

/// One loop from all border loops at one rim loop, by edges across the gaps between their pieces.
fn join(
    kept: &Kept,
    loops: &[usize],
    dropped: &mut BTreeSet<usize>,
    report: &mut StitchReport,
) -> Option<Vec<u32>> {
    let main = loops
        .iter()
        .copied()
        .max_by_key(|&l| (kept.piece_len[kept.loop_piece[l]], kept.loops[l].len()))?;
    let mut joined = kept.loops[main].clone();
    let mut left: Vec<usize> = loops.iter().copied().filter(|&l| l != main).collect();
    left.retain(|&l| {
        let piece = kept.loop_piece[l];
        let crumb = kept.piece_len[piece] < CRUMB
            && kept.loop_piece.iter().filter(|&&p| p == piece).count() == 1;
        if crumb {
            dropped.insert(piece);
        }
        !crumb
    });
    let outline = |lp: &[u32]| -> (Vec<DVec3>, Vec<DVec3>) {
        lp.iter()
            .map(|&v| (kept.positions[v as usize], kept.normals[v as usize]))
            .unzip()
    };
    while !left.is_empty() {
        let (p, normal) = outline(&joined);
        let sectors = Polyline {
            position: &p,
            normal: &normal,
        }
        .sectors(true);
        let mut best = (f64::INFINITY, 0, 0, 0);
        for (k, &l) in left.iter().enumerate() {
            let (q, normal) = outline(&kept.loops[l]);
            let others = Polyline {
                position: &q,
                normal: &normal,
            }
            .sectors(true);
            if let Some((d, i, j)) =
                nearest_pair([&p, &q], [&sectors, &others], best.0, |_, _| true)
            {
                best = (d, k, i, j);
            }
        }
        let (_, k, i, j) = best;
        let mut other = kept.loops[left.remove(k)].clone();
        other.rotate_left(j);
        other.push(other[0]);
        other.push(joined[i]);
        joined.splice(i + 1..i + 1, other);
        report.joined_pieces += 1;
    }
    Some(joined)
}

/// The border loop must run along the rim loop, not against it.
fn check_direction(
    input: &StitchInput,
    rims: &Rims,
    kept: &Kept,
    rim: usize,
    joined: &[u32],
) -> Result<(), StitchError> {
    let lp = &rims.loops[rim];
    let rim_at = |i: usize| input.mesh.positions[lp[i % lp.len()] as usize];
    let m = joined.len();
    let along: f64 = (0..m)
        .into_par_iter()
        .map(|j| {
            let [p, q] = [joined[j], joined[(j + 1) % m]].map(|v| kept.positions[v as usize]);
            let mut best = (f64::INFINITY, DVec3::ZERO);
            for i in 0..lp.len() {
                let d = distance_to_segment(p, rim_at(i), rim_at(i + 1));
                if d < best.0 {
                    best = (d, (rim_at(i + 1) - rim_at(i)).normalize_or_zero());
                }
            }
            (q - p).dot(best.1)
        })
        .collect::<Vec<f64>>()
        .iter()
        .sum();
    if along > 0.0 {
        Ok(())
    } else {
        Err(StitchError::Orientation {
            rim: rims.source[rim],
        })
    }
}
