//! Calls of tools that wait or run: their tokens, by which the client stops them, and their progress.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use isomend::Cancel;
use serde_json::{Map, Value, json};

/// Least time between two messages on the progress of a call.
const PAUSE: Duration = Duration::from_millis(250);

/// A call of a tool.
pub struct Call {
    /// The id of the request.
    pub id: Value,
    /// The name of the tool.
    pub tool: String,
    /// Its arguments.
    pub arguments: Map<String, Value>,
    /// The client's token for messages on the progress, if it wants them.
    pub progress: Option<Value>,
    /// Stops the call.
    pub cancel: Cancel,
}

/// The calls that wait or run, by the ids of their requests.
#[derive(Default)]
pub struct OpenCalls(Mutex<Vec<(Value, Cancel)>>);

impl OpenCalls {
    /// Adds a call; `false` if one of this id is open.
    pub fn open(&self, call: &Call) -> bool {
        let mut open = self.locked();
        let is_new = open.iter().all(|(id, _)| *id != call.id);
        if is_new {
            open.push((call.id.clone(), call.cancel.clone()));
        }
        is_new
    }

    /// Removes a call.
    pub fn close(&self, id: &Value) {
        self.locked().retain(|(open, _)| open != id);
    }

    /// Stops the call of an id, if it is open.
    pub fn cancel(&self, id: &Value) {
        let open = self.locked();
        open.iter()
            .filter(|(open, _)| open == id)
            .for_each(|(_, cancel)| cancel.cancel());
    }

    /// Stops all calls.
    pub fn cancel_all(&self) {
        self.locked().iter().for_each(|(_, cancel)| cancel.cancel());
    }

    fn locked(&self) -> std::sync::MutexGuard<'_, Vec<(Value, Cancel)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Decides which steps of a call are reported: at most one each [`PAUSE`], and only if more is done, as the protocol demands.
pub struct CallProgress {
    token: Value,
    last: Mutex<(Instant, f64)>,
}

impl CallProgress {
    /// The progress of a call that begins now.
    pub fn new(token: Value) -> Self {
        Self {
            token,
            last: Mutex::new((Instant::now(), 0.0)),
        }
    }

    /// The parameters of a message that a part (0 to 1) is done; none if it is not worth one.
    pub fn message(&self, part: f64) -> Option<Value> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if part <= last.1 || last.0.elapsed() < PAUSE {
            return None;
        }
        *last = (Instant::now(), part);
        Some(json!({ "progressToken": self.token, "progress": part, "total": 1 }))
    }
}
