//! Test helper: the server of `isomend view` in a temporary folder, and an HTTP client.
#![allow(dead_code)] // Each test file uses some of it.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::desk::{Desk, STATE};

/// Upper bound of any wait, on a machine that is busy with other tests.
const LONG: Duration = Duration::from_secs(120);

/// A server that runs until it is dropped.
pub struct Served<'d> {
    pub desk: &'d Desk,
    child: Child,
    pub port: u16,
    pub token: String,
}

/// An HTTP answer.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|error| {
            panic!("{error} in {:?}", String::from_utf8_lossy(&self.body));
        })
    }
}

impl<'d> Served<'d> {
    /// Starts the server on a file of the desk.
    pub fn new(desk: &'d Desk, arguments: &[&str]) -> Self {
        let mut child = Command::new(assert_cmd::cargo::cargo_bin("isomend"))
            .current_dir(desk.0.path())
            .arg("view")
            .args(arguments)
            .args(["--no-browser", "--threads", "2"])
            .env("XDG_STATE_HOME", desk.path(STATE))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        let out = child.stdout.take().unwrap();
        BufReader::new(out).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("http://").expect(&line);
        let mut parts = address.split('/');
        let host = parts.next().unwrap();
        let port = host.rsplit(':').next().unwrap().parse().unwrap();
        let token = parts.next().unwrap().to_owned();
        assert_eq!(token.len(), 43, "{line}");
        Self {
            desk,
            child,
            port,
            token,
        }
    }

    pub fn host(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    /// Sends bytes and reads the whole answer.
    pub fn raw(&self, request: &[u8]) -> Answer {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(LONG)).unwrap();
        // A request that is refused may not be read to its end.
        let _ = stream.write_all(request);
        let mut bytes = Vec::new();
        let _ = stream.read_to_end(&mut bytes);
        let end = bytes.windows(4).position(|w| w == b"\r\n\r\n");
        let end = end.unwrap_or_else(|| panic!("{:?}", String::from_utf8_lossy(&bytes)));
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
        Answer {
            status: head.split(' ').nth(1).unwrap().parse().unwrap(),
            head: head.to_ascii_lowercase(),
            body: bytes[end + 4..].to_vec(),
        }
    }

    /// Sends a request with the given headers, `Connection` and `Content-Length`.
    pub fn ask(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Answer {
        let mut text = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\n");
        for (name, value) in headers {
            text += &format!("{name}: {value}\r\n");
        }
        text += &format!("Content-Length: {}\r\n\r\n", body.len());
        self.raw(&[text.as_bytes(), body].concat())
    }

    /// Sends a GET request as the page does.
    pub fn get(&self, path: &str) -> Answer {
        let path = format!("/{}/{path}", self.token);
        self.ask("GET", &path, &[("Host", &self.host())], b"")
    }

    pub fn post_bytes(&self, path: &str, body: &[u8]) -> Answer {
        let path = format!("/{}/{path}", self.token);
        let origin = format!("http://{}", self.host());
        let headers = [
            ("Host", &self.host()[..]),
            ("Origin", &origin),
            ("Sec-Fetch-Site", "same-origin"),
            ("Content-Type", "application/json"),
        ];
        self.ask("POST", &path, &headers, body)
    }

    pub fn post(&self, path: &str, body: &Value) -> Answer {
        self.post_bytes(path, body.to_string().as_bytes())
    }

    pub fn state(&self) -> Value {
        let answer = self.get("api/state");
        assert_eq!(answer.status, 200);
        answer.json()
    }

    /// Waits until a condition on the state holds.
    #[track_caller]
    pub fn wait(&self, holds: impl Fn(&Value) -> bool) -> Value {
        let begun = Instant::now();
        loop {
            let state = self.state();
            if holds(&state) {
                return state;
            }
            assert!(begun.elapsed() < LONG, "{state}");
            sleep(Duration::from_millis(20));
        }
    }

    /// Makes a step and waits for its end; returns the state, whose current mesh must have changed.
    #[track_caller]
    pub fn step(&self, step: &Value) -> Value {
        let before = self.state()["current"].clone();
        let answer = self.post("api/step", step);
        assert_eq!(answer.status, 202, "{}", answer.json());
        let state = self.wait(|s| s["busy"].is_null());
        assert_ne!(state["current"], before, "{state}");
        state
    }

    #[track_caller]
    pub fn save(&self, kind: &str, path: &str) -> Value {
        let answer = self.post("api/save", &json!({ "kind": kind, "path": path }));
        assert_eq!(answer.status, 200, "{}", answer.json());
        answer.json()
    }

    /// The arrays of a binary answer: the header, and the bytes of each array by its name.
    pub fn arrays(&self, path: &str) -> (Value, impl Fn(&str) -> Vec<u8> + use<>) {
        let answer = self.get(path);
        assert_eq!(answer.status, 200);
        let length = u32::from_le_bytes(answer.body[..4].try_into().unwrap()) as usize;
        let header: Value = serde_json::from_slice(&answer.body[4..4 + length]).unwrap();
        let (layout, body) = (header.clone(), answer.body[4 + length..].to_vec());
        let array = move |name: &str| {
            let mut at = 0usize;
            for array in layout["arrays"].as_array().unwrap() {
                let size = match array["type"].as_str().unwrap() {
                    "u8" => 1,
                    "u16" => 2,
                    _ => 4,
                };
                let count =
                    array["count"].as_u64().unwrap() * array["components"].as_u64().unwrap();
                let bytes = size * count as usize;
                if array["name"] == name {
                    return body[at..at + bytes].to_vec();
                }
                at += bytes.next_multiple_of(4);
            }
            panic!("no array {name} in {layout}");
        };
        (header, array)
    }

    /// Sends a signal, waits for the end, and returns the exit code and the text on standard error.
    #[cfg(unix)]
    pub fn signalled(mut self, signal: &str) -> (Option<i32>, String) {
        let id = self.child.id().to_string();
        let sent = Command::new("kill").args([signal, &id]).status().unwrap();
        assert!(sent.success());
        let status = self.child.wait().unwrap();
        let mut said = String::new();
        let mut stderr = self.child.stderr.take().unwrap();
        stderr.read_to_string(&mut said).unwrap();
        (status.code(), said)
    }

    /// Whether the server still runs.
    pub fn lives(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }
}

impl Drop for Served<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The faces of the current mesh whose corners are all in a ball, as ranges.
pub fn in_ball(served: &Served, centre: [f32; 3], radius: f32) -> Value {
    let current = served.state()["current"].as_u64().unwrap();
    let (header, array) = served.arrays(&format!("api/mesh/{current}"));
    let float = |b: &[u8]| f32::from_le_bytes(b.try_into().unwrap());
    let positions: Vec<f32> = array("positions").chunks(4).map(float).collect();
    let index = |b: &[u8]| u32::from_le_bytes(b.try_into().unwrap()) as usize;
    let faces: Vec<usize> = array("faces").chunks(4).map(index).collect();
    let origin: Vec<f32> = (0..3)
        .map(|k| header["centre"][k].as_f64().unwrap() as f32)
        .collect();
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for (f, corners) in faces.chunks(3).enumerate() {
        let distance = |v: &usize| {
            let d = (0..3).map(|k| positions[3 * v + k] + origin[k] - centre[k]);
            d.map(|x| x * x).sum::<f32>().sqrt()
        };
        if !corners.iter().all(|v| distance(v) < radius) {
            continue;
        }
        match runs.last_mut() {
            Some(last) if last[1] == f => last[1] += 1,
            _ => runs.push([f, f + 1]),
        }
    }
    assert!(!runs.is_empty());
    json!(runs)
}
