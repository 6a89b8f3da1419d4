//! The page of `isomend view`: its server, its sessions, its recipes.

#[path = "../common/desk.rs"]
mod desk;
#[path = "../common/served.rs"]
mod served;
#[path = "../common/shapes.rs"]
mod shapes;

mod recipes;
mod requests;
mod sessions;
