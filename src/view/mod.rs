//! The local page: a server for a browser on the same machine. A mesh is seen, holes and regions are chosen, steps are made, undone and
//! saved, and told as commands that do the same.
//!
//! Every step is a job from a file to a file, the files between two steps but in memory: what the page shows after a step is what
//! the next command would read. So the commands of [`Command`] give the same bytes.

mod api;
mod app;
mod assets;
mod choices;
mod connections;
mod container;
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
pub use words::{Command, Words};
