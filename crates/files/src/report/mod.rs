//! Reports of runs and of meshes: lines of text, HTML pages and PNG pictures.

mod check;
mod counterpart;
mod counts;
mod fair;
mod holes;
pub mod html;
mod missed;
pub mod picture;
mod plan;
mod refused;
mod remark;
mod repair;
pub mod scene;
#[doc(hidden)]
pub mod scripts;
mod standing;
mod table;
mod text;

pub use check::verdict_lines;
pub(crate) use counts::{error_text, open_chains, percent};
pub(crate) use text::every_hole;
pub use text::{summary_lines, tally_line};

pub use {
    check::verdict_rows,
    counts::{counted, lengths_in, timed},
    fair::{cut_out, faired_measures, faired_part, joined_holes, kept_object},
    holes::{component_rows, crease_end_line, crease_end_table, hole_table},
    isomend_core::mesh::{length, length_beside, number, point, significant},
    missed::missed_lines,
    plan::{left_holes, plan_lines},
    refused::refused_lines,
    remark::Remark,
    repair::{repair_lines, repair_lines_in},
    standing::Standing,
    table::{ClosedRow, ClosedTable, closed_rows},
    text::{
        chain_lines, defect_lines, level_lines, lost_creases, named_holes, ranges, reason_lines,
        region_lines, region_lines_in, weighed_lines,
    },
};
