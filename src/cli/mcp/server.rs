//! The server of the Model Context Protocol: answers messages, and runs calls of tools.

use std::io::BufRead;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Mutex, PoisonError};

use isomend::job::PANICKED;
use isomend::{Cancel, Control, Step};
use serde_json::{Map, Value, json};

use super::calls::{Call, CallProgress, OpenCalls};
use super::rpc::{self, Message};
use super::tools::Tools;
use crate::cli::console;

/// Versions of the protocol that the server speaks, the latest first. Version 2025-03-26 demands batches, which are not supported.
const VERSIONS: [&str; 2] = ["2025-06-18", "2024-11-05"];

const INSTRUCTIONS: &str = "Call check or inspect on a mesh before fill or repair. The reports list each hole and defect; a fill whose report \
    has \"complete\": false left a hole open and says why. Lengths are in the units of the mesh. Paths are relative to the folder of the server.";

/// The server of one client.
pub struct Server {
    tools: Tools,
    open: OpenCalls,
    /// Held while a message is written, so that messages do not mix.
    output: Mutex<()>,
    /// Whether the client has closed the output.
    is_unread: AtomicBool,
}

impl Server {
    pub fn new(tools: Tools) -> Self {
        Self {
            tools,
            open: OpenCalls::default(),
            output: Mutex::new(()),
            is_unread: AtomicBool::new(false),
        }
    }

    /// Whether the client has closed the output.
    pub fn is_unread(&self) -> bool {
        self.is_unread.load(Ordering::Relaxed)
    }

    /// Reads messages to the end of the input. Calls of tools are passed on, all others answered.
    pub fn read(&self, mut input: impl BufRead, calls: &SyncSender<Call>) {
        while let Ok(Some(line)) = rpc::next_line(&mut input) {
            match line {
                Ok(line) if line.trim_ascii().is_empty() => {}
                Ok(line) => self.receive(rpc::parsed(&line), calls),
                Err(()) => {
                    let what = "the message is too long";
                    self.send(&rpc::error(&Value::Null, rpc::INVALID_REQUEST, what));
                }
            }
            if self.is_unread() {
                self.open.cancel_all();
                break;
            }
        }
    }

    fn receive(&self, message: Message, calls: &SyncSender<Call>) {
        match message {
            Message::Request { id, method, params } => {
                let answered = match &method[..] {
                    "initialize" => Ok(initialised(&params)),
                    "ping" => Ok(json!({})),
                    "tools/list" => Ok(json!({ "tools": self.tools.list() })),
                    "tools/call" => return self.enqueue(id, params, calls),
                    _ => Err((
                        rpc::METHOD_NOT_FOUND,
                        format!("there is no method '{method}'"),
                    )),
                };
                self.send(&match answered {
                    Ok(result) => rpc::answer(&id, result),
                    Err((code, what)) => rpc::error(&id, code, &what),
                });
            }
            Message::Notification { method, params } if method == "notifications/cancelled" => {
                if let Some(id) = params.get("requestId") {
                    self.open.cancel(id);
                }
            }
            Message::Notification { .. } | Message::Answer => {}
            Message::Wrong(id, code, what) => self.send(&rpc::error(&id, code, what)),
        }
    }

    /// Passes a call of a tool on, if it is one.
    fn enqueue(&self, id: Value, mut params: Map<String, Value>, calls: &SyncSender<Call>) {
        let refuse = |what: &str| self.send(&rpc::error(&id, rpc::INVALID_PARAMS, what));
        let Some(Value::String(tool)) = params.remove("name") else {
            return refuse("\"name\" must be the name of a tool");
        };
        if !self.tools.has(&tool) {
            return refuse(&format!("there is no tool '{tool}'; tools/list lists them"));
        }
        let arguments = match params.remove("arguments") {
            None | Some(Value::Null) => Map::new(),
            Some(Value::Object(arguments)) => arguments,
            Some(_) => return refuse("\"arguments\" must be an object"),
        };
        let progress = params.get("_meta").and_then(|m| m.get("progressToken"));
        let call = Call {
            progress: progress.cloned(),
            id: id.clone(),
            tool,
            arguments,
            cancel: Cancel::new(),
        };
        if !self.open.open(&call) {
            return refuse("a call with this id is not answered yet");
        }
        if calls.try_send(call).is_err() {
            self.open.close(&id);
            refuse("too many calls wait for their turn; wait for answers first");
        }
    }

    /// Runs a call and answers it. A call that was stopped gets no answer.
    pub fn answer(&self, call: Call) {
        let progress = call.progress.clone().map(CallProgress::new);
        let report = |step: &Step| {
            if let Some(message) = progress.as_ref().and_then(|p| p.message(step.part)) {
                self.send(&rpc::notification("notifications/progress", message));
            }
        };
        let control = Control::new().cancel(&call.cancel).progress(&report);
        let done = match call.cancel.is_cancelled() {
            true => Err(String::new()),
            false => self.done(&call, &control),
        };
        self.open.close(&call.id);
        if call.cancel.is_cancelled() {
            return;
        }
        let result = match done {
            Ok(document) => json!({
                "content": [{ "type": "text", "text": document.to_string() }],
                "structuredContent": document,
                "isError": false,
            }),
            Err(what) => {
                json!({ "content": [{ "type": "text", "text": what }], "isError": true })
            }
        };
        self.send(&rpc::answer(&call.id, result));
    }

    /// The document of a tool, or the message of its error. A fault of isomend does not end the server.
    fn done(&self, call: &Call, control: &Control) -> Result<Value, String> {
        let run = || {
            let arguments = call.arguments.clone();
            self.tools.call(&call.tool, arguments, control)
        };
        match catch_unwind(AssertUnwindSafe(run)) {
            Ok(done) => done.map_err(|error| format!("{error:#}")),
            Err(_) => Err(PANICKED.to_owned()),
        }
    }

    fn send(&self, message: &Value) {
        let _writing = self.output.lock().unwrap_or_else(PoisonError::into_inner);
        if console::write_file((message.to_string() + "\n").as_bytes()).is_err() {
            self.is_unread.store(true, Ordering::Relaxed);
        }
    }
}

/// The answer to `initialize`: the client's version of the protocol if the server speaks it, else the latest that it speaks.
fn initialised(params: &Map<String, Value>) -> Value {
    let wanted = params.get("protocolVersion").and_then(Value::as_str);
    let version = VERSIONS.into_iter().find(|v| Some(*v) == wanted);
    json!({
        "protocolVersion": version.unwrap_or(VERSIONS[0]),
        "capabilities": { "tools": {} },
        "serverInfo": { "name": "isomend", "version": env!("CARGO_PKG_VERSION") },
        "instructions": INSTRUCTIONS,
    })
}
