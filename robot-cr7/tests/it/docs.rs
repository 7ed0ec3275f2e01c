//! The pages of `docs/` and the README: every link leads somewhere, every command in a `console` block runs, every job is one.
#![cfg(feature = "cli")]

use std::fs;
use std::path::{Path, PathBuf};

use crate::common;

use common::Desk;
use robot_cr7::{Job, SamplePath};

/// The pages with their texts; none where the crate stands alone.
fn pages() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let Ok(docs) = fs::read_dir(root.join("docs")) else { return Vec::new() };
    let mut files: Vec<PathBuf> = docs.map(|entry| entry.expect("an entry").path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "md"));
    files.extend([root.join("README.md"), root.join("robot-cr7/python/README.md"), root.join("CONTRIBUTING.md")]);
    files.sort();
    files.into_iter().map(|file| (file.clone(), fs::read_to_string(&file).expect("a page"))).collect()
}

/// The blocks of a page that begin with this line.
fn blocks<'p>(page: &'p str, begin: &str) -> Vec<&'p str> {
    let fences: Vec<&str> = page.split("\n```").collect();
    fences.iter().filter_map(|block| block.strip_prefix(begin)?.strip_prefix('\n')).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let mut links = 0;
    for (file, page) in pages() {
        let folder = file.parent().expect("a folder");
        for link in page.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let target = link.split('#').next().unwrap_or_default();
            // A formula such as `C[i](u)` is no link.
            let is_file = target.contains('.') && !target.contains("://") && !target.contains(' ');
            if !is_file {
                continue;
            }
            links += 1;
            assert!(folder.join(target).exists(), "{}: {link}", file.display());
        }
    }
    assert!(links > 40 || pages().is_empty(), "{links}");
}

#[test]
fn every_page_is_in_the_summary() {
    let pages = pages();
    let Some((_, summary)) = pages.iter().find(|(file, _)| file.ends_with("SUMMARY.md")) else { return };
    for (file, _) in &pages {
        let name = file.file_name().expect("a name").to_string_lossy();
        let of_the_book = file.parent().is_some_and(|folder| folder.ends_with("docs"));
        assert!(!of_the_book || name == "SUMMARY.md" || summary.contains(&format!("({name})")), "{name}");
    }
}

#[test]
fn every_command_runs_and_every_job_is_one() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    let sample = |name: &str| fs::read_to_string(data.join(name)).expect("a sample");
    let desk = Desk::new("docs");
    desk.write("part.json", SamplePath::SixPoint.json());
    desk.write("points.csv", "x_mm,y_mm\n0,0\n20,8\n40,10\n60,8\n80,0\n");
    desk.write("star.ngc", &sample("gcode/star.ngc"));
    desk.write("plate.dxf", &sample("drawings/plate.dxf"));
    desk.write("arm.urdf", &desk.run(&["robots", "--urdf", "ur5e"]).done().stdout);
    desk.write("jobs.jsonl", "{\"id\": \"a\", \"path\": {\"file\": \"part.json\"}}\n");
    desk.write("job.toml", "[path]\nfile = \"part.json\"\n");
    let mut commands = 0;
    for (file, page) in pages() {
        for block in blocks(&page, "toml") {
            let job = Job::from_bytes(block.as_bytes(), &file);
            assert!(job.is_ok(), "{}: {:?}\n{block}", file.display(), job.err().map(|error| error.to_string()));
        }
        for line in blocks(&page, "console").into_iter().flat_map(str::lines) {
            let Some(command) = line.strip_prefix("$ cr7 ") else { continue };
            let arguments: Vec<&str> = command.split_whitespace().collect();
            if arguments.first() == Some(&"send") && !cfg!(feature = "controller") {
                continue;
            }
            let run = desk.run(&arguments);
            assert_eq!(run.code, 0, "{}: {line}\n{run:?}", file.display());
            commands += 1;
        }
    }
    assert!(commands > 15 || pages().is_empty(), "{commands}");
}
