//! `isomend view`: requests of the page, and hostile or invalid requests.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;

use crate::desk::{self, Desk};
use crate::served::{Answer, Served};
use isomend::io::read_path;
use serde_json::{Value, json};

/// A fill that takes at least a second.
fn long_fill() -> Value {
    json!({ "kind": "fill", "params": { "voxel": { "length": 0.005 }, "holes": [1] } })
}

fn fill(hole: usize) -> Value {
    json!({ "kind": "fill", "params": { "holes": [hole] } })
}

#[test]
fn the_page_is_served_with_a_strict_policy() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    for (name, kind) in [
        ("", "text/html"),
        ("page.css", "text/css"),
        ("page.js", "text/javascript"),
        ("worker.js", "text/javascript"),
        ("api/state", "application/json"),
    ] {
        let answer = served.get(name);
        assert_eq!(answer.status, 200, "{name}");
        for header in [
            &format!("content-type: {kind}")[..],
            "content-security-policy: default-src 'none'; script-src 'self'",
            "frame-ancestors 'none'",
            "x-content-type-options: nosniff",
            "cross-origin-opener-policy: same-origin",
            "permissions-policy: camera=()",
            "referrer-policy: no-referrer",
            "cache-control: no-store",
        ] {
            assert!(answer.head.contains(header), "{name}: {}", answer.head);
        }
        assert!(!answer.head.contains("access-control"));
    }
    assert_eq!(served.get("page.html").status, 404);
    assert_eq!(served.get("api/nothing").status, 404);
    assert_eq!(served.get("api/mesh/7").status, 404);
    assert_eq!(served.get("api/mesh/-1").status, 400);
}

/// Asserts a refusal with an empty body.
#[track_caller]
fn refused(answer: Answer, what: &str) {
    assert_eq!(answer.status, 403, "{what}");
    assert!(answer.body.is_empty(), "{what}");
}

#[test]
fn requests_without_the_token_are_refused() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let (host, token) = (served.host(), served.token.clone());
    let get = |path: &str| served.ask("GET", path, &[("Host", &host)], b"");
    assert_eq!(get(&format!("/{token}/api/state")).status, 200);
    let other = if token.starts_with('A') { "B" } else { "A" };
    let wrong = format!("/{other}{}/api/state", &token[1..]);
    let short = format!("/{}/api/state", &token[..42]);
    let encoded = format!("/%{:02x}{}/api/state", token.as_bytes()[0], &token[1..]);
    for path in ["/", "/api/state", "//api/state", &wrong, &short, &encoded] {
        refused(get(path), path);
    }
}

#[test]
fn requests_of_other_hosts_and_origins_are_refused() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let (host, port) = (served.host(), served.port);
    let path = format!("/{}/api/state", served.token);
    let get = |path: &str, headers: &[(&str, &str)]| served.ask("GET", path, headers, b"");
    for name in [
        "evil.example".to_owned(),
        format!("evil.example:{port}"),
        "127.0.0.1".to_owned(),
        format!("127.0.0.1.evil.example:{port}"),
        format!("localhost:{}", port.wrapping_add(1)),
        String::new(),
    ] {
        refused(get(&path, &[("Host", &name)]), &name);
    }
    refused(
        get(&path, &[("Host", &host), ("Host", "evil.example")]),
        "two hosts",
    );
    let local = format!("localhost:{port}");
    assert_eq!(get(&path, &[("Host", &local)]).status, 200);
    let absolute = format!("http://evil.example:{port}{path}");
    refused(get(&absolute, &[("Host", &host)]), "absolute address");
    for origin in [
        "http://evil.example",
        "null",
        "https://127.0.0.1",
        &format!("http://127.0.0.1:{}", port ^ 1),
    ] {
        refused(get(&path, &[("Host", &host), ("Origin", origin)]), origin);
    }
    for site in ["cross-site", "same-site"] {
        refused(
            get(&path, &[("Host", &host), ("Sec-Fetch-Site", site)]),
            site,
        );
    }
}

#[test]
fn form_posts_and_other_methods_are_refused() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let host = served.host();
    let [path, undo] = ["state", "undo"].map(|name| format!("/{}/api/{name}", served.token));
    let json = ("Content-Type", "application/json");
    let post = |headers: &[(&str, &str)]| served.ask("POST", &undo, headers, b"{}");
    refused(post(&[("Host", &host)]), "no type");
    for kind in [
        "text/plain",
        "application/x-www-form-urlencoded",
        "multipart/form-data",
    ] {
        refused(post(&[("Host", &host), ("Content-Type", kind)]), kind);
    }
    refused(
        post(&[("Host", &host), json, ("Sec-Fetch-Site", "cross-site")]),
        "cross-site",
    );
    refused(
        post(&[("Host", &host), json, ("Origin", "http://evil.example")]),
        "origin",
    );
    for method in ["PUT", "DELETE", "OPTIONS", "PATCH", "TRACE"] {
        refused(served.ask(method, &path, &[("Host", &host)], b""), method);
    }
    assert_eq!(post(&[("Host", &host), json]).status, 409);
}

#[test]
fn only_files_below_the_root_are_touched() {
    let desk = Desk::new();
    let top = desk.0.path();
    fs::create_dir_all(top.join("root/sub")).unwrap();
    fs::write(top.join("secret.faces"), "1\n").unwrap();
    fs::write(top.join("root/old.ply"), "old").unwrap();
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(top, top.join("root/up")).unwrap();
        std::os::unix::fs::symlink("../secret.faces", top.join("root/link.faces")).unwrap();
        std::os::unix::fs::symlink("../new.ply", top.join("root/link.ply")).unwrap();
    }
    let served = Served::new(&desk, &["ball.ply", "--root", "root"]);
    let before = desk.files();
    let save = |path: &str, overwrite: bool| {
        let wanted = json!({ "kind": "mesh", "path": path, "overwrite": overwrite });
        served.post("api/save", &wanted)
    };
    let absolute = top.join("new.ply");
    let mut outside = vec![
        "../new.ply",
        "sub/../../new.ply",
        "/new.ply",
        absolute.to_str().unwrap(),
    ];
    if cfg!(unix) {
        outside.extend(["up/new.ply", "link.ply"]);
    }
    for path in outside {
        let answer = save(path, true);
        assert_eq!(answer.status, 403, "{path}: {}", answer.json());
    }
    for path in [
        "../secret.faces",
        "sub/../../secret.faces",
        "/etc/passwd",
        "link.faces",
    ] {
        if cfg!(unix) || path != "link.faces" {
            let answer = served.post("api/mask/load", &json!({ "path": path }));
            assert_eq!(answer.status, 403, "{path}: {}", answer.json());
        }
    }
    for path in [
        "",
        "new",
        "new.txt",
        ".bashrc",
        "sub",
        "sub/",
        "none/new.ply",
        "a\u{0}.ply",
        "new.vti",
    ] {
        assert_eq!(save(path, true).status, 422, "{path}");
    }
    assert_eq!(save("old.ply", false).status, 409);
    assert_eq!(fs::read(top.join("root/old.ply")).unwrap(), b"old");
    assert_eq!(desk.files(), before);
    assert_eq!(save("old.ply", true).status, 200);
    let answer = save("sub/new.glb", false);
    assert_eq!(answer.status, 200, "{}", answer.json());
    assert!(read_path(&top.join("root/sub/new.glb"), None).is_ok());
}

#[test]
fn names_with_control_characters_are_refused() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let before = desk.files();
    for path in ["a\nb.ply", "\u{1b}[2Jx.ply", "tab\t.ply"] {
        let wanted = json!({ "kind": "mesh", "path": path });
        let answer = served.post("api/save", &wanted);
        assert_eq!(answer.status, 422, "{path:?}");
        assert_eq!(answer.json()["where"], "path");
    }
    assert_eq!(desk.files(), before);
}

#[test]
fn the_address_without_its_last_slash_redirects_to_the_page() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let (host, token) = (served.host(), &served.token);
    let get = |path: &str| served.ask("GET", path, &[("Host", &host)], b"");
    let answer = get(&format!("/{token}"));
    assert_eq!(answer.status, 308);
    let location = format!("location: /{token}/").to_ascii_lowercase();
    assert!(answer.head.contains(&location), "{}", answer.head);
    for whole in [format!("http://{host}"), format!("http://{host}/")] {
        refused(get(&whole), &whole);
    }
}

/// Requests without the token end their connection, and streams of events leave room for other requests.
#[test]
fn neither_strangers_nor_streams_block_others() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let host = served.host();
    let asked = |path: &str| {
        let mut stream = TcpStream::connect(("127.0.0.1", served.port)).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
        stream
    };
    let mut stranger = asked("/");
    let mut said = String::new();
    stranger.read_to_string(&mut said).unwrap();
    assert!(
        said.contains("403 Forbidden") && said.contains("connection: close"),
        "{said}"
    );
    let silent: Vec<TcpStream> = (0..200)
        .map(|_| TcpStream::connect(("127.0.0.1", served.port)).unwrap())
        .collect();
    assert_eq!(served.get("api/state").status, 200);
    let events = format!("/{}/api/events", served.token);
    let mut streams: Vec<TcpStream> = (0..150).map(|_| asked(&events)).collect();
    let mut answers = Vec::new();
    for stream in &mut streams {
        let mut head = [0; 12];
        stream.read_exact(&mut head).unwrap();
        answers.push(String::from_utf8(head.to_vec()).unwrap());
    }
    let count = |status: &str| answers.iter().filter(|a| a.ends_with(status)).count();
    assert_eq!((count("200"), count("503")), (128, 22));
    assert_eq!(served.get("api/state").status, 200);
    // A stream that is closed leaves its place to others.
    drop(streams);
    let again = (0..100).find(|_| {
        let mut head = [0; 12];
        asked(&events).read_exact(&mut head).unwrap();
        head.ends_with(b"200")
    });
    assert!(again.is_some());
    drop(silent);
}

/// Connections that never complete a request are closed and do not block others.
#[test]
fn slow_requests_do_not_block_others() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let slow = |_| {
        let mut stream = TcpStream::connect(("127.0.0.1", served.port)).unwrap();
        stream.write_all(b"GET / HTTP/1.1\r\nHost: ").unwrap();
        stream
    };
    let mut streams: Vec<TcpStream> = (0..100).map(slow).collect();
    assert_eq!(served.get("api/state").status, 200);
    let first = &mut streams[0];
    let wait = std::time::Duration::from_secs(60);
    first.set_read_timeout(Some(wait)).unwrap();
    let mut said = Vec::new();
    let end = first.read_to_end(&mut said);
    let is_reset = |error: &std::io::Error| error.kind() == std::io::ErrorKind::ConnectionReset;
    assert!(
        end.as_ref().err().is_none_or(is_reset),
        "it is not closed: {end:?}"
    );
}

#[test]
fn unsaved_steps_and_earlier_sessions_are_reported() {
    let desk = Desk::new();
    {
        let served = Served::new(&desk, &["ball.ply"]);
        assert_eq!(served.state()["unsaved"], false);
        assert_eq!(served.state()["earlier"], json!(null));
        assert_eq!(served.step(&fill(2))["unsaved"], true);
    }
    let served = Served::new(&desk, &["ball.ply"]);
    let earlier = served.state()["earlier"].as_str().unwrap().to_owned();
    assert!(
        earlier.ends_with(".session.json") && earlier.contains("/state/isomend/ball.ply-"),
        "{earlier}"
    );
}

#[test]
fn saved_files_need_the_extension_of_their_kind() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    for (kind, path) in [
        ("report", "a.ply"),
        ("recipe", "a.html"),
        ("mask", "a.sh"),
        ("mesh", "a.html"),
    ] {
        let answer = served.post(
            "api/save",
            &json!({ "kind": kind, "path": path, "mask": [[0, 1]] }),
        );
        assert_eq!(answer.status, 422, "{kind} {path}");
    }
    let wanted = json!({ "kind": "mesh", "path": "ball.ply", "overwrite": true });
    assert_eq!(served.post("api/save", &wanted).status, 409);
}

#[test]
fn invalid_steps_are_refused_and_the_server_continues() {
    let desk = Desk::new();
    let mut served = Served::new(&desk, &["ball.ply"]);
    let step = |text: &str| served.post_bytes("api/step", text.as_bytes());
    for text in [
        "",
        "{",
        "[]",
        "null",
        "{\"kind\":\"fill\",\"mask\":[[NaN,1]]}",
        "{\"kind\":\"eat\"}",
        "\u{fffd}",
    ] {
        let answer = step(text);
        assert_eq!(answer.status, 400, "{text}");
        assert!(answer.json()["error"].is_string());
    }
    let faces = served.state()["states"][0]["faces"].as_u64().unwrap();
    let over = json!([[0, faces + 1]]);
    for mask in [
        json!([]),
        json!([[1, 1]]),
        json!([[2, 1]]),
        json!([[0, 4], [2, 6]]),
        over,
        json!([[0, u32::MAX]]),
    ] {
        let answer = served.post("api/step", &json!({ "kind": "restore", "mask": mask }));
        assert_eq!(answer.status, 422, "{mask}");
        assert_eq!(answer.json()["where"], "mask");
    }
    for mask in [
        json!([[-1, 2]]),
        json!([[0.5, 2]]),
        json!([[0, 1e99]]),
        json!([[0]]),
        json!("all"),
    ] {
        let answer = served.post("api/step", &json!({ "kind": "restore", "mask": mask }));
        assert_eq!(answer.status, 400, "{mask}");
    }
    for (kind, params) in [
        ("fill", json!({ "edge_ratio": 0.001 })),
        ("fill", json!({ "holes": [] })),
        ("fill", json!({ "holes": [0] })),
        ("fill", json!({ "voxel": { "length": -1.0 } })),
        ("fill", json!({ "steps": 0 })),
        ("fill", json!({ "colour": 1 })),
        ("fill", json!({ "max_diameter": 0.0 })),
        ("fill", json!([1])),
        ("fair", json!({ "extent": { "strength": 0.0 } })),
        ("repair", json!({ "weld": 0.0 })),
        ("repair", json!({ "borders": true, "skip": ["holes"] })),
    ] {
        let answer = served.post("api/step", &json!({ "kind": kind, "params": params }));
        assert_eq!(answer.status, 422, "{kind} {params}");
        assert_eq!(answer.json()["where"], "params", "{kind} {params}");
    }
    assert!(served.lives());
    served.step(&fill(2));
}

#[test]
fn large_bodies_and_unknown_resources_are_refused() {
    let desk = Desk::new();
    let mut served = Served::new(&desk, &["ball.ply"]);
    let head = format!(
        "POST /{}/api/step HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\nContent-Length: 99999999999\r\n\r\n{{",
        served.token,
        served.host()
    );
    assert_eq!(served.raw(head.as_bytes()).status, 413);
    let long = vec![b' '; 100 << 10];
    assert_eq!(served.post_bytes("api/cancel", &long).status, 413);
    for name in [
        "values/0?name=attribute:none",
        "values/0?name=",
        "texture/0",
        "uv/0",
        "values/9?name=sigma",
    ] {
        assert_eq!(served.get(&format!("api/{name}")).status, 404, "{name}");
    }
    assert_eq!(served.get("api/check/0?thin=NaN").status, 422);
    // A hole number that does not exist is detected when the step is made.
    assert_eq!(served.post("api/step", &fill(99)).status, 202);
    let state = served.wait(|s| s["busy"].is_null());
    assert_eq!(
        (&state["current"], &state["undo"]),
        (&json!(0), &json!(false))
    );
    assert!(served.lives());
    served.step(&fill(2));
}

#[test]
fn a_step_can_be_cancelled_and_only_one_is_made_at_a_time() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let before = served.state();
    let job = served.post("api/step", &long_fill()).json()["job"].clone();
    assert_eq!(served.state()["busy"]["job"], job);
    assert_eq!(served.post("api/step", &fill(2)).status, 409);
    assert_eq!(served.post("api/undo", &json!({})).status, 409);
    assert_eq!(served.post("api/cancel", &json!({ "job": 99 })).status, 404);
    assert_eq!(
        served.post("api/cancel", &json!({ "job": job })).status,
        202
    );
    let after = served.wait(|s| s["busy"].is_null());
    for part in ["current", "states", "holes", "undo", "redo"] {
        assert_eq!(before[part], after[part], "{part}");
    }
    assert_eq!(
        served.post("api/cancel", &json!({ "job": job })).status,
        404
    );
    assert!(!desk.files().iter().any(|f| f.contains("session")));
}

#[test]
fn a_closed_browser_does_not_stop_a_step() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let mut stream = TcpStream::connect(("127.0.0.1", served.port)).unwrap();
    let ask = format!(
        "GET /{}/api/events HTTP/1.1\r\nHost: {}\r\n\r\n",
        served.token,
        served.host()
    );
    stream.write_all(ask.as_bytes()).unwrap();
    assert_eq!(served.post("api/step", &fill(1)).status, 202);
    let (mut events, mut part) = (String::new(), [0; 1024]);
    while !events.contains("event: progress") {
        let n = stream.read(&mut part).unwrap();
        assert!(n > 0, "{events}");
        events += &String::from_utf8_lossy(&part[..n]);
    }
    drop(stream);
    let state = served.wait(|s| s["busy"].is_null());
    assert_eq!(state["current"], 1, "{state}");
}

#[test]
fn listening_to_other_machines_gives_a_warning() {
    let desk = Desk::new();
    let refused = desk.run(&["view", "-", "--no-browser"]);
    desk::assert_usage(&refused, &["standard input"]);
    let refused = desk.run(&["view", "none.ply", "--no-browser"]);
    desk::assert_code(&refused, 1);
    let served = Served::new(&desk, &["ball.ply", "--listen", "0.0.0.0"]);
    assert_eq!(served.get("api/state").status, 200);
    #[cfg(unix)]
    {
        let (_, said) = served.signalled("-INT");
        assert!(said.contains("other machines"), "{said}");
    }
}
