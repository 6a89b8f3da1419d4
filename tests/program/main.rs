//! What the program says and writes: options, exit codes, streams, reports, signals.
#![allow(clippy::unwrap_used, clippy::too_many_lines)] // A test that cannot go on fails; long ones tell one story.

#[path = "../common/desk.rs"]
mod desk;
#[path = "../common/shapes.rs"]
mod shapes;

mod cli;
mod creases;
mod deliver;
mod handed_on;
mod manual;
mod report;
mod several;
mod signals;
mod streams;
mod texels;
mod usage;
mod walls;
