//! What goes wrong outside the program: full disks, folders that cannot be written, kills, two runs at once, files from Windows. Each run
//! ends with a code other than 0 and an error that names the file and the reason, and no file is half written under its name.
#![cfg(all(feature = "cli", unix))]

use crate::common;

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use common::{Desk, Run, binary};
use robot_cr7::{InputError, LimitLine, LimitUnit, LimitsHold, Staging, TrajectoryRow, write_trajectory};

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
        assert!(child.try_wait().expect("a child").is_none(), "ended before it wrote");
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
    // Some seconds of writing are left when the folder goes.
    let child = writing(&desk, "1000");
    // A file that is being made keeps the folder for a moment.
    while std::fs::remove_dir_all(desk.folder.join("out")).is_err() {}
    let output = child.wait_with_output().expect("a child");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("out/") && text.contains("cannot be written"), "{text}");
    assert!(left(&desk.folder.join("out")).is_empty());
}

#[test]
fn a_full_standard_output_is_a_failure() {
    let Ok(full) = std::fs::File::options().write(true).open("/dev/full") else {
        println!("skipped: no /dev/full");
        return;
    };
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
    } else {
        println!("skipped: the superuser writes everywhere");
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
        println!("skipped: this system gives no disk to an unprivileged program: {}", run.stderr);
        return None;
    }
    let left = std::fs::read_to_string(desk.folder.join("left.txt")).expect("written by the script");
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
    // Where the language is installed, other programs of the system do write a comma: what is compared could differ.
    let language = |program: &mut Command| {
        let names = ["LC_ALL", "LANG", "LC_NUMERIC"].map(|name| (name, "de_DE.UTF-8"));
        program.envs(names).current_dir(&desk.folder).output().expect("it runs")
    };
    let comma = language(Command::new("printf").arg("%.1f").arg("0")).stdout.contains(&b',');
    if !comma {
        println!("the language de_DE is not installed: only its name is given");
    }
    Run::new(&MOVE, language(Command::new(binary()).args(MOVE))).done();
    assert_eq!(std::fs::read(desk.folder.join("out/trajectory.csv")).expect("written"), plain);
}

#[test]
fn every_command_that_writes_keeps_the_folder_to_itself() {
    let desk = Desk::new("locked");
    std::fs::create_dir_all(desk.folder.join("out")).expect("a writable target folder");
    let folder = std::fs::File::open(desk.folder.join("out")).expect("a folder");
    folder.lock().expect("nobody else has it");
    let busy = ["out: another run writes into this folder", "flock", "--out"];
    desk.write("pick.toml", include_str!("../../schedules/pick.toml"));
    let commands = [
        &["inspect"][..],
        &["compare"],
        &["plan"],
        &["schedule", "pick.toml"],
        &["online"],
        &["run"],
        &["reproduce", "pn"],
    ];
    for command in commands {
        desk.run(&[command, &["--out", "out"]].concat()).refused(2, &busy);
        assert!(left(&desk.folder.join("out")).is_empty(), "{command:?}");
    }
}

#[test]
fn what_was_read_is_not_drawn_over() {
    let desk = Desk::new("drawn_over");
    std::fs::create_dir_all(desk.folder.join("out")).expect("a writable target folder");
    let badge = include_str!("../../data/drawings/badge.svg");
    for name in ["inspect.svg", "compare.svg"] {
        desk.write(&format!("out/{name}"), badge);
    }
    desk.write("job.toml", "[path]\nfile = \"out/compare.svg\"\n");
    desk.run(&["inspect", "out/inspect.svg", "--out", "out"]).refused(2, &["out/inspect.svg", "would be overwritten"]);
    desk.run(&["compare", "job.toml", "--out", "out"]).refused(2, &["out/compare.svg", "would be overwritten"]);
    for name in ["inspect.svg", "compare.svg"] {
        assert_eq!(std::fs::read_to_string(desk.folder.join("out").join(name)).expect("there"), badge);
    }
}

#[test]
fn a_robot_that_was_read_is_not_written_over() {
    let desk = Desk::new("robot_written_over");
    std::fs::create_dir_all(desk.folder.join("out")).expect("a writable target folder");
    let arm = include_str!("../../data/qb_arm.json");
    desk.write("out/report.json", arm);
    desk.write("pick.toml", include_str!("../../schedules/pick.toml"));
    for command in [&["plan"][..], &MOVE, &["schedule", "pick.toml"], &["online"], &["run"]] {
        desk.run(&[command, &["--robot", "out/report.json", "--out", "out"]].concat())
            .refused(2, &["out/report.json", "would be overwritten"]);
        assert_eq!(std::fs::read_to_string(desk.folder.join("out/report.json")).expect("there"), arm, "{command:?}");
    }
}

/// That a motion keeps its only limit.
fn proof() -> LimitsHold {
    let (name, unit) = ("joint velocity".to_owned(), LimitUnit::RadianPerSecond);
    let line = LimitLine {
        name,
        joint: Some(1),
        unit,
        value: 0.5,
        limit: 1.0,
        ratio: 0.5,
        at_s_m: None,
        at_t_s: 0.0,
        lines: None,
    };
    LimitsHold::of(&[line]).expect("it holds")
}

#[test]
fn a_refused_second_run_leaves_the_files_of_the_first() {
    let desk = Desk::new("refused_second");
    let folder = desk.folder.join("out");
    let staging = || Staging::new(&folder, &["trajectory.csv", "report.json"], &[]).expect("no inputs");
    let (mut first, mut second) = (staging(), staging());
    first.clear().expect("free");
    assert!(matches!(second.clear(), Err(InputError::Busy { .. })));
    first.write("report.json", "{}").expect("written");
    first.write("trajectory.csv", "t\n").expect("written");
    first.publish(&proof()).expect("published");
    // The folder is free when the second one gives up.
    drop(second);
    assert_eq!(left(&folder), ["report.json", "trajectory.csv"]);
}

#[test]
fn the_report_that_says_all_is_there_goes_first_and_comes_last() {
    let desk = Desk::new("report_last");
    let folder = desk.folder.join("out");
    std::fs::create_dir_all(&folder).expect("a writable target folder");
    let staging = || {
        // What is read is not removed at the end: it shows what was there in between.
        desk.write("out/report.json", "{}");
        let mut staging = Staging::new(&folder, &["trajectory.csv", "report.json"], &[]).expect("no inputs");
        staging.reads(&folder.join("report.json")).expect_err("one of the files");
        staging
    };
    let mut first = staging();
    first.clear().expect("free");
    first.write("report.json", "{}").expect("written");
    first.write("trajectory.csv", "t\n").expect("written");
    // A file cannot be renamed to a folder: the trajectory fails, and the report has not come.
    std::fs::create_dir(folder.join("trajectory.csv")).expect("free");
    first.publish(&proof()).expect_err("a folder is in the way");
    assert_eq!(left(&folder), ["trajectory.csv"]);
    // Neither can a folder be removed as a file: the report has gone before.
    staging().clear().expect_err("a folder is in the way");
    assert_eq!(left(&folder), ["trajectory.csv"]);
}

#[test]
fn a_panic_leaves_no_part_of_a_file() {
    let desk = Desk::new("panic");
    let names: Vec<String> = (1..=6).map(|k| format!("joint{k}")).collect();
    let file = desk.folder.join("trajectory.csv");
    let rows = std::iter::once_with(|| -> TrajectoryRow<6> { panic!("on purpose") });
    let written = std::panic::catch_unwind(|| write_trajectory(&file, &names, rows));
    assert!(written.is_err());
    assert!(left(&desk.folder).is_empty(), "{:?}", left(&desk.folder));
}

#[test]
fn hidden_files_of_killed_runs_are_removed_and_links_are_not_followed() {
    let desk = Desk::new("left_parts");
    desk.write("jobs.jsonl", "{\"id\": \"a\", \"robot\": \"nobody\"}\n");
    desk.write("mine.txt", "mine");
    std::fs::create_dir_all(desk.folder.join("out/trajectories")).expect("a writable target folder");
    let parts = ["out/.results.jsonl.7.0.part", "out/.other.svg.7.1.part", "out/trajectories/.a.csv.7.3.part"];
    for part in parts {
        desk.write(part, "");
    }
    for kept in ["out/.hidden", "out/.notes.part", "out/.video.2024.part", "out/a.7.part"] {
        desk.write(kept, "");
    }
    // In a container each program may have the number 1: a link under the next name leads nowhere.
    let pid = std::process::id();
    let links: Vec<_> = (0..200).map(|n| desk.folder.join(format!(".trajectory.csv.{pid}.{n}.part"))).collect();
    for link in &links {
        std::os::unix::fs::symlink(desk.folder.join("mine.txt"), link).expect("a link");
    }
    let names: Vec<String> = (1..=6).map(|k| format!("joint{k}")).collect();
    write_trajectory::<_, 6>(&desk.folder.join("trajectory.csv"), &names, []).expect("written");
    assert_eq!(std::fs::read_to_string(desk.folder.join("mine.txt")).expect("there"), "mine");
    assert!(desk.folder.join("trajectory.csv").is_file() && links.iter().all(|link| link.is_symlink()));
    desk.run(&["batch", "jobs.jsonl", "--trajectories", "--out", "out"]);
    assert_eq!(
        left(&desk.folder.join("out")),
        [".hidden", ".notes.part", ".video.2024.part", "a.7.part", "results.jsonl", "trajectories"]
    );
    assert!(left(&desk.folder.join("out/trajectories")).is_empty());
}
