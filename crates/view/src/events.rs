//! Server-sent events: changes of the session and the progress of jobs.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tokio::sync::broadcast::{self, Receiver, Sender};

use isomend_core::mend::{Event, Step};
use isomend_files::report::region_lines;

/// Number of undelivered events above which a page must fetch the whole state again.
const BACKLOG: usize = 256;
/// Shortest time between two events of progress.
const BETWEEN: Duration = Duration::from_millis(50);

/// Receives an event in the text format of server-sent events.
pub type Receive = dyn Fn(&str) + Send + Sync;

/// Broadcasts events to all connected pages.
pub struct Events {
    channel: Sender<String>,
    /// Receives each event at once, while the work goes on.
    receive: Option<Box<Receive>>,
}

impl Default for Events {
    fn default() -> Self {
        Self {
            channel: broadcast::channel(BACKLOG).0,
            receive: None,
        }
    }
}

impl Events {
    /// Sends an event.
    pub fn send(&self, name: &str, data: &Value) {
        let text = event(name, data);
        if let Some(receive) = &self.receive {
            receive(&text);
        }
        // Sending fails if no page is connected, which is no error.
        let _ = self.channel.send(text);
    }

    /// Receives the events from now on.
    pub fn listen(&self) -> Receiver<String> {
        self.channel.subscribe()
    }

    /// Events that also call a function at once.
    #[cfg(any(test, target_family = "wasm"))]
    pub fn to(receive: Box<Receive>) -> Self {
        Self {
            receive: Some(receive),
            ..Self::default()
        }
    }
}

/// An event in the text format of server-sent events.
pub fn event(name: &str, data: &Value) -> String {
    format!("event: {name}\ndata: {data}\n\n")
}

/// Sends events of the progress of a job, at most every 50 ms.
pub struct ProgressSender<'a> {
    events: &'a Events,
    job: u64,
    /// Time of the last event, and the summary of the last finished region that was not sent yet.
    last: Mutex<(Option<Instant>, String)>,
}

impl<'a> ProgressSender<'a> {
    /// A sender for a job.
    pub fn new(events: &'a Events, job: u64) -> Self {
        let last = Mutex::default();
        Self { events, job, last }
    }

    /// Sends the progress of a step.
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
        self.events.send("progress", &data);
    }
}
