//! The functions of the fuzz targets on mutated seeds, for a time, with the stable toolchain: see `docs/fuzzing.md`.

mod mutation;
mod worker;

use std::alloc::System;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, fs};

use anyhow::{Context, bail};
use cap::Cap;
use clap::Parser;
use isomend_fuzz::{TARGETS, Target};

/// Most memory that is allocated at a time, in bytes. Seeds and the program itself take some ten MB of it.
const MEMORY: usize = 1 << 30;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MEMORY);

/// Runs the functions of the fuzz targets on mutated seeds, or replays files.
#[derive(Debug, Parser)]
#[command(name = "mutate")]
struct Args {
    /// The targets; all of them by default.
    targets: Vec<String>,

    /// How long to run in all, in seconds.
    #[arg(long, default_value_t = 60)]
    seconds: u64,

    /// What the mutations are drawn with; the same number gives the same inputs, as many as there is time for.
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// The folder of the seeds: one folder for each target.
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/corpus"))]
    corpus: PathBuf,

    /// Where inputs that fail are left: one folder for each target.
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/artifacts"))]
    artifacts: PathBuf,

    /// Runs one target on these files instead.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    replay: Vec<PathBuf>,

    /// With --replay: writes the mesh that `fill` and `mask` make of the bytes, and what `fill` asks for, as OBJ.
    #[arg(long, value_name = "FILE", requires = "replay")]
    mesh: Option<PathBuf>,

    /// Runs one target, and writes each input to this file first.
    #[arg(long, hide = true)]
    worker: Option<PathBuf>,
}

fn main() -> anyhow::Result<ExitCode> {
    let args = Args::parse();
    let targets = chosen(&args.targets)?;
    if let Some(file) = &args.worker {
        let [(name, run)] = targets[..] else {
            bail!("a worker runs one target");
        };
        let seeds = worker::seeds(&args.corpus.join(name))?;
        worker::run(run, &seeds, args.seed, args.seconds, file)?;
        return Ok(ExitCode::SUCCESS);
    }
    if !args.replay.is_empty() {
        let [(_, run)] = targets[..] else {
            bail!("name the one target that the files are for, before --replay");
        };
        for file in &args.replay {
            let data = fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
            if let Some(mesh) = &args.mesh {
                fs::write(mesh, isomend_fuzz::as_obj(&data))
                    .with_context(|| format!("cannot write {}", mesh.display()))?;
            }
            worker::timed(run, &data);
            println!("{}: passed", file.display());
        }
        return Ok(ExitCode::SUCCESS);
    }
    let mut code = ExitCode::SUCCESS;
    let seconds = (args.seconds / targets.len() as u64).max(1);
    for (name, _) in targets {
        if !passes(name, seconds, &args)? {
            code = ExitCode::FAILURE;
        }
    }
    Ok(code)
}

/// The targets with these names, or all.
fn chosen(names: &[String]) -> anyhow::Result<Vec<(&'static str, Target)>> {
    if names.is_empty() {
        return Ok(TARGETS.to_vec());
    }
    let find = |name: &String| {
        let found = TARGETS.into_iter().find(|(n, _)| n == name);
        let all = TARGETS.map(|(n, _)| n).join(", ");
        found.with_context(|| format!("there is no target '{name}'; there are {all}"))
    };
    names.iter().map(find).collect()
}

/// Runs a target in a process of its own, so that neither an abort nor a stack overflow loses the input.
fn passes(name: &str, seconds: u64, args: &Args) -> anyhow::Result<bool> {
    let folder = args.artifacts.join(name);
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let input = folder.join(format!("running-{}", std::process::id()));
    println!(
        "{name}: {seconds} s with --seed {} on mutations of {}",
        args.seed,
        args.corpus.join(name).display()
    );
    let status = Command::new(env::current_exe()?)
        .args([name, "--seed", &args.seed.to_string()])
        .args(["--seconds", &seconds.to_string(), "--corpus"])
        .arg(&args.corpus)
        .arg("--worker")
        .arg(&input)
        .status()?;
    if status.success() {
        let _ = fs::remove_file(&input);
        return Ok(true);
    }
    if !input.exists() {
        println!("{name}: FAILED before the first input ({status})");
        return Ok(false);
    }
    let kept = folder.join(format!("mutation-{:016x}", hash(&input)?));
    fs::rename(&input, &kept)?;
    println!(
        "{name}: FAILED ({status}); to replay it:\n    {} {name} --replay {}",
        Path::new(&env::args_os().next().unwrap_or_default()).display(),
        kept.display()
    );
    Ok(false)
}

fn hash(file: &Path) -> anyhow::Result<u64> {
    let mut hasher = DefaultHasher::new();
    fs::read(file)?.hash(&mut hasher);
    Ok(hasher.finish())
}
