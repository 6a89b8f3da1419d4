//! Sets of numbers, such as marked faces, as ascending ranges.

use serde::{Deserialize, Serialize};

/// Half-open ranges of numbers, `[first, end)`, in ascending order.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Runs(pub Vec<[u32; 2]>);

impl Runs {
    /// The indices of the marks that are true.
    pub fn of_marks(marks: impl IntoIterator<Item = bool>) -> Self {
        let numbers = (0u32..).zip(marks);
        Self::of_sorted(numbers.filter(|(_, mark)| *mark).map(|(i, _)| i))
    }

    /// The ranges of ascending numbers.
    pub fn of_sorted(numbers: impl IntoIterator<Item = u32>) -> Self {
        let mut runs: Vec<[u32; 2]> = Vec::new();
        for number in numbers {
            match runs.last_mut() {
                Some(last) if last[1] == number => last[1] += 1,
                _ => runs.push([number, number + 1]),
            }
        }
        Self(runs)
    }

    /// Checks that there is at least one range, and that the ranges ascend and stay below `count`, the number of faces.
    ///
    /// # Errors
    /// The first violation.
    pub fn check(&self, count: usize) -> Result<(), String> {
        let mut before = 0;
        for &[first, end] in &self.0 {
            if first >= end || first < before {
                return Err(format!(
                    "the range of faces {first}, {end} is empty, or does not follow the previous one"
                ));
            }
            if end as usize > count {
                return Err(format!(
                    "there is no face {}: the mesh has {count} faces, numbered from 0",
                    end - 1
                ));
            }
            before = end;
        }
        match self.0.is_empty() {
            true => Err("no face is marked".to_owned()),
            false => Ok(()),
        }
    }

    /// The numbers.
    pub fn numbers(&self) -> impl Iterator<Item = usize> + '_ {
        let ranges = self.0.iter();
        ranges.flat_map(|&[first, end]| first as usize..end as usize)
    }

    /// The number of elements.
    pub fn count(&self) -> usize {
        self.0.iter().map(|[a, b]| (b - a) as usize).sum()
    }

    /// The text of a face file, one number a line, as the command line reads it.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for number in self.numbers() {
            text += &format!("{number}\n");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_become_ranges_and_back() {
        let runs = Runs::of_marks([true, true, false, true]);
        assert_eq!(runs.0, [[0, 2], [3, 4]]);
        assert_eq!(runs.numbers().collect::<Vec<_>>(), [0, 1, 3]);
        assert_eq!((runs.count(), runs.text().as_str()), (3, "0\n1\n3\n"));
    }

    #[test]
    fn wrong_ranges_are_refused() {
        let check = |runs: &[[u32; 2]]| Runs(runs.to_vec()).check(10);
        assert!(check(&[[0, 3], [3, 10]]).is_ok());
        for wrong in [
            &[][..],
            &[[3, 3]],
            &[[4, 3]],
            &[[0, 4], [3, 5]],
            &[[9, 11]],
            &[[0, u32::MAX]],
        ] {
            assert!(check(wrong).is_err(), "{wrong:?}");
        }
    }
}
