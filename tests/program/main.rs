//! What the program says and writes: options, exit codes, streams, reports, signals.

#[path = "../common/desk.rs"]
mod desk;
#[path = "../common/shapes.rs"]
mod shapes;

mod cli;
mod manual;
mod report;
mod signals;
mod streams;
mod unfinished;
mod usage;
