//! The local page of `isomend view`: a web server for a browser on the same machine. The user views a mesh, chooses holes and regions,
//! runs, undoes and saves steps, and gets a recipe of commands that repeat them.
//!
//! Every step is a job from file to file, with intermediate files in memory: the page shows after a step what the next command would
//! read. The commands of a recipe ([`Command`]) therefore give the same bytes.

mod api;
mod app;
mod assets;
mod choices;
mod connections;
mod container;
mod deliver;
mod delta;
mod deviation;
mod errors;
mod events;
mod files;
mod gate;
mod pages;
mod recipe;
mod runs;
mod save;
mod server;
mod session;
mod state;
mod step;
mod store;
mod texture;
mod token;
mod words;

pub use server::{Address, Settings, ViewError, serve};
pub use store::ResumeError;
pub use words::{Command, CommandRenderer};
