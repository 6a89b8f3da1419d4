//! Ctrl-C and SIGTERM end the program wherever it is, and leave nothing half written.
#![cfg(unix)]

use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::desk::Desk;
use crate::shapes::sphere;
use isomend::io::Format;

/// Runs a command, sends it a signal after a while and returns its exit code, what it said and how long it took to end;
/// nothing if it had ended before.
fn interrupted(
    desk: &Desk,
    arguments: &[&str],
    signal: &str,
    after: Duration,
) -> Option<(i32, String, Duration)> {
    let program = assert_cmd::cargo::cargo_bin("isomend");
    let mut child = Command::new(program)
        .current_dir(desk.0.path())
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    sleep(after);
    if child.try_wait().unwrap().is_some() {
        return None;
    }
    let sent = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status()
        .unwrap();
    let begun = Instant::now();
    assert!(sent.success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    Some((output.status.code().unwrap(), said, begun.elapsed()))
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
    let mut stopped = 0;
    for (i, command) in commands.iter().enumerate() {
        for (j, (signal, code)) in [("-INT", 130), ("-TERM", 143)].into_iter().enumerate() {
            // Moments in reading, in the tree and in the solve.
            let after = Duration::from_millis(60 + 170 * ((2 * i + j) as u64 % 5));
            let Some(end) = interrupted(&desk, command, signal, after) else {
                let _ = std::fs::remove_file(desk.path("o.ply"));
                let _ = std::fs::remove_file(desk.path("o.vti"));
                continue;
            };
            assert_eq!(end.0, code, "{command:?} {}", end.1);
            assert!(end.1.contains("stopped"), "{command:?} {}", end.1);
            // Half a second of a machine that may be busy with other tests.
            assert!(end.2 < Duration::from_secs(5), "{command:?} {:?}", end.2);
            assert_eq!(desk.files(), before, "{command:?}");
            stopped += 1;
        }
    }
    assert!(
        stopped >= 6,
        "only {stopped} runs lasted until their signal"
    );
}

#[test]
fn a_file_that_was_there_stays_as_it_was() {
    let desk = Desk::new();
    desk.text("o.ply", "something else");
    let command = ["fill", "ball.ply", "-o", "o.ply", "-q", "--voxel", "0.005"];
    let end = interrupted(&desk, &command, "-TERM", Duration::from_millis(400));
    assert_eq!(end.map(|e| e.0), Some(143));
    let text = std::fs::read_to_string(desk.path("o.ply")).unwrap();
    assert_eq!(text, "something else");
}
