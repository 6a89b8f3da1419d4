//! `isomend mcp`: the tools inspect, check, fill and repair for agents, by the Model Context Protocol on standard input and output.
//!
//! Messages are JSON-RPC 2.0, one a line. A thread reads them and answers at once what takes no time; calls of tools run one after another,
//! so that each has all threads. No network is used.

mod calls;
mod rpc;
mod server;
mod tools;

use std::io::BufReader;
use std::path::PathBuf;
use std::sync::mpsc::sync_channel;

use anyhow::Context;
use clap::{Args, ValueHint};
use isomend::io::canonical;

use self::server::Server;
use self::tools::Tools;
use super::console::Console;
use super::{End, RunArgs, Usage};

/// Most calls that wait for their turn; further ones are refused.
const MOST_WAITING: usize = 64;

const EXAMPLES: &str = "\
Examples:
  isomend mcp --folder scans                the command that an agent's settings name
  isomend mcp --folder scans --read-only    only inspect and check
  echo '{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"tools/list\"}' | isomend mcp --folder . -q";

/// Serve agents by the Model Context Protocol: tools that inspect, check, fill and repair the meshes of a folder.
///
/// Messages are read from standard input and answered on standard output. The tools take the parameters of the commands and return their
/// JSON reports. They read and write files below the folder only; links out of it are not followed, and no network is used.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct McpArgs {
    /// The folder whose files the tools may read and write, with its subfolders.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    folder: PathBuf,

    /// Offer only the tools that write nothing: inspect and check.
    #[arg(long)]
    read_only: bool,

    #[command(flatten)]
    pub(super) run: RunArgs,
}

/// Serves until standard input ends; calls that wait then are still answered.
pub fn run(args: &McpArgs, console: &Console) -> anyhow::Result<End> {
    let folder = args.folder.display();
    let root = canonical(&args.folder).with_context(|| format!("there is no folder {folder}"))?;
    if !root.is_dir() {
        return Err(Usage(format!("{folder} is not a folder: name one with --folder")).into());
    }
    console.say(&format!(
        "serving the meshes below {folder}; it ends when standard input ends"
    ));
    let server = Server::new(Tools::new(root, args.read_only));
    let (send, waiting) = sync_channel(MOST_WAITING);
    std::thread::scope(|scope| {
        let server = &server;
        let reader = std::thread::Builder::new().name("messages".to_owned());
        reader
            .spawn_scoped(scope, move || {
                server.read(BufReader::new(std::io::stdin()), &send);
            })
            .context("cannot start a thread to read messages")?;
        // The calls run here, in the pool of threads of the command.
        for call in waiting {
            server.answer(call);
        }
        match server.is_unread() {
            true => Ok(End::Unread),
            false => Ok(End::Done),
        }
    })
}
