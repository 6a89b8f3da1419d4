//! Drawing data by weight, the same for the same input.

/// A generator of uniform numbers (S. Vigna's splitmix64, of G. L. Steele et al. 2014).
pub(super) struct Random(u64);

impl Random {
    /// Starts at a seed.
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A number above 0 and at most 1.
    pub(super) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        ((z >> 11) + 1) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// So many of the items, drawn without putting back, each draw by weight; in the order of the items. (P. S. Efraimidis,
    /// P. G. Spirakis, "Weighted random sampling with a reservoir", 2006: those with the smallest `−ln u / w`.)
    pub(super) fn draw(
        &mut self,
        items: &[u32],
        weight: impl Fn(u32) -> f64,
        most: usize,
    ) -> Vec<u32> {
        if items.len() <= most {
            return items.to_vec();
        }
        let key = |&i: &u32| (-self.uniform().ln() / weight(i), i);
        let mut keys: Vec<(f64, u32)> = items.iter().map(key).collect();
        keys.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut drawn: Vec<u32> = keys[..most].iter().map(|k| k.1).collect();
        drawn.sort_unstable();
        drawn
    }
}
