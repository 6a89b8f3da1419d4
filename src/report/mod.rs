//! What a run found and did, drawn: as lines of text, as a page, as a picture.

mod check;
pub mod html;
mod missed;
pub mod picture;
mod plan;
mod repair;
pub mod scene;
mod text;

pub use crate::mesh::{length, length_beside, point};
pub use check::{verdict_lines, verdict_rows};
pub use missed::missed_lines;
pub use plan::{left_holes, plan_lines};
pub use repair::repair_lines;
pub use text::{
    chain_lines, counted, defect_lines, hole_table, level_lines, ranges, reason, reason_lines,
    region_lines, summary_lines, tally_line,
};
