//! What is shown while regions are worked on: a bar on a terminal; with `-v` a line for each region that ends.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use isomend::{Event, HoleId, Progress, RegionReport, Step};

use super::console::Console;

/// Steps of the bar.
const STEPS: u64 = 1000;

/// The bar that is drawn now, if any.
static DRAWN: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Takes the bar off the terminal, for a program that ends.
pub fn clear() {
    if let Ok(mut drawn) = DRAWN.try_lock()
        && let Some(bar) = drawn.take()
    {
        bar.finish_and_clear();
    }
}

/// Runs something that tells of its progress. On a terminal a bar shows how much is done, which holes are worked on and
/// the time left; with `-v` `line` is printed for each region as it ends.
pub fn watched<R>(
    console: &Console,
    line: fn(&RegionReport) -> String,
    run: impl FnOnce(&Progress) -> R,
) -> R {
    if console.wants_progress() {
        let bar = bar();
        *DRAWN.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar.clone());
        let busy = Mutex::new(BTreeSet::new());
        let result = run(&|step| show(&bar, &busy, step));
        clear();
        return result;
    }
    run(&|step| {
        if let Event::Ended(region) = step.event
            && region.has_surface()
        {
            console.detail(&line(region));
        }
    })
}

fn show(bar: &ProgressBar, busy: &Mutex<BTreeSet<HoleId>>, step: &Step) {
    let mut busy = busy.lock().unwrap_or_else(PoisonError::into_inner);
    match step.event {
        Event::Begun(holes) => busy.extend(holes.first()),
        Event::Ended(region) => {
            if let Some(first) = region.holes.first() {
                busy.remove(first);
            }
        }
        _ => return,
    }
    let holes: Vec<String> = busy.iter().take(4).map(HoleId::to_string).collect();
    let at = match holes.len() {
        0 => String::new(),
        1 => format!(", hole {}", holes[0]),
        _ => format!(", holes {}", holes.join(", ")),
    };
    bar.set_position((step.part * STEPS as f64) as u64);
    bar.set_message(format!("{} of {}{at}", step.done, step.all));
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
    let style =
        ProgressStyle::with_template("{spinner} {bar:30} {msg}; {elapsed}, about {eta} left");
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(120));
    bar
}
