//! One target, run on one input after the other.

use std::path::Path;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};
use std::{fs, process, thread};

use anyhow::{Context, ensure};
use fastrand::Rng;
use isomend_fuzz::Target;

use super::mutation::mutate;

/// An input that takes longer counts as one that never ends.
const LONGEST: Duration = Duration::from_secs(5);

/// The files of a folder, in the order of their names.
pub fn seeds(folder: &Path) -> anyhow::Result<Vec<Vec<u8>>> {
    let advice = || {
        format!(
            "there are no seeds in {}; scripts/fuzz_seeds.py makes them",
            folder.display()
        )
    };
    let entries = fs::read_dir(folder).with_context(advice)?;
    let mut paths = Vec::new();
    for entry in entries {
        paths.push(entry?.path());
    }
    paths.sort();
    ensure!(!paths.is_empty(), advice());
    let files = paths.iter().map(fs::read);
    Ok(files.collect::<Result<_, _>>()?)
}

/// Runs a target on the seeds, then on mutations of them until the time is over. Each input is in `file` before it is run. Returns their
/// number and the longest time.
pub fn run(
    target: Target,
    seeds: &[Vec<u8>],
    seed: u64,
    seconds: u64,
    file: &Path,
) -> anyhow::Result<(usize, Duration)> {
    let mut rng = Rng::with_seed(seed);
    let end = Instant::now() + Duration::from_secs(seconds);
    let watch = watch();
    let (mut count, mut longest) = (0, Duration::ZERO);
    while count < seeds.len() || Instant::now() < end {
        let data = match seeds.get(count) {
            Some(seed) => seed.clone(),
            None => mutate(seeds, &mut rng),
        };
        fs::write(file, &data).with_context(|| format!("cannot write {}", file.display()))?;
        let _ = watch.send(true);
        let clock = Instant::now();
        target(&data);
        longest = longest.max(clock.elapsed());
        let _ = watch.send(false);
        count += 1;
    }
    Ok((count, longest))
}

/// Runs a target on one input, within the same limits.
pub fn timed(target: Target, data: &[u8]) {
    let watch = watch();
    let _ = watch.send(true);
    target(data);
}

/// A thread that ends the process when an input takes too long: it is told when one begins and when it is done.
fn watch() -> Sender<bool> {
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        let mut running = false;
        loop {
            let message = if running {
                receiver.recv_timeout(LONGEST)
            } else {
                receiver.recv().map_err(|_| RecvTimeoutError::Disconnected)
            };
            match message {
                Ok(begins) => running = begins,
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => {
                    eprintln!("an input takes more than {} s", LONGEST.as_secs());
                    process::exit(1);
                }
            }
        }
    });
    sender
}
