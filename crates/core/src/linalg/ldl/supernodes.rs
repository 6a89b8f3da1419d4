//! Supernodes: consecutive columns of a factor that share their rows.

use sprs::CsMat;

/// Marks a column without parent.
pub(super) const NONE: u32 = u32::MAX;
/// Maximum fraction of zeros among the stored entries of two joined supernodes.
const ZEROS: f64 = 0.25;
/// Two supernodes are also joined if they have at most this number of columns together.
const NARROW: usize = 4;

/// Consecutive columns of the factor that share the rows below them.
#[derive(Clone, Debug)]
pub(super) struct Supernode {
    /// Its first column.
    pub(super) first: usize,
    /// Number of its columns.
    pub(super) columns: usize,
    /// Its rows in rising order: its own columns, then the rows below.
    pub(super) rows: Vec<u32>,
    /// Number of earlier supernodes whose update matrix goes to this one.
    pub(super) children: usize,
    /// Number of stored entries, not counting the zeros that joining added.
    entries: usize,
}

impl Supernode {
    /// Its rows below its own columns.
    pub(super) fn below(&self) -> &[u32] {
        &self.rows[self.columns..]
    }

    /// Joins the supernode just before it to this one.
    fn absorb(&mut self, child: Self) {
        let own: Vec<u32> = child.rows[..child.columns].to_vec();
        self.rows.splice(0..0, own);
        self.first = child.first;
        self.columns += child.columns;
        self.entries += child.entries;
    }

    /// Whether to absorb the supernode just before it, which is a child.
    fn wants(&self, child: &Self) -> bool {
        let columns = self.columns + child.columns;
        let stored = trapezoid(columns, child.columns + self.rows.len());
        let zeros = stored - self.entries - child.entries;
        columns <= NARROW || zeros as f64 <= ZEROS * stored as f64
    }
}

/// Number of entries on and below the diagonal in a supernode with `columns` columns and `rows` rows.
fn trapezoid(columns: usize, rows: usize) -> usize {
    columns * rows - columns * (columns - 1) / 2
}

/// The elimination tree of a reordered matrix: the parent of each column, and the number of entries in its column of the factor
/// below the diagonal (J. W. H. Liu, "The role of elimination trees in sparse factorization", SIAM J. Matrix Anal. Appl. 11,
/// 1990).
pub(super) fn elimination_tree(
    matrix: &CsMat<f64>,
    order: &[u32],
    place: &[u32],
) -> (Vec<u32>, Vec<u32>) {
    let n = order.len();
    let (mut parent, mut mark) = (vec![NONE; n], vec![NONE; n]);
    let mut lengths = vec![0; n];
    for k in 0..n {
        mark[k] = k as u32;
        for mut j in neighbours(matrix, order, place, k).filter(|&j| j < k) {
            while mark[j] != k as u32 {
                if parent[j] == NONE {
                    parent[j] = k as u32;
                }
                lengths[j] += 1;
                mark[j] = k as u32;
                j = parent[j] as usize;
            }
        }
    }
    (parent, lengths)
}

/// A postorder of a forest: each subtree is contiguous with its root at the end. Among the subtrees of a root, the one with the
/// longest column comes last.
pub(super) fn postorder(parent: &[u32], lengths: &[u32]) -> Vec<u32> {
    let mut children: Vec<Vec<u32>> = vec![Vec::new(); parent.len()];
    let mut stack = Vec::new();
    for (k, &p) in (0u32..).zip(parent) {
        match children.get_mut(p as usize) {
            Some(own) => own.push(k),
            None => stack.push(k),
        }
    }
    let mut backwards = Vec::with_capacity(parent.len());
    while let Some(k) = stack.pop() {
        backwards.push(k);
        let own = &mut children[k as usize];
        own.sort_by_key(|&c| lengths[c as usize]);
        stack.append(own);
    }
    backwards.reverse();
    backwards
}

/// The supernodes of a matrix that is ordered by a postorder of its elimination tree.
pub(super) fn supernodes(
    matrix: &CsMat<f64>,
    order: &[u32],
    place: &[u32],
    tree: (&[u32], &[u32]),
) -> Vec<Supernode> {
    let n = order.len();
    let mut all: Vec<Supernode> = Vec::new();
    // For each column, the supernodes whose first row below is that column: their update matrices go there.
    let mut leaving: Vec<Vec<u32>> = vec![Vec::new(); n];
    let mut mark = vec![NONE; n];
    let mut first = 0;
    while first < n {
        // A fundamental supernode: each column is the parent of the one before and has one row less (J. W. H. Liu, E. G. Ng, B.
        // W. Peyton, "On finding supernodes for sparse matrix computations", 1993).
        let end = end_of(first, tree);
        let mut rows: Vec<u32> = (first as u32..end as u32).collect();
        // The rows below: the rows of its matrix entries and the rows below its children.
        let mut add = |row: u32| {
            let seen = std::mem::replace(&mut mark[row as usize], first as u32);
            if row as usize >= end && seen != first as u32 {
                rows.push(row);
            }
        };
        for (k, children) in (first..end).zip(&leaving[first..end]) {
            neighbours(matrix, order, place, k).for_each(|j| add(j as u32));
            let children = children.iter().map(|&c| &all[c as usize]);
            children
                .flat_map(Supernode::below)
                .copied()
                .for_each(&mut add);
        }
        rows[end - first..].sort_unstable();
        let mut own = Supernode {
            first,
            columns: end - first,
            entries: trapezoid(end - first, rows.len()),
            rows,
            children: 0,
        };
        // Absorbs the child just before it as long as that stores few zeros (relaxed amalgamation; C. Ashcraft, R. Grimes, "The
        // influence of relaxed supernode partitions on the multifrontal method", 1989).
        while let Some(before) = all.last()
            && before.below().first().is_some_and(|&r| (r as usize) < end)
            && own.wants(before)
        {
            all.pop().into_iter().for_each(|child| own.absorb(child));
        }
        // Its parent is the supernode with the first row below as a column.
        if let Some(&row) = own.below().first() {
            leaving[row as usize].push(all.len() as u32);
        }
        all.push(own);
        first = end;
    }
    count_children(&mut all, n);
    all
}

/// The end of the run of columns from `first` that share the rows below them.
fn end_of(first: usize, (parent, lengths): (&[u32], &[u32])) -> usize {
    let mut last = first;
    while parent[last] as usize == last + 1 && lengths[last] == lengths[last + 1] + 1 {
        last += 1;
    }
    last + 1
}

fn count_children(all: &mut [Supernode], n: usize) {
    let mut owner = vec![0; n];
    for (s, node) in all.iter().enumerate() {
        owner[node.first..node.first + node.columns].fill(s);
    }
    for s in 0..all.len() {
        if let Some(&row) = all[s].below().first() {
            all[owner[row as usize]].children += 1;
        }
    }
}

/// The positions of the entries in a row of the reordered matrix.
fn neighbours<'a>(
    matrix: &'a CsMat<f64>,
    order: &'a [u32],
    place: &'a [u32],
    k: usize,
) -> impl Iterator<Item = usize> + 'a {
    let range = matrix.indptr().outer_inds_sz(order[k] as usize);
    matrix.indices()[range].iter().map(|&j| place[j] as usize)
}
