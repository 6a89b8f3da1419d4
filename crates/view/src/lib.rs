//! The local page of `isomend view`: a web server for a browser on the same machine. The user views a mesh, chooses holes and regions,
//! runs, undoes and saves steps, and gets a recipe of commands that repeat them.
//!
//! Every step is a job from file to file, with intermediate files in memory: the page shows after a step what the next command would
//! read. The commands of a recipe ([`Command`]) therefore give the same bytes.
#![warn(missing_docs)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod api;
mod app;
mod assets;
mod choices;
mod clusters;
#[cfg(not(target_family = "wasm"))]
mod connections;
mod container;
mod deliver;
mod delta;
mod deviation;
mod errors;
mod events;
mod files;
#[cfg(not(target_family = "wasm"))]
mod gate;
#[cfg(any(test, target_family = "wasm"))]
mod in_browser;
mod kept;
mod named;
mod opened;
#[cfg(not(target_family = "wasm"))]
mod pages;
mod recent;
mod recipe;
mod revisions;
mod runs;
mod save;
#[cfg(not(target_family = "wasm"))]
mod server;
mod session;
mod state;
mod step;
mod store;
mod texture;
#[cfg(not(target_family = "wasm"))]
mod token;
mod walls;
mod words;

pub use files::{Denied, to_read, to_write};
#[cfg(target_family = "wasm")]
pub use in_browser::InBrowser;
pub use opened::ViewError;
#[cfg(not(target_family = "wasm"))]
pub use server::{Address, Settings, serve};
pub use store::ResumeError;
pub use words::{Command, CommandRenderer};
