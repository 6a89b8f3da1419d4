//! Files of the page of `isomend view`: opening, uploading and downloading.

use std::fs;

use serde_json::json;

use crate::desk::Desk;
use crate::served::Served;

#[test]
fn another_file_is_opened_on_a_page_of_its_own() {
    let desk = Desk::new();
    fs::copy(
        desk.0.path().join("ball.ply"),
        desk.0.path().join("second.ply"),
    )
    .unwrap();
    let served = Served::new(&desk, &["ball.ply"]);
    let listed = served.get("api/files").json();
    let names = listed["files"].as_array().unwrap();
    assert!(
        names.contains(&json!("second.ply")) && names.contains(&json!("ball.ply")),
        "{listed}"
    );
    let answer = served.post("api/open", &json!({ "path": "second.ply" }));
    assert_eq!(answer.status, 200, "{:?}", answer.json());
    let page = answer.json()["page"].as_str().unwrap().to_owned();
    assert_eq!(page.len(), 45, "{page}");
    assert_ne!(page, format!("/{}/", served.token));
    let host = served.host();
    let ask = |path: &str| served.ask("GET", &format!("{page}{path}"), &[("Host", &host)], b"");
    assert_eq!(ask("").status, 200);
    assert_eq!(ask("api/state").json()["file"]["name"], "second.ply");
    assert_eq!(served.state()["file"]["name"], "ball.ply");
    // The second page is protected like the first one.
    let foreign = served.ask("GET", &page, &[("Host", "evil.example")], b"");
    assert_eq!((foreign.status, foreign.body.len()), (403, 0));
    // The last letter of a token is "A" for one of 16 tokens.
    let last = if page.ends_with("A/") { 'E' } else { 'A' };
    let wrong = format!("/{}{last}/", &page[1..43]);
    assert_eq!(
        served.ask("GET", &wrong, &[("Host", &host)], b"").status,
        403
    );
    // The two sessions are independent.
    let undo = served.ask(
        "POST",
        &format!("{page}api/undo"),
        &[("Host", &host), ("Content-Type", "application/json")],
        b"{}",
    );
    assert_eq!(undo.status, 409);
}

#[test]
fn an_open_file_keeps_its_page_and_is_not_overwritten() {
    let desk = Desk::new();
    let ball = desk.0.path().join("ball.ply");
    fs::copy(&ball, desk.0.path().join("second.ply")).unwrap();
    let served = Served::new(&desk, &["ball.ply"]);
    let open = |path: &str| {
        let answer = served.post("api/open", &json!({ "path": path }));
        assert_eq!(answer.status, 200, "{:?}", answer.json());
        answer.json()["page"].as_str().unwrap().to_owned()
    };
    let first = format!("/{}/", served.token);
    assert_eq!(open("ball.ply"), first);
    let second = open("second.ply");
    assert_ne!(second, first);
    assert_eq!(open("./second.ply"), second);
    // Neither page overwrites the input of the other.
    let bytes = fs::read(&ball).unwrap();
    let host = served.host();
    let headers = [("Host", &host[..]), ("Content-Type", "application/json")];
    for (page, path) in [(&first, "second.ply"), (&second, "ball.ply")] {
        let wanted = json!({ "kind": "mesh", "path": path, "overwrite": true }).to_string();
        let save = format!("{page}api/save");
        let answer = served.ask("POST", &save, &headers, wanted.as_bytes());
        assert_eq!(answer.status, 409, "{path}: {:?}", answer.json());
        assert!(
            fs::read(desk.0.path().join(path)).unwrap() == bytes,
            "{path}"
        );
    }
}

#[test]
fn only_meshes_below_the_folder_are_opened() {
    let desk = Desk::new();
    fs::create_dir(desk.0.path().join("root")).unwrap();
    fs::write(desk.0.path().join("root/text.ply"), "no mesh").unwrap();
    let served = Served::new(&desk, &["ball.ply", "--root", "root"]);
    for (path, status) in [
        ("../ball.ply", 403),
        ("/etc/passwd", 403),
        ("none.ply", 404),
        ("text.ply", 422),
        ("", 422),
    ] {
        let answer = served.post("api/open", &json!({ "path": path }));
        assert_eq!(answer.status, status, "{path}: {:?}", answer.json());
    }
}

#[test]
fn an_uploaded_file_overwrites_no_other_file() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    let bytes = fs::read(desk.0.path().join("ball.ply")).unwrap();
    let send = |name: &str| served.post_bytes(&format!("api/send?name={name}"), &bytes);
    assert_eq!(send("sent.ply").status, 200);
    assert_eq!(fs::read(desk.0.path().join("sent.ply")).unwrap(), bytes);
    // The same file again is there already; another one of its name is refused, and a damaged one is not left behind.
    assert_eq!(send("sent.ply").status, 200);
    let part = &bytes[..bytes.len() / 2];
    let other = served.post_bytes("api/send?name=ball.ply", part);
    assert_eq!(other.status, 409, "{}", other.json());
    assert_eq!(fs::read(desk.0.path().join("ball.ply")).unwrap(), bytes);
    let damaged = served.post_bytes("api/send?name=damaged.ply", part);
    assert_eq!(damaged.status, 422);
    assert!(!desk.0.path().join("damaged.ply").exists());
    assert_eq!(send("..%2Fout.ply").status, 403);
    assert_eq!(send("script.sh").status, 422);
    assert!(!desk.0.path().join("script.sh").exists());
    // A body that is too large is refused when its header is read.
    let host = served.host();
    let large = format!(
        "POST /{}/api/send?name=large.ply HTTP/1.1\r\nHost: {host}\r\nContent-Type: application/octet-stream\r\n\
         Content-Length: {}\r\nConnection: close\r\n\r\n",
        served.token,
        (1_u64 << 30) + 1
    );
    assert_eq!(served.raw(large.as_bytes()).status, 413);
    let names = fs::read_dir(desk.0.path()).unwrap().flatten();
    let is_rest = |name: &str| name.contains(".part") || name == "large.ply";
    assert!(
        !names
            .into_iter()
            .any(|entry| is_rest(&entry.file_name().to_string_lossy()))
    );
    let answer = served.post("api/open", &json!({ "path": "sent.ply" }));
    assert_eq!(answer.status, 200, "{:?}", answer.json());
}

#[test]
fn a_download_has_the_bytes_of_the_saved_file() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["ball.ply"]);
    for extension in ["ply", "stl", "glb"] {
        let name = format!("saved.{extension}");
        let saved = served.post("api/save", &json!({ "kind": "mesh", "path": name }));
        assert_eq!(saved.status, 200, "{:?}", saved.json());
        let answer = served.get(&format!("api/download/0?format={extension}"));
        assert_eq!(answer.status, 200, "{extension}");
        assert!(
            answer.body == fs::read(desk.0.path().join(&name)).unwrap(),
            "{extension}"
        );
    }
    assert_eq!(served.get("api/download/0?format=exe").status, 422);
    assert_eq!(served.get("api/download/9?format=ply").status, 404);
}

#[test]
fn deviations_are_measured_only_from_files_below_the_folder() {
    let desk = Desk::new();
    fs::create_dir(desk.0.path().join("root")).unwrap();
    let copy = desk.0.path().join("root/same.ply");
    fs::copy(desk.0.path().join("ball.ply"), copy).unwrap();
    let served = Served::new(&desk, &["ball.ply", "--root", "root"]);
    let asked = |query: &str| served.get(&format!("api/values/0?name=deviation{query}"));
    let answer = asked("&file=same.ply");
    assert_eq!(answer.status, 200);
    let length = u32::from_le_bytes(answer.body[..4].try_into().unwrap()) as usize;
    let values = &answer.body[(4 + length).div_ceil(4) * 4..];
    assert!(!values.is_empty() && values.iter().all(|byte| *byte == 0));
    assert_eq!(asked("&file=../ball.ply").status, 403);
    assert_eq!(asked("&file=none.ply").status, 404);
    assert_eq!(asked("").status, 404);
}

#[test]
fn new_folders_are_made_only_below_the_folder() {
    let desk = Desk::new();
    fs::create_dir(desk.path("root")).unwrap();
    let served = Served::new(&desk, &["ball.ply", "--root", "root"]);
    let make = |path: &str| served.post("api/folder", &json!({ "path": path }));
    let made = make("parts");
    assert_eq!(
        (made.status, &made.json()["path"]),
        (200, &json!("parts")),
        "{made:?}"
    );
    assert_eq!(make("parts/left").status, 200);
    assert!(desk.path("root/parts/left").is_dir());
    for (path, status) in [
        ("parts", 409),
        ("parts/", 409),
        ("../out", 403),
        ("/out", 403),
        ("none/new", 422),
        ("", 422),
    ] {
        let answer = make(path);
        assert_eq!(answer.status, status, "{path}: {:?}", answer.json());
    }
    assert!(!desk.path("out").exists());
    served.save("mesh", "parts/left/ball.ply");
}

/// Names of files that the page once kept in the folder, as links out of it, pipes and endless devices.
#[cfg(unix)]
#[test]
fn nothing_in_the_folder_leads_out_of_it_or_blocks() {
    use std::os::unix::fs::symlink;
    for target in ["outside.json", "pipe", "/dev/zero"] {
        let desk = Desk::new();
        fs::create_dir(desk.path("root")).unwrap();
        for name in ["ball.ply", "second.ply"] {
            fs::copy(desk.path("ball.ply"), desk.path("root").join(name)).unwrap();
        }
        desk.text("outside.json", "[]");
        let made = std::process::Command::new("mkfifo")
            .arg(desk.path("pipe"))
            .status();
        assert!(made.unwrap().success());
        for name in [".isomend-recent.json", ".ball.ply.isomend-session.json"] {
            symlink(desk.path(target), desk.path("root").join(name)).unwrap();
        }
        let served = Served::new(&desk, &["root/ball.ply"]);
        assert_eq!(
            served
                .post("api/open", &json!({ "path": "second.ply" }))
                .status,
            200
        );
        served.step(&json!({ "kind": "fill", "params": { "holes": [2] } }));
        assert_eq!(fs::read(desk.path("outside.json")).unwrap(), b"[]");
        assert_eq!(desk.kept().len(), 2, "{:?}", desk.kept());
    }
}

#[test]
fn recent_files_are_offered_in_the_next_session() {
    let desk = Desk::new();
    for name in ["second.ply", "third.ply"] {
        fs::copy(desk.path("ball.ply"), desk.path(name)).unwrap();
    }
    let recent = |served: &Served| served.get("api/files").json()["recent"].clone();
    let served = Served::new(&desk, &["ball.ply"]);
    assert_eq!(recent(&served), json!([]));
    assert!(desk.kept().is_empty(), "a single file is no list");
    for name in ["third.ply", "second.ply"] {
        let answer = served.post("api/open", &json!({ "path": name }));
        assert_eq!(answer.status, 200, "{:?}", answer.json());
    }
    assert_eq!(recent(&served), json!(["second.ply", "third.ply"]));
    drop(served);
    let served = Served::new(&desk, &["third.ply"]);
    assert_eq!(recent(&served), json!(["second.ply", "ball.ply"]));
    fs::remove_file(desk.path("second.ply")).unwrap();
    assert_eq!(recent(&served), json!(["ball.ply"]));
}

#[test]
fn a_folder_opens_a_list_of_its_meshes() {
    let desk = Desk::new();
    let served = Served::new(&desk, &["."]);
    let page = served.get("");
    assert_eq!(page.status, 200);
    assert!(String::from_utf8_lossy(&page.body).contains("start.js"));
    assert_eq!(served.get("start.js").status, 200);
    let list = served.get("api/files").json();
    let names = list["files"].as_array().unwrap();
    let at = names.iter().position(|name| name == "ball.ply").unwrap();
    let size = fs::metadata(desk.0.path().join("ball.ply")).unwrap().len();
    assert_eq!(list["sizes"][at], size);
    assert_eq!(
        served.get("api/state").status,
        404,
        "a folder has no session"
    );
    let opened = served.post("api/open", &json!({ "path": "ball.ply" }));
    assert_eq!(opened.status, 200, "{:?}", opened.json());
    let missing = served.post("api/open", &json!({ "path": "none.ply" }));
    assert_eq!(missing.status, 404);
    let bytes = fs::read(desk.0.path().join("ball.ply")).unwrap();
    assert_eq!(
        served.post_bytes("api/send?name=new.ply", &bytes).status,
        200
    );
    assert_eq!(
        served
            .post_bytes("api/send?name=bad.ply", b"no mesh")
            .status,
        422
    );
    assert!(!desk.0.path().join("bad.ply").exists());
}
