//! Progress of a job: a bar on a terminal, or with `-v` a line for each region that is finished.

use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use isomend::{Event, HoleId, RegionReport, Step};

use super::console::Console;

/// Steps of the bar.
const STEPS: u64 = 1000;

/// Receives the share of the work that is done, where the program runs in a browser.
#[cfg(target_family = "wasm")]
static RECEIVER: std::sync::OnceLock<fn(f64)> = std::sync::OnceLock::new();

/// Lets a function receive the share of the work that is done.
#[cfg(target_family = "wasm")]
pub fn report_progress(receiver: fn(f64)) {
    // Set only once, since a program runs one command.
    let _ = RECEIVER.set(receiver);
}

/// The current progress bar, if one is drawn.
static DRAWN: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Removes the bar from the terminal.
pub fn clear() {
    if let Ok(mut drawn) = DRAWN.try_lock()
        && let Some(bar) = drawn.take()
    {
        bar.finish_and_clear();
    }
}

/// Shows the progress of the regions of a job. On a terminal a bar shows how much is done, the current holes and the time left; with `-v`
/// there is a line for each region that is finished.
pub struct RegionProgress<'a> {
    console: Console,
    line: &'a (dyn Fn(&RegionReport) -> String + Sync),
    busy: Mutex<BTreeSet<HoleId>>,
}

impl<'a> RegionProgress<'a> {
    /// Shows nothing yet; `line` makes the line for a region.
    pub fn new(console: Console, line: &'a (dyn Fn(&RegionReport) -> String + Sync)) -> Self {
        Self {
            console,
            line,
            busy: Mutex::default(),
        }
    }

    /// Draws the bar if one is wanted; [`clear`] removes it.
    pub fn begin(&self) {
        if self.console.wants_progress() {
            self.busy().clear();
            *drawn() = Some(bar());
        }
    }

    /// Shows a step.
    pub fn step(&self, step: &Step) {
        #[cfg(target_family = "wasm")]
        if let Some(receive) = RECEIVER.get() {
            receive(step.part);
        }
        let bar = drawn().clone();
        match (bar, &step.event) {
            (Some(bar), _) => show(&bar, &mut self.busy(), step),
            (None, Event::Ended(region)) if region.has_surface() => {
                self.console.detail(&(self.line)(region));
            }
            _ => {}
        }
    }

    fn busy(&self) -> MutexGuard<'_, BTreeSet<HoleId>> {
        self.busy.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn drawn() -> MutexGuard<'static, Option<ProgressBar>> {
    DRAWN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Updates the bar when a region begins or ends.
fn show(bar: &ProgressBar, busy: &mut BTreeSet<HoleId>, step: &Step) {
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
