//! Writes the vertices of a changed object, so that the vertices of each part stay together.

use std::fmt::Write as _;
use std::ops::Range;

use super::object::ObjectText;
use isomend_core::mesh::attributes::NONE;

impl ObjectText<'_> {
    /// The vertices, part by part: the vertices of the file in their order, then new ones, then the unused vertices that follow. Fills in
    /// the number of each vertex of the mesh.
    ///
    /// PrusaSlicer takes as a volume's vertices all between the smallest and the largest that its triangles use. An unused vertex before
    /// a new one would belong to the volume then.
    pub(super) fn vertices(
        &self,
        number_of: &mut [u32],
        keeps_all: bool,
    ) -> Result<String, String> {
        let (own, points) = (&self.own, &self.outline.points);
        let back = own.placement.back();
        let back = back.ok_or("the transform of a changed object has no inverse")?;
        let lead = self.lead(&self.outline.vertices, points);
        let used = self.used_vertices();
        let parts = self.vertices_of_parts(&used, keeps_all);
        let (mut out, mut next) = (String::new(), 0);
        for (part, faces) in parts.iter().zip(own.parts) {
            let is_used = |point: &u32| used[*point as usize] != NONE;
            let end = match keeps_all {
                true => part.len(),
                false => part.iter().rposition(is_used).map_or(0, |last| last + 1),
            };
            let (first, unused) = part.split_at(end);
            for &point in first {
                out.push_str(lead);
                out.push_str(&self.model.text[points[point as usize].clone()]);
                if let Some(number) = number_of.get_mut(used[point as usize] as usize) {
                    *number = next;
                }
                next += 1;
            }
            let corners = faces.iter().flat_map(|f| own.model.mesh.faces[*f as usize]);
            let mut new: Vec<u32> = corners.filter(|v| number_of[*v as usize] == NONE).collect();
            new.sort_unstable();
            new.dedup();
            for v in new {
                out.push_str(lead);
                // A copy of a vertex of the file has the same text.
                match points.get(self.of_file[v as usize] as usize) {
                    Some(range) => out.push_str(&self.model.text[range.clone()]),
                    None => {
                        let p = back(own.model.mesh.positions[v as usize]);
                        let prefix = &self.model.outline.prefix;
                        let _ = write!(
                            out,
                            "<{prefix}vertex x=\"{}\" y=\"{}\" z=\"{}\"/>",
                            p.x, p.y, p.z
                        );
                    }
                }
                number_of[v as usize] = next;
                next += 1;
            }
            for &point in unused {
                out.push_str(lead);
                out.push_str(&self.model.text[points[point as usize].clone()]);
            }
            next += unused.len() as u32;
        }
        out.push_str(self.tail(&self.outline.vertices, points));
        Ok(out)
    }

    /// For each vertex of the file the first vertex of the mesh that it became; `NONE` if no face uses it.
    fn used_vertices(&self) -> Vec<u32> {
        let mut used = vec![NONE; self.outline.points.len()];
        for f in self.own.faces() {
            for v in self.own.model.mesh.faces[f as usize] {
                if let Some(first) = used.get_mut(self.of_file[v as usize] as usize) {
                    *first = (*first).min(v);
                }
            }
        }
        used
    }

    /// The vertices of the file that stay, for each part. A vertex stays if a face uses it, or if no triangle of the file did.
    fn vertices_of_parts(&self, used: &[u32], keeps_all: bool) -> Vec<Vec<u32>> {
        let (own, parts) = (&self.own, &self.own.placement.parts);
        let part_of = self.part_of_vertices();
        let mut all = vec![Vec::new(); parts.len() + 1];
        let mut last = 0;
        for (v, part) in part_of.into_iter().enumerate() {
            if part != NONE {
                last = part as usize;
            }
            let was_unused = part == NONE && !own.drops_unused;
            if keeps_all || was_unused || used[v] != NONE {
                all[last].push(v as u32);
            }
        }
        all
    }

    /// For each vertex of the file the first part whose triangles use it; `NONE` if none does.
    fn part_of_vertices(&self) -> Vec<u32> {
        let own = &self.own;
        let mut part_of = vec![NONE; own.object.positions.len()];
        for (t, triangle) in own.object.triangles.iter().enumerate() {
            let part = own.placement.part_of(t) as u32;
            for v in triangle.corners {
                part_of[v as usize] = part_of[v as usize].min(part);
            }
        }
        part_of
    }

    /// The blanks before each element of a list; a line break if the list is empty. Comments, which are left out, are skipped.
    pub(super) fn lead(&self, list: &Range<usize>, elements: &[Range<usize>]) -> &str {
        let Some(first) = elements.first() else {
            return "\n";
        };
        let start = self.after_comments(list.start, first.start);
        self.model.text.get(start..first.start).unwrap_or("\n")
    }

    /// The blanks after the last element of a list.
    pub(super) fn tail(&self, list: &Range<usize>, elements: &[Range<usize>]) -> &str {
        let Some(last) = elements.last() else {
            return "\n";
        };
        let start = self.after_comments(last.end, list.end);
        self.model.text.get(start..list.end).unwrap_or("\n")
    }

    /// The end of the last comment that lies between two places; the first of them if there is none.
    fn after_comments(&self, from: usize, to: usize) -> usize {
        let comments = self.outline.comments.iter();
        let between = comments.filter(|comment| comment.start >= from && comment.end <= to);
        between.map(|comment| comment.end).max().unwrap_or(from)
    }
}
