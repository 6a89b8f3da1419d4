//! What the page is told while it is open: server-sent events.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tokio::sync::broadcast::{self, Receiver, Sender};

use crate::mend::{Event, Step};
use crate::report::region_lines;

/// Events that a page may be behind before it is told to look at everything anew.
const BACKLOG: usize = 256;
/// Least time between two tellings of progress.
const BETWEEN: Duration = Duration::from_millis(50);

/// Tells all pages that listen.
pub struct Events(Sender<String>);

impl Default for Events {
    fn default() -> Self {
        Self(broadcast::channel(BACKLOG).0)
    }
}

impl Events {
    /// Tells something.
    pub fn tell(&self, name: &str, data: &Value) {
        // Nobody may listen.
        let _ = self.0.send(event(name, data));
    }

    /// What is told from now on.
    pub fn listen(&self) -> Receiver<String> {
        self.0.subscribe()
    }
}

/// An event as it goes over the wire.
pub fn event(name: &str, data: &Value) -> String {
    format!("event: {name}\ndata: {data}\n\n")
}

/// Tells of the progress of a job, not too often.
pub struct Teller<'a> {
    events: &'a Events,
    job: u64,
    last: Mutex<(Option<Instant>, String)>,
}

impl<'a> Teller<'a> {
    /// Of a job.
    pub fn new(events: &'a Events, job: u64) -> Self {
        let last = Mutex::default();
        Self { events, job, last }
    }

    /// Tells of a step.
    pub fn step(&self, step: &Step) {
        let (stage, region) = match step.event {
            Event::Begun(holes) => ("begun", holes.first().copied()),
            Event::Ended(report) => ("ended", report.holes.first().copied()),
            _ => ("working", None),
        };
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Event::Ended(report) = step.event
            && report.has_surface()
        {
            last.1 = region_lines(report);
        }
        if last.0.is_some_and(|at| at.elapsed() < BETWEEN) {
            return;
        }
        let data = json!({
            "job": self.job, "region": step.done, "regions": step.all, "hole": region, "stage": stage,
            "share": step.part, "line": last.1,
        });
        *last = (Some(Instant::now()), String::new());
        self.events.tell("progress", &data);
    }
}
