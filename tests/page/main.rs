//! Tests of the page of `isomend view`: its server, sessions, recipes and texts.
#![allow(clippy::unwrap_used, clippy::too_many_lines)] // An unwrap that fails is a failed test; long tests follow one scenario.

#[path = "../common/desk.rs"]
mod desk;
#[allow(dead_code)] // The tests of the program use all of it.
#[path = "../program/packages.rs"]
mod packages;
#[path = "../common/served.rs"]
mod served;
#[path = "../common/shapes.rs"]
mod shapes;

mod deliver;
mod differences;
mod files;
mod like;
mod masks;
mod print;
mod recipes;
mod requests;
mod sessions;
mod words;
