//! What goes wrong outside the program: full disks, folders that cannot be written, kills, two runs at once, files from Windows. Each run
//! ends with a code other than 0 and an error that names the file and the reason, and no file is half written under its name.
#![cfg(all(feature = "cli", unix))]

use crate::common;

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use common::{Desk, Run, binary};

const MOVE: [&str; 15] =
    ["move", "--from-deg", "0", "-30", "90", "30", "-90", "0", "--to-deg", "60", "0", "60", "30", "-90", "45"];

/// Names of everything in a folder, hidden files included.
fn left(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut names: Vec<String> =
        entries.filter_map(|e| Some(e.ok()?.file_name().to_string_lossy().into_owned())).collect();
    names.sort();
    names
}

/// A long motion, while it is being written.
fn writing(desk: &Desk, seconds: &str) -> Child {
    let mut child = Command::new(binary())
        .args(MOVE)
        .args(["--least-s", seconds])
        .current_dir(&desk.folder)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    while left(&desk.folder.join("out")).is_empty() {
        assert!(child.try_wait().expect("a child").is_none(), "ended before it wrote");
        std::thread::sleep(Duration::from_millis(5));
    }
    child
}

#[test]
fn two_runs_into_one_folder_do_not_mix_their_files() {
    let desk = Desk::new("two_runs");
    let mut first = writing(&desk, "9000");
    let busy = ["out: another run writes into this folder", "--out"];
    desk.run(&MOVE).refused(2, &busy);
    desk.write("jobs.jsonl", "{\"id\": \"a\", \"robot\": \"nobody\"}\n");
    desk.run(&["batch", "jobs.jsonl", "--out", "out"]).refused(2, &busy);
    // The first one goes on undisturbed.
    assert!(first.try_wait().expect("a child").is_none());
    assert!(left(&desk.folder.join("out")).iter().all(|name| name.ends_with(".part")));
    first.kill().expect("killed");
    first.wait().expect("a child");
    desk.run(&MOVE).done();
}

#[test]
fn a_killed_run_leaves_no_half_file_and_the_next_one_removes_its_rest() {
    let desk = Desk::new("killed");
    desk.run(&MOVE).done();
    let mut child = writing(&desk, "9000");
    // The files of the run before are gone, and one of this run has begun.
    let begun = || left(&desk.folder.join("out")).first().is_some_and(|name| name.starts_with(".trajectory.csv."));
    while !begun() || left(&desk.folder.join("out")).len() > 1 {
        std::thread::sleep(Duration::from_millis(5));
    }
    // No handler sees this one.
    child.kill().expect("killed");
    child.wait().expect("a child");
    let rest = left(&desk.folder.join("out"));
    assert!(!rest.is_empty() && rest.iter().all(|name| name.starts_with(".trajectory.csv.")), "{rest:?}");
    let mine = "my.notes";
    desk.write(&format!("out/{mine}"), "kept");
    desk.run(&MOVE).done();
    let names = left(&desk.folder.join("out"));
    assert!(names.iter().all(|name| !name.starts_with('.')), "{names:?}");
    assert!(names.contains(&mine.to_owned()) && names.contains(&"report.json".to_owned()), "{names:?}");
}

#[test]
fn an_output_folder_that_vanishes_is_named() {
    let desk = Desk::new("vanishes");
    let child = writing(&desk, "100");
    std::fs::remove_dir_all(desk.folder.join("out")).expect("removed");
    let output = child.wait_with_output().expect("a child");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("out/") && text.contains("cannot be written"), "{text}");
    assert!(left(&desk.folder.join("out")).is_empty());
}

#[test]
fn a_full_standard_output_is_a_failure() {
    let Ok(full) = std::fs::File::options().write(true).open("/dev/full") else { return };
    let output = Command::new(binary()).arg("robots").stdout(full).output().expect("the binary runs");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("stdout") && text.contains("No space left"), "{text}");
}

#[test]
fn a_folder_that_takes_no_files_is_named() {
    let desk = Desk::new("read_only");
    desk.run(&[&MOVE[..], &["--out", "/dev/null/out"]].concat())
        .refused(2, &["/dev/null/out", "cannot be written", "Not a directory"]);
    let folder = desk.folder.join("closed");
    std::fs::create_dir_all(&folder).expect("a writable target folder");
    let permissions = |mode| std::os::unix::fs::PermissionsExt::from_mode(mode);
    std::fs::set_permissions(&folder, permissions(0o555)).expect("ours");
    // The superuser writes everywhere.
    if std::fs::write(folder.join("probe"), "").is_err() {
        desk.run(&[&MOVE[..], &["--out", "closed"]].concat())
            .refused(2, &["closed/trajectory.csv", "cannot be written", "Permission denied"]);
    }
    std::fs::set_permissions(&folder, permissions(0o755)).expect("ours");
}

/// Runs the command on a disk of 300 kB of its own; `None` where the system gives no such disk.
fn on_a_tiny_disk(desk: &Desk, args: &[&str]) -> Option<(Run, Vec<String>)> {
    let script =
        "mount -t tmpfs -o size=300k tmpfs out || exit 77; \"$0\" \"$@\"; code=$?; ls -A out >left.txt; exit $code";
    std::fs::create_dir_all(desk.folder.join("out")).expect("a writable target folder");
    let mut command = Command::new("unshare");
    command.args(["-rm", "sh", "-c", script, &binary()]).args(args).current_dir(&desk.folder);
    let run = Run::new(args, command.output().ok()?);
    if run.code == 77 || run.stderr.contains("unshare") {
        return None;
    }
    let left = std::fs::read_to_string(desk.folder.join("left.txt")).ok()?;
    Some((run, left.lines().map(str::to_owned).collect()))
}

#[test]
fn a_disk_that_is_full_leaves_nothing_behind() {
    let desk = Desk::new("tiny_disk");
    desk.write("jobs.jsonl", "{\"id\": \"a\"}\n");
    let Some((run, left)) = on_a_tiny_disk(&desk, &["plan"]) else { return };
    run.refused(2, &["out/trajectory.csv", "No space left on device"]);
    assert!(left.is_empty(), "{left:?}");
    let Some((run, left)) = on_a_tiny_disk(&desk, &MOVE) else { return };
    run.refused(2, &["out/", "No space left on device"]);
    assert!(left.is_empty(), "{left:?}");
    // Of a batch the results stay, with the reason, and no half trajectory.
    let batch = ["batch", "jobs.jsonl", "--trajectories", "--out", "out"];
    let Some((run, left)) = on_a_tiny_disk(&desk, &batch) else { return };
    assert!(run.code == 1 && run.stdout.contains("No space left on device"), "{run:?}");
    assert_eq!(left, ["results.jsonl", "trajectories"], "{run:?}");
}

#[test]
fn the_language_of_the_system_changes_no_number() {
    let desk = Desk::new("locale");
    desk.run(&MOVE).done();
    let plain = std::fs::read(desk.folder.join("out/trajectory.csv")).expect("written");
    let output = Command::new(binary())
        .args(MOVE)
        .envs([("LC_ALL", "de_DE.UTF-8"), ("LANG", "de_DE.UTF-8"), ("LC_NUMERIC", "de_DE.UTF-8")])
        .current_dir(&desk.folder)
        .output();
    Run::new(&MOVE, output.expect("the binary runs")).done();
    assert_eq!(std::fs::read(desk.folder.join("out/trajectory.csv")).expect("written"), plain);
}
