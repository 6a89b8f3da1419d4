//! Triangulates the polygons in which a level surface intersects the faces of a cell.

use glam::DVec3;

use super::table::EDGE_FACES;

/// Most corners of a polygon: one per edge of a cell.
const MOST: usize = 12;

/// A closed polygon whose corners are on different edges of one cell.
#[derive(Default)]
pub(super) struct Polygon {
    len: usize,
    edge: [u8; MOST],
    vertex: [u32; MOST],
    position: [DVec3; MOST],
}

impl Polygon {
    pub(super) fn push(&mut self, edge: u8, vertex: u32, position: DVec3) {
        self.edge[self.len] = edge;
        self.vertex[self.len] = vertex;
        self.position[self.len] = position;
        self.len += 1;
    }

    /// Appends the triangulation with the least sum of squared diagonals; false if none is admissible.
    ///
    /// A diagonal must not be in a face of the cell: the neighbouring cell might have the same diagonal, which would
    /// then be an edge of four faces.
    pub(super) fn triangulate(&self, faces: &mut Vec<[u32; 3]>) -> bool {
        let v = &self.vertex;
        match self.len {
            3 => faces.push([v[0], v[1], v[2]]),
            4 => {
                let (a, b) = (self.diagonal(0, 2), self.diagonal(1, 3));
                if a.min(b) == f64::INFINITY {
                    return false;
                }
                if a <= b {
                    faces.extend([[v[0], v[1], v[2]], [v[0], v[2], v[3]]]);
                } else {
                    faces.extend([[v[0], v[1], v[3]], [v[1], v[2], v[3]]]);
                }
            }
            _ => return self.triangulate_long(faces),
        }
        true
    }

    /// The cost of a diagonal: squared length, 0 for a side of the polygon, infinite in a face of the cell.
    fn diagonal(&self, i: usize, j: usize) -> f64 {
        if j - i == 1 || (i == 0 && j == self.len - 1) {
            0.0
        } else if EDGE_FACES[self.edge[i] as usize] & EDGE_FACES[self.edge[j] as usize] != 0 {
            f64::INFINITY
        } else {
            self.position[i].distance_squared(self.position[j])
        }
    }

    /// Dynamic programming: `cost[i][j]` is the least cost of the polygon i, …, j, and `apex[i][j]` the third corner of
    /// its triangle on the side ij.
    fn triangulate_long(&self, faces: &mut Vec<[u32; 3]>) -> bool {
        let n = self.len;
        let mut cost = [[0.0; MOST]; MOST];
        let mut apex = [[0u8; MOST]; MOST];
        for span in 2..n {
            for i in 0..n - span {
                let j = i + span;
                let mut best = (f64::INFINITY, i + 1);
                for (m, row) in cost.iter().enumerate().take(j).skip(i + 1) {
                    let c = cost[i][m] + row[j];
                    if c < best.0 {
                        best = (c, m);
                    }
                }
                cost[i][j] = best.0 + self.diagonal(i, j);
                apex[i][j] = best.1 as u8;
            }
        }
        if !cost[0][n - 1].is_finite() {
            return false;
        }
        // Collect the triangles of the best triangulation.
        let mut stack = [(0, 0); 2 * MOST];
        stack[0] = (0, n - 1);
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let (i, j) = stack[waiting];
            if j - i > 1 {
                let m = usize::from(apex[i][j]);
                faces.push([self.vertex[i], self.vertex[m], self.vertex[j]]);
                stack[waiting] = (i, m);
                stack[waiting + 1] = (m, j);
                waiting += 2;
            }
        }
        true
    }

    pub(super) fn centroid(&self) -> DVec3 {
        self.position[..self.len].iter().sum::<DVec3>() / self.len as f64
    }

    pub(super) fn fan(&self, centre: u32, faces: &mut Vec<[u32; 3]>) {
        for i in 0..self.len {
            faces.push([self.vertex[i], self.vertex[(i + 1) % self.len], centre]);
        }
    }
}
