//! Packs square tiles into one rectangular page, in rows.

/// Upper bound of a page's width and height, in texels.
pub(super) const LONGEST: u32 = 4096;

/// The layout of tiles on a page.
pub(super) struct Packed {
    /// Texels in width and height.
    pub(super) size: [u32; 2],
    /// The upper left corner of each tile.
    pub(super) corners: Vec<[u32; 2]>,
}

/// Packs squares of the given sides in rows, the largest first. `None` if they do not fit on a page.
pub(super) fn packed(sides: &[u32]) -> Option<Packed> {
    let area: f64 = sides.iter().map(|s| f64::from(*s).powi(2)).sum();
    let largest = sides.iter().copied().max()?;
    // 10 % of room for the gaps in rows of unequal squares; chosen, not measured.
    let width = ((1.1 * area).sqrt().ceil().min(f64::from(LONGEST)) as u32).max(largest);
    let width = width.next_multiple_of(4);
    let mut order: Vec<usize> = (0..sides.len()).collect();
    order.sort_by_key(|&i| (u32::MAX - sides[i], i));
    let mut corners = vec![[0; 2]; sides.len()];
    let (mut x, mut top, mut bottom) = (0, 0, 0);
    for i in order {
        let side = sides[i];
        if x + side > width {
            x = 0;
            top = bottom;
        }
        corners[i] = [x, top];
        x += side;
        bottom = bottom.max(top + side);
        if bottom > LONGEST {
            return None;
        }
    }
    let size = [width, bottom.next_multiple_of(4)];
    (width <= LONGEST).then_some(Packed { size, corners })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_lie_apart_on_the_page() {
        let sides: Vec<u32> = (0..200).map(|i| 16 + (i * 7919) % 90).collect();
        let page = packed(&sides).unwrap();
        for (i, a) in page.corners.iter().enumerate() {
            assert!((0..2).all(|k| a[k] + sides[i] <= page.size[k]));
            for (j, b) in page.corners.iter().enumerate().take(i) {
                let apart = (0..2).any(|k| a[k] + sides[i] <= b[k] || b[k] + sides[j] <= a[k]);
                assert!(apart, "{i} {j}");
            }
        }
        let used: u32 = sides.iter().map(|s| s * s).sum();
        assert!(f64::from(used) > 0.75 * f64::from(page.size[0] * page.size[1]));
        assert!(packed(&[LONGEST + 4]).is_none());
        assert!(packed(&vec![64; 5000]).is_none());
    }
}
