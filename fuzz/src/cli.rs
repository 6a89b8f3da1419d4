//! Parts of the command line, which is in the binary and not in the library.
#![allow(dead_code)]

#[path = "../../src/cli/arguments.rs"]
pub mod arguments;
#[path = "../../src/cli/config.rs"]
pub mod config;
#[path = "../../src/cli/mask.rs"]
pub mod mask;
#[path = "../../src/cli/parameters.rs"]
pub mod parameters;
