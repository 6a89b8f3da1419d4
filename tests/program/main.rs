//! Tests of the command line: options, exit codes, streams, reports, signals.
#![allow(clippy::unwrap_used, clippy::too_many_lines)] // An unwrap that fails is a failed test; long tests follow one scenario.

#[path = "../common/checker.rs"]
mod checker;
#[path = "../common/desk.rs"]
mod desk;
#[path = "../common/shapes.rs"]
mod shapes;

mod answers;
mod cli;
mod creases;
mod deliver;
mod documents;
mod handed_on;
mod manual;
mod mcp;
mod objects;
mod outputs;
mod packages;
mod projects;
mod report;
mod several;
mod signals;
mod solid;
mod streams;
mod texels;
mod usage;
mod volumes;
mod walls;
