//! Temporary files of a save when the process is about to end. This test is apart from other tests of files, because it prevents all
//! saves while it runs.

use std::fs;
use std::path::Path;
use std::sync::mpsc;
use std::time::Duration;

use isomend::io::{abandon_unfinished, replace_file};

fn parts(folder: &Path) -> usize {
    let names = fs::read_dir(folder).unwrap();
    let names = names.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.ends_with(".part")).count()
}

#[test]
fn unfinished_files_are_removed_and_not_moved_into_place_later() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.ply");
    replace_file(&path, b"old").unwrap();
    let (send, receive) = mpsc::channel();
    let target = path.clone();
    let saver = std::thread::spawn(move || {
        let large = vec![7; 64 << 20];
        // Until it fails.
        while replace_file(&target, &large).is_ok() {}
        send.send(()).unwrap();
    });
    let abandoned = loop {
        if parts(folder.path()) > 0 {
            break abandon_unfinished();
        }
    };
    assert_eq!(parts(folder.path()), 0);
    let length = fs::metadata(&path).unwrap().len();
    assert!(
        length == 3 || length == 64 << 20,
        "{length} bytes are neither the old nor the new"
    );
    // The saver may continue to write to the removed file, but must not move it into place.
    assert!(receive.recv_timeout(Duration::from_millis(500)).is_err());
    assert_eq!(parts(folder.path()), 0);
    assert_eq!(fs::metadata(&path).unwrap().len(), length);
    drop(abandoned);
    // The file to be moved is removed, so this save fails; a save that began later succeeds, and the test ends it.
    let mut ended = receive.recv_timeout(Duration::from_secs(5)).is_ok();
    while !ended {
        if parts(folder.path()) > 0 {
            drop(abandon_unfinished());
        }
        ended = receive.recv_timeout(Duration::from_millis(1)).is_ok();
    }
    saver.join().unwrap();
    assert_eq!(parts(folder.path()), 0);
    replace_file(&path, b"new").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
}
