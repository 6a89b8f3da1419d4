//! Level lines of nodal fields on a square grid, and the number of connected components inside the zero line.

use super::grid::SquareGrid;

/// A straight segment of a level line.
#[doc(hidden)]
pub type Segment = [[f64; 2]; 2];

/// The level line `field = level`, cell by cell, with linear interpolation along the cells' edges.
#[doc(hidden)]
pub fn level_line(grid: &SquareGrid, field: &[f64], level: f64) -> Vec<Segment> {
    let mut segments = Vec::new();
    for j in 0..grid.cells() {
        for i in 0..grid.cells() {
            cell_segments(grid, field, level, (i, j), &mut segments);
        }
    }
    segments
}

fn cell_segments(
    grid: &SquareGrid,
    field: &[f64],
    level: f64,
    (i, j): (usize, usize),
    out: &mut Vec<Segment>,
) {
    // Corners in counterclockwise order.
    let round = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
    let value = round.map(|(a, b)| field[grid.index(a, b)] - level);
    let mut crossings = Vec::with_capacity(4);
    for k in 0..4 {
        let l = (k + 1) % 4;
        if (value[k] < 0.0) != (value[l] < 0.0) {
            let t = value[k] / (value[k] - value[l]);
            let (p, q) = (
                grid.position(round[k].0, round[k].1),
                grid.position(round[l].0, round[l].1),
            );
            crossings.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
        }
    }
    // If the line crosses all four edges, the sign of the corners' mean decides which crossings are joined.
    if crossings.len() == 4 && (value.iter().sum::<f64>() < 0.0) == (value[0] < 0.0) {
        crossings.rotate_left(1);
    }
    for pair in crossings.chunks_exact(2) {
        out.push([pair[0], pair[1]]);
    }
}

/// Number of connected components of `field < 0`; nodes are connected along the edges of the grid.
#[doc(hidden)]
pub fn components_inside(grid: &SquareGrid, field: &[f64]) -> usize {
    let n = grid.cells();
    let mut seen = vec![false; field.len()];
    let mut count = 0;
    for start in grid.nodes() {
        let at = grid.index(start.0, start.1);
        if field[at] >= 0.0 || seen[at] {
            continue;
        }
        count += 1;
        seen[at] = true;
        let mut open = vec![start];
        while let Some((i, j)) = open.pop() {
            let near = [
                (i.wrapping_sub(1), j),
                (i + 1, j),
                (i, j.wrapping_sub(1)),
                (i, j + 1),
            ];
            for (a, b) in near {
                if a <= n && b <= n {
                    let k = grid.index(a, b);
                    if field[k] < 0.0 && !seen[k] {
                        seen[k] = true;
                        open.push((a, b));
                    }
                }
            }
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_level_line_of_a_cone_is_a_circle() {
        let grid = SquareGrid::centred(40);
        let field = grid.field(|[x, y]| x.hypot(y));
        let line = level_line(&grid, &field, 0.3);
        let length: f64 = line
            .iter()
            .map(|[p, q]| (p[0] - q[0]).hypot(p[1] - q[1]))
            .sum();
        assert!(
            (length - 0.6 * std::f64::consts::PI).abs() < 2e-3,
            "{length}"
        );
    }

    #[test]
    fn components_are_counted() {
        let grid = SquareGrid::centred(20);
        let two = grid.field(|[x, y]| (x - 0.25).hypot(y).min((x + 0.25).hypot(y)) - 0.15);
        let one = grid.field(|[x, y]| (x - 0.25).hypot(y).min((x + 0.25).hypot(y)) - 0.3);
        assert_eq!(
            (
                components_inside(&grid, &two),
                components_inside(&grid, &one)
            ),
            (2, 1)
        );
        assert_eq!(components_inside(&grid, &grid.field(|_| 0.0)), 0);
    }
}
