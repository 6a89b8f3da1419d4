//! Tests of stitching.

mod cases;
mod input;
pub mod shapes;
