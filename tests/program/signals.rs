//! Ctrl-C, SIGTERM and SIGHUP end the program at any point and leave no partly written file.
#![cfg(unix)]

use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::desk::Desk;
use crate::shapes::sphere;
use isomend::io::Format;

/// CPU time of a process in seconds, counted by the kernel in hundredths; none if `/proc` does not exist or the process has ended.
fn cpu(id: u32) -> Option<f64> {
    let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    // The name of the program, in brackets, may hold spaces.
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / 100.0)
}

/// Runs a command and sends it a signal once it has used `after` CPU seconds. Returns its exit code, the text on standard error and the
/// CPU seconds that it used after the signal; none if it ended before the signal.
fn interrupted(
    desk: &Desk,
    arguments: &[&str],
    signal: &str,
    after: f64,
) -> Option<(i32, String, f64)> {
    let program = assert_cmd::cargo::cargo_bin("isomend");
    let mut child = Command::new(program)
        .current_dir(desk.0.path())
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let id = child.id();
    let begun = Instant::now();
    while cpu(id).unwrap_or(begun.elapsed().as_secs_f64()) < after {
        sleep(Duration::from_millis(1));
        if child.try_wait().unwrap().is_some() {
            return None;
        }
    }
    let sent = Command::new("kill")
        .args([signal, &id.to_string()])
        .status()
        .unwrap();
    let before = cpu(id).unwrap_or(0.0);
    assert!(sent.success());
    let mut last = before;
    while child.try_wait().unwrap().is_none() {
        last = cpu(id).unwrap_or(last).max(last);
        sleep(Duration::from_millis(1));
    }
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    Some((output.status.code().unwrap(), said, last - before))
}

/// Whether the tests were started with SIGHUP ignored, as `nohup` does: then the program goes on when the terminal is closed.
fn ignores_hangup() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).unwrap() & 1 == 1)
}

#[test]
fn every_command_ends_at_a_signal_and_leaves_no_file() {
    let desk = Desk::new();
    desk.save("large.ply", &sphere(220), Format::Ply);
    desk.save("sphere.ply", &sphere(24), Format::Ply);
    let commands: [&[&str]; 5] = [
        &["fill", "ball.ply", "-o", "o.ply", "-q", "--voxel", "0.005"],
        &[
            "restore",
            "sphere.ply",
            "-o",
            "o.ply",
            "-q",
            "--ball",
            "0,0,1,0.6",
            "--voxel",
            "0.005",
        ],
        &[
            "fair",
            "sphere.ply",
            "-o",
            "o.ply",
            "-q",
            "--voxel",
            "0.012",
        ],
        &["sdf", "large.ply", "-o", "o.vti", "-q", "--voxel", "0.005"],
        &[
            "compare",
            "large.ply",
            "sphere.ply",
            "--samples",
            "30000000",
        ],
    ];
    let before = desk.files();
    let all = [("-INT", 130), ("-TERM", 143), ("-HUP", 129)];
    let signals = &all[..if ignores_hangup() { 2 } else { 3 }];
    let mut stopped = 0;
    for (i, command) in commands.iter().enumerate() {
        for (j, (signal, code)) in signals.iter().enumerate() {
            // Moments while the mesh is read, the tree is built, and the system is solved.
            let after = 0.05 + 0.15 * ((3 * i + j) % 5) as f64;
            let Some(end) = interrupted(&desk, command, signal, after) else {
                let _ = std::fs::remove_file(desk.path("o.ply"));
                let _ = std::fs::remove_file(desk.path("o.vti"));
                continue;
            };
            assert_eq!(end.0, *code, "{command:?} {}", end.1);
            assert!(end.1.contains("stopped"), "{command:?} {}", end.1);
            assert!(end.2 < 1.0, "{command:?}: {} CPU s", end.2);
            assert_eq!(desk.files(), before, "{command:?}");
            stopped += 1;
        }
    }
    assert!(
        stopped >= 3 * signals.len(),
        "only {stopped} runs lasted until their signal"
    );
}

#[test]
fn an_existing_output_stays_unchanged_after_a_signal() {
    let desk = Desk::new();
    desk.text("o.ply", "something else");
    let command = ["fill", "ball.ply", "-o", "o.ply", "-q", "--voxel", "0.005"];
    let end = interrupted(&desk, &command, "-TERM", 0.4);
    assert_eq!(end.map(|e| e.0), Some(143));
    let text = std::fs::read_to_string(desk.path("o.ply")).unwrap();
    assert_eq!(text, "something else");
}

/// The program waits for a reader of its document, which is longer than a pipe holds, while it gets the signal: the meshes are in place.
#[test]
fn a_signal_after_files_are_written_names_them() {
    let desk = Desk::new();
    let names: Vec<String> = (0..60).map(|i| format!("{i}.ply")).collect();
    for name in &names {
        std::fs::copy(desk.path("ball.ply"), desk.path(name)).unwrap();
    }
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("isomend"))
        .current_dir(desk.0.path())
        .arg("fill")
        .args(&names)
        .args(["-o", "out/", "--json", "-", "-q", "--voxel", "0.2"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let last = desk.path("out/59.ply");
    while !last.exists() && child.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(1));
    }
    let id = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &id]).status();
    assert!(sent.unwrap().success());
    // Standard output is not read before the end: the program would go on.
    let status = child.wait().unwrap();
    let text = std::io::read_to_string(child.stderr.take().unwrap()).unwrap();
    assert_eq!(status.code(), Some(130), "{text}");
    assert!(text.contains("60 files were written before"), "{text}");
    assert!(last.exists());
}
