//! Creases between pairs of rim vertices given by the caller.

use rustc_hash::FxHashMap;

use super::rim_sides::RimSides;
use super::{Continued, CreaseRefusal};

impl RimSides {
    /// Continues creases only between the given pairs of rim vertices. The mesh has `count` vertices.
    ///
    /// The pairs divide the rim into stretches. Stretches that no crease separates form a group, which gets the side of most of
    /// its edges.
    pub(crate) fn continued_with(
        &self,
        count: usize,
        joined: &[[u32; 2]],
    ) -> Result<Continued, CreaseRefusal> {
        let place = |v: u32| self.collar.rim.iter().position(|w| *w == v);
        let pairs = joined.iter().map(|&[a, b]| {
            let (a, b) = place(a).zip(place(b))?;
            (a != b).then_some([a.min(b), a.max(b)])
        });
        let pairs: Vec<[usize; 2]> = pairs
            .collect::<Option<_>>()
            .ok_or(CreaseRefusal::EndOffCrease)?;
        let crosses = |[a, b]: [usize; 2], [c, d]: [usize; 2]| a < c && c < b && b < d;
        if pairs.iter().any(|&p| pairs.iter().any(|&q| crosses(p, q))) {
            return Err(CreaseRefusal::Crosses);
        }
        self.first_valid(&self.labels_between(&pairs), count)
    }

    /// For each edge of the rim, the most frequent side in its group. Groups are the stretches that the pairs leave connected.
    fn labels_between(&self, pairs: &[[usize; 2]]) -> Vec<usize> {
        // An edge is inside some pairs and outside the others; edges of one group agree on all of them.
        let group =
            |i: usize| -> Vec<bool> { pairs.iter().map(|&[a, b]| (a..b).contains(&i)).collect() };
        let mut votes: FxHashMap<Vec<bool>, Vec<usize>> = FxHashMap::default();
        for (i, label) in self.labels.iter().enumerate() {
            votes.entry(group(i)).or_default().push(*label);
        }
        let most = |labels: &Vec<usize>| {
            let count = |label: &usize| labels.iter().filter(|l| *l == label).count();
            labels
                .iter()
                .copied()
                .max_by_key(|l| (count(l), usize::MAX - l))
        };
        let of_group = |i: usize| votes.get(&group(i)).and_then(most);
        let labels = self.labels.iter().enumerate();
        labels.map(|(i, l)| of_group(i).unwrap_or(*l)).collect()
    }
}
