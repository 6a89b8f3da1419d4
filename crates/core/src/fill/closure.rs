//! What became of a hole, and how it was closed: the identifiers and words that text, HTML, JSON, page and Python show are here.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::reasons::{AttemptFailure, LeftReason, NotSmooth, OpenReason};

/// What became of a hole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HoleOutcome {
    /// It is closed: how.
    Closed(Closure),
    /// It was left open because the caller did not ask to fill it.
    Left(LeftReason),
    /// It is still open although it was to be filled.
    Open(OpenReason),
}

/// How a hole or region was closed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Closure {
    /// By the surface of the level set.
    LevelSet,
    /// By triangulations of the rims, refined and faired: the failure of the last level set; none where they were preferred to it, or
    /// the rim has few edges.
    Faired(Option<AttemptFailure>),
    /// By the smooth sides around it, continued until they meet in sharp or rounded edges.
    Sides,
    /// By the part of a counterpart at the hole: of the mirrored mesh, or of a template.
    Counterpart,
    /// By a nearly flat cap, the surface of least area: requested, or the missing flat side of a body.
    Flat,
    /// By a flat base under a sheet, with walls down from its border, as requested.
    Base,
    /// In a repair: by walls under the whole sheet whose outer border it is, because no flat cap closed it.
    Walls,
    /// By thin triangles between two rims that coincide.
    Seam,
    /// By triangles between the vertices of each rim.
    RimTriangles(NotSmooth),
    /// In a repair: by an offset shell under the surface around the rims, which ends where it can be closed.
    OffsetShell(NotSmooth),
}

impl Closure {
    /// Its identifier in documents and style sheets.
    pub fn key(&self) -> &'static str {
        self.words()[0]
    }

    /// Its name in tables and sentences for people.
    pub fn name(&self) -> &'static str {
        self.words()[1]
    }

    /// The identifier of the reason why no better surface was made; none where the hole was closed as wished.
    pub fn cause(&self) -> Option<&'static str> {
        match self {
            Self::Faired(why) => why.as_ref().map(AttemptFailure::key),
            Self::RimTriangles(why) | Self::OffsetShell(why) => Some(why.key()),
            _ => None,
        }
    }

    /// The same reason in words.
    pub fn reason(&self) -> Option<String> {
        match self {
            Self::Faired(why) => why.as_ref().map(ToString::to_string),
            Self::RimTriangles(why) | Self::OffsetShell(why) => Some(why.to_string()),
            _ => None,
        }
    }

    /// Identifier and name.
    const fn words(&self) -> [&'static str; 2] {
        match self {
            Self::LevelSet => ["level_set", "level set"],
            Self::Faired(_) => ["faired", "smoothed triangles"],
            Self::Sides => ["sides", "continued sides"],
            Self::Counterpart => ["counterpart", "counterpart"],
            Self::Flat => ["flat", "flat cap"],
            Self::Base => ["base", "flat base"],
            Self::Walls => ["walls", "walls"],
            Self::Seam => ["seam", "seam triangles"],
            Self::RimTriangles(_) => ["rim_triangles", "rim triangles"],
            Self::OffsetShell(_) => ["offset_shell", "offset shell"],
        }
    }
}

impl HoleOutcome {
    /// The identifier of the outcome in documents and style sheets.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Closed(_) => "closed",
            Self::Left(_) => "left",
            Self::Open(_) => "open",
        }
    }

    /// How it was closed; none where it is open.
    pub fn closure(&self) -> Option<&Closure> {
        match self {
            Self::Closed(how) => Some(how),
            Self::Left(_) | Self::Open(_) => None,
        }
    }

    /// The identifier of the reason; none where the hole was closed as wished.
    pub fn cause(&self) -> Option<&'static str> {
        match self {
            Self::Closed(how) => how.cause(),
            Self::Left(why) => Some(why.key()),
            Self::Open(why) => Some(why.key()),
        }
    }

    /// Its name in lists and tables for people: how it was closed, or that it is open.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Closed(how) => how.name(),
            Self::Left(_) => "left open",
            Self::Open(_) => "still open",
        }
    }

    /// The reason in words; none where the hole was closed as wished.
    pub fn reason(&self) -> Option<String> {
        match self {
            Self::Closed(how) => how.reason(),
            Self::Left(why) => Some(why.to_string()),
            Self::Open(why) => Some(why.to_string()),
        }
    }
}

/// Name and reason, such as `left open: asked to keep it open`.
impl fmt::Display for HoleOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.reason() {
            Some(reason) => write!(f, "{}: {reason}", self.name()),
            None => f.write_str(self.name()),
        }
    }
}

/// Numbers of holes by outcome, and of the closed ones by how they were closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Tally {
    /// Closed, in any way.
    pub closed: usize,
    /// Left open because the caller did not ask to fill them.
    pub left: usize,
    /// Still open although they were to be filled.
    pub open: usize,
    /// Closed by the level set.
    pub level_set: usize,
    /// Closed by faired triangulations of their rims.
    pub faired: usize,
    /// Closed by continued sides.
    pub sides: usize,
    /// Closed by counterparts.
    pub counterpart: usize,
    /// Closed by flat caps.
    pub flat: usize,
    /// Outer borders of sheets closed by flat bases with walls.
    pub base: usize,
    /// Outer borders of sheets closed by walls under the sheets.
    pub walls: usize,
    /// Closed as one side of a seam.
    pub seam: usize,
    /// Closed by triangles between the vertices of their rims.
    pub rim_triangles: usize,
    /// Closed by offset shells.
    pub offset_shell: usize,
    /// Boundary chains that do not close.
    pub open_chains: usize,
    /// Patches with faces that intersect other faces.
    pub intersecting_patches: usize,
    /// Faces of patches that intersect other faces.
    pub intersecting_faces: usize,
}

impl Tally {
    /// Counts a hole.
    pub(crate) fn count(&mut self, outcome: &HoleOutcome) {
        let all = match outcome {
            HoleOutcome::Closed(_) => &mut self.closed,
            HoleOutcome::Left(_) => &mut self.left,
            HoleOutcome::Open(_) => &mut self.open,
        };
        *all += 1;
        let Some(how) = outcome.closure() else {
            return;
        };
        *match how {
            Closure::LevelSet => &mut self.level_set,
            Closure::Faired(_) => &mut self.faired,
            Closure::Sides => &mut self.sides,
            Closure::Counterpart => &mut self.counterpart,
            Closure::Flat => &mut self.flat,
            Closure::Base => &mut self.base,
            Closure::Walls => &mut self.walls,
            Closure::Seam => &mut self.seam,
            Closure::RimTriangles(_) => &mut self.rim_triangles,
            Closure::OffsetShell(_) => &mut self.offset_shell,
        } += 1;
    }

    /// The ways in which holes were closed, with their numbers, as `9 by the level set`.
    pub fn ways(&self) -> Vec<String> {
        let ways = [
            (self.level_set, "by the level set"),
            (self.sides, "by continued sides"),
            (self.counterpart, "from a counterpart"),
            (self.faired, "by smoothed triangles"),
            (self.flat, "by flat caps"),
            (self.base, "by flat bases"),
            (self.walls, "by walls"),
            (self.seam, "by seam triangles"),
            (self.rim_triangles, "by rim triangles"),
            (self.offset_shell, "by offset shells"),
        ];
        let word = |(count, how): (usize, &str)| (count > 0).then(|| format!("{count} {how}"));
        ways.into_iter().filter_map(word).collect()
    }
}
