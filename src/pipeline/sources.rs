//! Which part of the mesh each region takes for its surroundings.

use std::collections::BTreeMap;

use glam::DVec3;

use super::Inspection;
use crate::mesh::topology::NONE;
use crate::params::VoxelSize;
use crate::region::Region;
use crate::sdf::Sampler;

/// The restricted hierarchies may hold this many times the mesh's faces in all.
const MOST_COPIES: usize = 8;
/// How much wider than the first box a region may become.
const WIDEST: f64 = 1.8;

/// The surroundings of each region.
///
/// A region knows the pieces its rims lie on. Others that merely pass through its box (fragments that lie in each other,
/// a second layer of a scan) would contradict them, and are left out.
pub(super) struct Sources<'a> {
    all: Sampler<'a>,
    restricted: Vec<Sampler<'a>>,
    /// For each group its restricted sampler, if it needs one.
    of_group: Vec<Option<usize>>,
}

impl<'a> Sources<'a> {
    /// `asked` tells which groups will ask for samples.
    pub(super) fn new(
        found: &'a Inspection,
        groups: &[Vec<usize>],
        asked: &dyn Fn(&[usize]) -> bool,
    ) -> Self {
        let all = Sampler::new(&found.mesh, &found.topology);
        let bodies = Bodies::new(found);
        let mut sets: BTreeMap<Vec<u32>, usize> = BTreeMap::new();
        let mut restricted = Vec::new();
        let mut room = MOST_COPIES * found.mesh.faces.len();
        let of_group = groups
            .iter()
            .map(|group| {
                let own = asked(group).then(|| bodies.others_near(found, group))??;
                if let Some(&at) = sets.get(&own) {
                    return Some(at);
                }
                let faces: usize = own.iter().map(|&b| bodies.faces[b as usize]).sum();
                room = room.checked_sub(faces)?;
                let wanted =
                    |piece: u32| own.binary_search(&bodies.of_piece[piece as usize]).is_ok();
                restricted.push(all.restricted(&wanted));
                sets.insert(own, restricted.len() - 1);
                Some(restricted.len() - 1)
            })
            .collect();
        Self {
            all,
            restricted,
            of_group,
        }
    }

    /// The whole mesh.
    pub(super) fn all(&self) -> &Sampler<'a> {
        &self.all
    }

    /// What a group knows.
    pub(super) fn of(&self, group: usize) -> &Sampler<'a> {
        self.of_group[group].map_or(&self.all, |at| &self.restricted[at])
    }
}

/// Pieces that share vertices, taken together: edges with more than two faces cut one surface into several pieces.
struct Bodies {
    of_piece: Vec<u32>,
    faces: Vec<usize>,
    boxes: Vec<[DVec3; 2]>,
}

impl Bodies {
    fn new(found: &Inspection) -> Self {
        let (mesh, topology) = (&found.mesh, &found.topology);
        let mut parent: Vec<u32> = (0..topology.piece_faces.len() as u32).collect();
        let mut first = vec![NONE; mesh.positions.len()];
        for (face, &piece) in mesh.faces.iter().zip(&topology.piece) {
            if piece == NONE {
                continue;
            }
            for &v in face {
                let other = &mut first[v as usize];
                if *other == NONE {
                    *other = piece;
                } else {
                    let (a, b) = (root(&mut parent, *other), root(&mut parent, piece));
                    parent[a.max(b) as usize] = a.min(b);
                }
            }
        }
        let count = parent.len();
        let of_piece: Vec<u32> = (0..count as u32).map(|p| root(&mut parent, p)).collect();
        let mut faces = vec![0; count];
        let mut boxes = vec![[DVec3::INFINITY, DVec3::NEG_INFINITY]; count];
        for (face, &piece) in mesh.faces.iter().zip(&topology.piece) {
            if piece == NONE || topology.piece_faces[piece as usize] <= 2 {
                continue;
            }
            let body = of_piece[piece as usize] as usize;
            faces[body] += 1;
            for &v in face {
                let p = mesh.positions[v as usize];
                boxes[body][0] = boxes[body][0].min(p);
                boxes[body][1] = boxes[body][1].max(p);
            }
        }
        Self {
            of_piece,
            faces,
            boxes,
        }
    }

    /// The bodies of a group's rims, sorted, if the box of another one meets the region's.
    fn others_near(&self, found: &Inspection, group: &[usize]) -> Option<Vec<u32>> {
        let piece = |h: &usize| found.holes[*h].piece as usize;
        let mut own: Vec<u32> = group.iter().map(|h| self.of_piece[piece(h)]).collect();
        own.sort_unstable();
        own.dedup();
        let region = Region::new(
            &found.mesh,
            &found.holes,
            group,
            VoxelSize::Auto,
            WIDEST,
            1.0,
            None,
        );
        let low = region.lattice.origin;
        let size = DVec3::from_array(region.dims.map(f64::from)) * region.lattice.voxel;
        let meets = |b: &[DVec3; 2]| b[0].cmple(low + size).all() && b[1].cmpge(low).all();
        let another = |(i, b): (usize, &[DVec3; 2])| {
            own.binary_search(&(i as u32)).is_err() && self.faces[i] > 0 && meets(b)
        };
        self.boxes.iter().enumerate().any(another).then_some(own)
    }
}

fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        parent[i as usize] = parent[parent[i as usize] as usize];
        i = parent[i as usize];
    }
    i
}
