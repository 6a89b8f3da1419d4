//! `isomend mcp`: the protocol over pipes, and what the tools may not do.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use isomend::io::Format;
use serde_json::{Value, json};

use crate::desk::Desk;
use crate::shapes::{cut, sphere};

/// A running server and its pipes.
struct Client {
    server: Child,
    lines: BufReader<ChildStdout>,
    /// Notifications that came while an answer was waited for.
    notified: Vec<Value>,
}

impl Client {
    fn new(desk: &Desk, options: &[&str]) -> Self {
        let program = assert_cmd::cargo::cargo_bin("isomend");
        let mut server = Command::new(program)
            .args(["mcp", "-q", "--folder"])
            .arg(desk.0.path())
            .args(options)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(server.stdout.take().unwrap());
        Self {
            server,
            lines,
            notified: Vec::new(),
        }
    }

    fn send(&mut self, line: &str) {
        let input = self.server.stdin.as_mut().unwrap();
        input.write_all(line.as_bytes()).unwrap();
        input.write_all(b"\n").unwrap();
        input.flush().unwrap();
    }

    fn message(&mut self) -> Value {
        let mut line = String::new();
        self.lines.read_line(&mut line).unwrap();
        serde_json::from_str(&line).unwrap_or_else(|_| panic!("no message: {line:?}"))
    }

    /// The next answer; notifications before it are kept.
    fn receive(&mut self) -> Value {
        loop {
            let message = self.message();
            if message.get("method").is_none() {
                return message;
            }
            self.notified.push(message);
        }
    }

    /// The first notification.
    fn notification(&mut self) -> Value {
        match self.notified.first() {
            Some(message) => message.clone(),
            None => self.message(),
        }
    }

    fn ask(&mut self, method: &str, params: Value) -> Value {
        let request = json!({ "jsonrpc": "2.0", "id": 7, "method": method, "params": params });
        self.send(&request.to_string());
        let answer = self.receive();
        assert_eq!(
            (&answer["jsonrpc"], &answer["id"]),
            (&json!("2.0"), &json!(7))
        );
        answer
    }

    /// The result of a call of a tool.
    fn call(&mut self, tool: &str, arguments: Value) -> Value {
        let params = json!({ "name": tool, "arguments": arguments });
        let answer = self.ask("tools/call", params);
        assert!(answer["result"].is_object(), "{answer}");
        answer["result"].clone()
    }

    /// The message of a call that fails.
    fn refusal(&mut self, tool: &str, arguments: Value) -> String {
        let result = self.call(tool, arguments);
        assert_eq!(result["isError"], true, "{result}");
        result["content"][0]["text"].as_str().unwrap().to_owned()
    }

    /// Ends the input; returns the exit code and the further messages.
    fn end(mut self) -> (Option<i32>, Vec<String>) {
        drop(self.server.stdin.take());
        let rest = (&mut self.lines).lines().map(Result::unwrap).collect();
        (self.server.wait().unwrap().code(), rest)
    }
}

#[test]
fn a_client_is_greeted_and_finds_the_tools_with_their_schemas() {
    let desk = Desk::new();
    let mut client = Client::new(&desk, &[]);
    let begin = json!({ "protocolVersion": "2024-11-05", "capabilities": {}, "clientInfo": { "name": "t", "version": "1" } });
    let greeting = client.ask("initialize", begin)["result"].clone();
    assert_eq!(greeting["protocolVersion"], "2024-11-05");
    assert_eq!(greeting["serverInfo"]["name"], "isomend");
    assert!(greeting["capabilities"]["tools"].is_object());
    client.send(r#"{"jsonrpc":"2.0","method":"notifications/initialized"}"#);
    assert_eq!(client.ask("ping", json!({}))["result"], json!({}));
    for unknown in ["1999-01-01", "2025-03-26"] {
        let answer = client.ask("initialize", json!({ "protocolVersion": unknown }));
        assert_eq!(answer["result"]["protocolVersion"], "2025-06-18");
    }
    let tools = client.ask("tools/list", Value::Null)["result"]["tools"].clone();
    let names: Vec<&str> = (tools.as_array().unwrap().iter())
        .map(|tool| tool["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["inspect", "check", "fill", "repair"]);
    let fill = &tools[2]["inputSchema"];
    assert_eq!(fill["required"], json!(["path"]));
    assert_eq!(fill["properties"]["max_diameter"]["exclusiveMinimum"], 0.0);
    assert!(fill["properties"]["output"].is_object());
    let has_tolerance = |tool: &Value| !tool["inputSchema"]["properties"]["tolerance"].is_null();
    let with_tolerance: Vec<bool> = tools
        .as_array()
        .unwrap()
        .iter()
        .map(has_tolerance)
        .collect();
    assert_eq!(with_tolerance, [false, false, true, true]);
    assert_eq!(client.end(), (Some(0), Vec::new()));
    let mut client = Client::new(&desk, &["--read-only"]);
    let tools = client.ask("tools/list", json!({}))["result"]["tools"].clone();
    assert_eq!(tools.as_array().unwrap().len(), 2);
    let answer = client.ask("tools/call", json!({ "name": "fill", "arguments": {} }));
    assert_eq!(answer["error"]["code"], -32602);
}

#[test]
fn tools_return_the_reports_of_the_commands() {
    let desk = Desk::new();
    let mut client = Client::new(&desk, &[]);
    let seen = client.call("inspect", json!({ "path": "ball.ply", "unit": "mm" }));
    assert_eq!(
        seen["structuredContent"]["holes"].as_array().unwrap().len(),
        2
    );
    let text = seen["content"][0]["text"].as_str().unwrap();
    let same: Value = serde_json::from_str(text).unwrap();
    assert_eq!(same, seen["structuredContent"]);
    let checked = client.call("check", json!({ "path": "ball.ply", "thin": 0.01 }));
    assert_eq!(checked["structuredContent"]["command"], "check");
    let plan = json!({ "path": "ball.ply", "holes": [2], "dry_run": true });
    assert_eq!(client.call("fill", plan)["isError"], false);
    assert_eq!(desk.files(), ["ball.ply"]);
    let wanted = json!({ "path": "ball.ply", "output": "mended.ply", "holes": [2], "unit": "mm" });
    let filled = client.call("fill", wanted.clone());
    assert_eq!(filled["structuredContent"]["outcomes"]["left"], 1);
    assert!(
        client
            .refusal("fill", wanted)
            .contains("exists already; name another file")
    );
    let again = json!({ "path": "ball.ply", "output": "mended.ply", "holes": [2], "unit": "mm", "overwrite": true });
    assert_eq!(client.call("fill", again)["isError"], false);
    let made = std::fs::read(desk.path("mended.ply")).unwrap();
    assert!(
        desk.run(&["fill", "ball.ply", "-o", "own.ply", "--holes", "2", "-q"])
            .status
            .success()
    );
    assert_eq!(made, std::fs::read(desk.path("own.ply")).unwrap());
    let repaired = client.call(
        "repair",
        json!({ "path": "ball.ply", "output": "repaired.stl" }),
    );
    assert_eq!(repaired["structuredContent"]["complete"], true);
    assert_eq!(client.end(), (Some(0), Vec::new()));
}

#[test]
fn wrong_messages_get_errors_and_end_nothing() {
    let desk = Desk::new();
    let mut client = Client::new(&desk, &[]);
    for (line, code) in [
        ("{", -32700),
        ("[]", -32600),
        (r#"{"jsonrpc":"1.0","id":1,"method":"ping"}"#, -32600),
        (
            r#"{"jsonrpc":"2.0","id":1,"method":"resources/list"}"#,
            -32601,
        ),
        (r#"{"jsonrpc":"2.0","id":1,"method":"tools/call"}"#, -32602),
        (
            r#"{"jsonrpc":"2.0","id":1,"method":"tools/call","params":{"name":"study"}}"#,
            -32602,
        ),
        (
            r#"{"jsonrpc":"2.0","id":1,"method":"tools/call","params":{"name":"fill","arguments":[]}}"#,
            -32602,
        ),
    ] {
        client.send(line);
        assert_eq!(client.receive()["error"]["code"], code, "{line}");
    }
    client.send("");
    client.send(r#"{"jsonrpc":"2.0","method":"notifications/unknown"}"#);
    client.send(r#"{"jsonrpc":"2.0","id":5,"result":{}}"#);
    client.send(r#"{"jsonrpc":"2.0","method":"notifications/cancelled"}"#);
    client.send(r#"{"jsonrpc":"2.0","method":"notifications/cancelled","params":{}}"#);
    client.send(r#"{"jsonrpc":"2.0","method":"notifications/cancelled","params":null}"#);
    for (tool, arguments, part) in [
        ("check", json!({}), "\"path\" is missing"),
        ("check", Value::Null, "\"path\" is missing"),
        (
            "check",
            json!({ "path": "ball.ply", "tolerance": 0.1 }),
            "check has no parameter 'tolerance'",
        ),
        (
            "inspect",
            json!({ "path": "ball.ply", "tolerance": 0.1 }),
            "inspect has no parameter 'tolerance'",
        ),
        ("check", json!({ "path": 1 }), "path must be a text"),
        (
            "check",
            json!({ "path": "none.ply" }),
            "there is no file none.ply",
        ),
        (
            "check",
            json!({ "path": "ball.ply", "voxel": 1 }),
            "check has no parameter 'voxel'",
        ),
        (
            "inspect",
            json!({ "path": "ball.ply", "voxel": 1 }),
            "inspect has no parameter 'voxel'",
        ),
        (
            "fill",
            json!({ "path": "ball.ply" }),
            "\"output\" is missing",
        ),
        (
            "fill",
            json!({ "path": "ball.ply", "output": "a.ply", "voxel": -1 }),
            "voxel must be",
        ),
        (
            "fill",
            json!({ "path": "ball.ply", "output": "a.ply", "holes": [9] }),
            "there is no hole 9",
        ),
        (
            "fill",
            json!({ "path": "ball.ply", "output": "a.txt" }),
            "no extension of a known mesh format",
        ),
        (
            "fill",
            json!({ "path": "ball.ply", "output": "a.ply", "dry_run": 1 }),
            "dry_run must be true or false",
        ),
    ] {
        let what = client.refusal(tool, arguments.clone());
        assert!(what.contains(part), "{arguments}: {what}");
    }
    assert_eq!(desk.files(), ["ball.ply"]);
    assert_eq!(client.end(), (Some(0), Vec::new()));
}

#[cfg(unix)]
#[test]
fn nothing_outside_the_folder_is_read_or_written() {
    use std::os::unix::fs::symlink;
    let outside = Desk::new();
    let desk = Desk::new();
    symlink(outside.path("ball.ply"), desk.path("link.ply")).unwrap();
    symlink(outside.0.path(), desk.path("out")).unwrap();
    std::fs::create_dir(desk.path("in")).unwrap();
    symlink(desk.path("in"), desk.path("inner")).unwrap();
    let mut client = Client::new(&desk, &[]);
    let absolute = outside.path("ball.ply");
    let absolute = absolute.to_str().unwrap();
    for path in [
        absolute,
        "../ball.ply",
        "in/../../ball.ply",
        "link.ply",
        "out/ball.ply",
        "",
        "in/",
    ] {
        let what = client.refusal("check", json!({ "path": path }));
        assert!(!what.is_empty(), "{path}");
        let wanted = json!({ "path": "ball.ply", "output": path, "overwrite": true });
        client.refusal("fill", wanted);
        let template = json!({ "path": "ball.ply", "output": "a.ply", "like": path });
        client.refusal("fill", template);
    }
    assert_eq!(outside.files(), ["ball.ply"]);
    assert_eq!(desk.files(), ["ball.ply", "in", "inner", "link.ply", "out"]);
    // A link to a folder inside is followed, and so is the template beside the mesh.
    let wanted = json!({ "path": "ball.ply", "output": "inner/a.ply", "like": "ball.ply" });
    assert_eq!(client.call("fill", wanted)["isError"], false);
    assert!(desk.path("in/a.ply").exists());
}

/// Many holes in a sphere with `n` parts along a side: seconds of work if it is fine.
fn save_many_holes(desk: &Desk, n: u32) {
    let fine = sphere(n);
    let holes = cut(&fine, |p| {
        p.x.abs() < 0.97 && (9.0 * p.x).sin() * (9.0 * p.y).sin() * (9.0 * p.z).cos() > 0.5
    });
    desk.save("many.ply", &holes, Format::Ply);
}

/// A fill of many.ply to made.ply that reports its progress.
fn long_request() -> Value {
    json!({
        "jsonrpc": "2.0", "id": "long", "method": "tools/call",
        "params": { "name": "fill", "arguments": { "path": "many.ply", "output": "made.ply" }, "_meta": { "progressToken": "t" } },
    })
}

#[cfg(unix)]
#[test]
fn what_was_made_in_place_of_the_output_meanwhile_is_kept() {
    let outside = Desk::new();
    let desk = Desk::new();
    save_many_holes(&desk, 48);
    let made = desk.path("made.ply");
    let mut client = Client::new(&desk, &["--threads", "1"]);
    for (is_link, part) in [(false, "exists already"), (true, "is a link")] {
        client.send(&long_request().to_string());
        assert_eq!(client.message()["method"], "notifications/progress");
        match is_link {
            false => std::fs::write(&made, "not to be replaced").unwrap(),
            true => std::os::unix::fs::symlink(outside.path("new.ply"), &made).unwrap(),
        }
        let result = client.receive()["result"].clone();
        assert_eq!(result["isError"], true, "{result}");
        let what = result["content"][0]["text"].as_str().unwrap();
        assert!(what.contains(part), "{what}");
        if !is_link {
            assert_eq!(std::fs::read(&made).unwrap(), b"not to be replaced");
            std::fs::remove_file(&made).unwrap();
        }
    }
    assert_eq!(outside.files(), ["ball.ply"]);
    assert_eq!(client.end(), (Some(0), Vec::new()));
}

#[test]
fn a_call_is_stopped_by_the_client_and_reports_its_progress() {
    let desk = Desk::new();
    save_many_holes(&desk, 160);
    let mut client = Client::new(&desk, &["--threads", "1"]);
    let request = long_request();
    client.send(&request.to_string());
    // The server answers while the call runs, and refuses its id a second time.
    assert_eq!(client.ask("ping", json!({}))["result"], json!({}));
    client.send(&request.to_string());
    assert_eq!(client.receive()["error"]["code"], -32602);
    let progress = client.notification();
    assert_eq!(progress["method"], "notifications/progress", "{progress}");
    assert_eq!(progress["params"]["progressToken"], "t");
    let begun = Instant::now();
    client.send(
        r#"{"jsonrpc":"2.0","method":"notifications/cancelled","params":{"requestId":"long"}}"#,
    );
    let (code, rest) = client.end();
    assert_eq!(code, Some(0));
    assert!(
        rest.iter()
            .all(|line| line.contains("notifications/progress")),
        "{rest:?}"
    );
    assert!(begun.elapsed() < Duration::from_secs(5));
    assert!(!desk.path("made.ply").exists());
}
