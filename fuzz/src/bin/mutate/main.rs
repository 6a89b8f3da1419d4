//! The functions of the fuzz targets on mutated seeds, for a time, with the stable toolchain: see `docs/fuzzing.md`.

mod mutation;
mod worker;

use std::alloc::System;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{env, fs, thread};

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

    /// How long to run in all, in seconds. As many targets run at once as there are processors.
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
        let (count, longest) = worker::run(run, &seeds, args.seed, args.seconds, file)?;
        println!(
            "{name}: {count} inputs in {} s with --seed {}, the slowest took {:.3} s",
            args.seconds,
            args.seed,
            longest.as_secs_f64()
        );
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
    if all_pass(&targets, &args)? {
        Ok(ExitCode::SUCCESS)
    } else {
        Ok(ExitCode::FAILURE)
    }
}

/// Runs as many targets at once as there are processors, each for its share of the time.
fn all_pass(targets: &[(&'static str, Target)], args: &Args) -> anyhow::Result<bool> {
    let workers = thread::available_parallelism().map_or(1, NonZero::get);
    let workers = workers.min(targets.len());
    let seconds = (args.seconds * workers as u64 / targets.len() as u64).max(1);
    let next = AtomicUsize::new(0);
    let work = || {
        let mut right = true;
        while let Some(&(name, _)) = targets.get(next.fetch_add(1, Ordering::Relaxed)) {
            right &= passes(name, seconds, args)?;
        }
        anyhow::Ok(right)
    };
    thread::scope(|scope| {
        let running: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        let mut right = true;
        for worker in running {
            right &= worker.join().expect("a worker does not panic")?;
        }
        Ok(right)
    })
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
