//! Tests of the library: filling, restoring, fairing, repairing, checking and measuring meshes.
#![allow(clippy::unwrap_used, clippy::too_many_lines)] // An unwrap that fails is a failed test; long tests follow one scenario.

#[cfg(target_os = "linux")]
#[path = "../common/cpu.rs"]
mod cpu;
#[path = "../common/desk.rs"]
mod desk;
#[path = "../common/shapes.rs"]
mod shapes;

mod accuracy;
mod apart;
mod attributes;
mod base;
mod check;
mod chips;
mod convergence;
mod counterpart;
mod creases;
mod energies;
mod examples;
mod fair;
mod faults;
mod flat;
mod grain;
mod habits;
mod high_valence;
mod invariants;
mod job;
mod masks;
mod odd_meshes;
mod order;
mod outcomes;
mod regions;
mod repair;
mod repair_bytes;
mod repair_contacts;
mod repair_folds;
mod repair_inside_out;
mod repair_plans;
mod repair_seams;
mod repair_solid;
mod repair_union;
mod repair_unions;
mod repair_walls;
mod repair_worst;
mod restore;
mod study;
mod tasks;
mod volumes;
