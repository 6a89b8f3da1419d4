//! What a run found and did, drawn: as lines of text, as a page, as a picture.

mod check;
pub mod html;
mod missed;
pub mod picture;
mod plan;
mod repair;
pub mod scene;
pub(crate) mod scripts;
mod text;

pub use check::verdict_lines;
pub use plan::plan_lines;
pub use repair::repair_lines;
pub use text::{hole_table, region_lines, summary_lines, tally_line};

#[cfg_attr(not(feature = "cli"), allow(unused_imports))]
pub(crate) use {
    crate::mesh::{length, length_beside, point},
    check::verdict_rows,
    missed::missed_lines,
    plan::left_holes,
    text::{chain_lines, counted, defect_lines, level_lines, ranges, reason, reason_lines},
};
