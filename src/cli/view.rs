//! `isomend view`: serves an interactive page for the browser.

use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;
use std::process::{Command as Process, Stdio};

use clap::Args;
use isomend::io::Format;
use isomend_view::{Settings, serve};

use super::console::{self, Console};
use super::input::is_stream;
use super::words::CommandLine;
use super::{End, RunArgs, Usage, arguments, interrupt};

const EXAMPLES: &str = "\
Examples:
  isomend view scan.ply                     opens the browser
  isomend view scan.ply --no-browser        only prints the address to open
  isomend view scan.ply --resume            repeats the unsaved steps of the last session
  ssh -L 8080:127.0.0.1:8080 host isomend view scan.ply --port 8080 --no-browser
                                            on a remote machine: use the same port on both, and open the printed address";

/// Open a page in the browser: view, choose holes, paint, mend, compare, undo, save.
///
/// The program serves the page itself, to this machine only; no network is needed. The address contains a secret, and requests without it
/// are refused. Steps are commands of this program; the page shows the command lines that do the same.
///
/// Ctrl-C ends it. Steps that were not saved are kept in a file in the user's state folder; --resume repeats them.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ViewArgs {
    /// The mesh: OBJ, PLY, STL, glTF, GLB, VTK legacy, VTP, OFF, 3MF or USD; or a folder, whose meshes are listed.
    #[arg(value_name = "IN")]
    input: PathBuf,

    /// The port to listen on [default: a free one].
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    port: u16,

    /// The address to listen on. Addresses other than 127.0.0.1 and ::1 give other machines access, unencrypted.
    #[arg(long, value_name = "ADDR", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    listen: IpAddr,

    /// Do not open the browser.
    #[arg(long)]
    no_browser: bool,

    /// The folder in which the page may write files, with its subfolders [default: the folder of the mesh, or the folder that is listed].
    #[arg(long, value_name = "DIR")]
    root: Option<PathBuf>,

    /// Repeat the unsaved steps of an earlier session. To use another session file than the default, name it after an equals sign.
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    resume: Option<Option<PathBuf>>,

    /// Format of the input: obj, ply, stl, gltf, glb, vtk, vtp, off, 3mf, usda or usdz.
    ///
    /// By default the format is detected from the content, else from the extension.
    #[arg(long, value_name = "FORMAT", value_parser = arguments::format)]
    from: Option<Format>,

    #[command(flatten)]
    pub(super) run: RunArgs,
}

/// Serves the page until Ctrl-C.
pub fn run(args: &ViewArgs) -> anyhow::Result<End> {
    let console = Console::new(args.run.quiet, args.run.verbose);
    if is_stream(&args.input) {
        let what = "view needs a file: the command lines that it shows could not read standard input again";
        return Err(Usage(what.to_owned()).into());
    }
    let settings = Settings {
        input: args.input.clone(),
        from: args.from,
        listen: args.listen,
        port: args.port,
        root: args.root.clone(),
        threads: args.run.threads.unwrap_or(0),
        words: Box::new(CommandLine),
        resume: args.resume.clone(),
    };
    if !args.listen.is_loopback() {
        console.warn(
            "other machines can reach the page: its address gives access to the files of the folder and is sent over the network \
             unencrypted; an ssh tunnel to 127.0.0.1 is safer",
        );
    }
    let mut failed = None;
    serve(settings, |address| {
        if let Some(file) = &address.earlier {
            console.note(&format!(
                "steps of an earlier session were not saved: they are kept in {}, and --resume repeats them",
                file.display()
            ));
        }
        let unsaved = address.unsaved;
        interrupt::is_normal_end(move || {
            for file in unsaved() {
                console.say(&format!(
                    "steps that were not saved are kept in {}; --resume repeats them",
                    file.display()
                ));
            }
        });
        failed = console::print_out(&format!("{}\n", address.page)).err();
        console.say("Ctrl-C ends it");
        if !args.no_browser && args.listen.is_loopback() {
            open(&address.once, console);
        }
    })?;
    failed.map_or(Ok(End::Done), Err)
}

/// Opens an address in the system's default browser.
fn open(address: &str, console: Console) {
    let (program, before): (&str, &[&str]) = match std::env::consts::OS {
        "macos" => ("open", &[]),
        "windows" => ("rundll32", &["url.dll,FileProtocolHandler"]),
        _ => ("xdg-open", &[]),
    };
    let started = Process::new(program)
        .args(before)
        .arg(address)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    if started.is_err() {
        console.say("no browser could be opened; open the address above in one");
    }
}
