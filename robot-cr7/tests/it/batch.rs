//! `cr7 batch`: every job has its line, whatever becomes of the others, and none is done twice.
#![cfg(feature = "cli")]

use crate::common;

use common::Desk;
use robot_cr7::{BatchResult, SamplePath};

fn results(desk: &Desk) -> Vec<BatchResult> {
    let text = std::fs::read_to_string(desk.folder.join("batch/results.jsonl")).expect("results");
    let mut results: Vec<BatchResult> =
        text.lines().map(|line| serde_json::from_str(line).expect("a result")).collect();
    results.sort_by(|a, b| a.id.cmp(&b.id));
    results
}

const JOBS: &str = r#"{"id": "a", "path": {"file": "six.json"}, "feed": {"feed_mm_s": 20}}
{"id": "b", "robot": "ur5e", "path": {"file": "six.json"}}

{"id": "c", "feed": {"feed_mm_sec": 20}}
no json
{"id": "d", "path": {"file": "nosuch.json"}}
{"id": "e", "path": {"file": "far.json"}}
{"id": "f", "robot": "nosuch"}
"#;

fn desk(name: &str) -> Desk {
    let desk = Desk::new(name);
    desk.write("six.json", SamplePath::SixPoint.json());
    desk.write(
        "far.json",
        r#"{"units": "m", "degree": 1, "control_points": [[0, 0, 0], [3, 0, 0]], "knots": [0, 0, 1, 1]}"#,
    );
    desk
}

#[test]
fn every_job_has_its_result_and_none_is_done_twice() {
    let desk = desk("batch");
    desk.write("jobs.jsonl", JOBS);
    let run = desk.run(&["batch", "jobs.jsonl", "-j", "2", "--trajectories"]);
    assert_eq!(run.code, 1, "{run:?}");
    let first = results(&desk);
    let ids: Vec<&str> = first.iter().map(|result| result.id.as_str()).collect();
    assert_eq!(ids, ["5", "a", "b", "c", "d", "e", "f"]);
    for (id, part) in
        [("5", "no JSON object"), ("c", "feed_mm_sec"), ("d", "nosuch.json"), ("e", "reach"), ("f", "nosuch")]
    {
        let error = first.iter().find(|result| result.id == id).and_then(|result| result.error.clone()).expect(id);
        assert!(error.contains(part), "{id}: {error}");
        assert!(run.stdout.contains(&error), "{id}: {run:?}");
    }
    for id in ["a", "b"] {
        let result = first.iter().find(|result| result.id == id).expect(id);
        assert!(result.error.is_none() && result.worst_ratio.is_some_and(|ratio| ratio <= 1.0 + 1e-6), "{result:?}");
        let file = std::fs::File::open(desk.folder.join(format!("batch/trajectories/{id}.csv"))).expect(id);
        let rows = robot_cr7::read_trajectory::<_, 6>(file, id.as_ref()).expect(id);
        assert_eq!(rows.last().map(|row| row.t), result.duration_s);
    }

    // Nothing is done again; a job that is new is done.
    desk.write("jobs.jsonl", &(JOBS.to_owned() + "{\"id\": \"g\", \"path\": {\"file\": \"six.json\"}}\n"));
    let run = desk.run(&["batch", "jobs.jsonl", "--trajectories"]);
    assert!(run.code == 1 && run.stdout.starts_with("1 motions,"), "{run:?}");
    assert!(run.stdout.contains("7 jobs had a result before, 5 of them a failure"), "{run:?}");
    let second = results(&desk);
    assert_eq!(&second[..7], &first[..]);

    // Failures are tried again where that is asked for.
    let run = desk.run(&["batch", "jobs.jsonl", "--retry", "--json"]);
    let tally: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert_eq!((&tally["done"], &tally["failed"], &tally["skipped"]), (&0.into(), &5.into(), &3.into()), "{run:?}");
    assert_eq!(results(&desk).len(), 8);
    // A trajectory that is missing is made.
    std::fs::remove_file(desk.folder.join("batch/trajectories/b.csv")).expect("written before");
    let run = desk.run(&["batch", "jobs.jsonl", "--trajectories"]);
    assert!(run.stdout.starts_with("1 motions,") && desk.folder.join("batch/trajectories/b.csv").exists(), "{run:?}");
}

#[test]
fn a_batch_that_was_killed_goes_on() {
    let desk = desk("batch_killed");
    let line = |id: &str| format!("{{\"id\": \"{id}\", \"path\": {{\"file\": \"six.json\"}}}}\n");
    desk.write("jobs.jsonl", &["a", "b", "c"].map(line).concat());
    desk.run(&["batch", "jobs.jsonl", "-j", "1"]).done();
    let whole = std::fs::read_to_string(desk.folder.join("batch/results.jsonl")).expect("results");
    // The line of the second job was not finished.
    let cut = whole.match_indices('\n').nth(1).expect("lines").0 - 10;
    desk.write("batch/results.jsonl", &whole[..cut]);
    let run = desk.run(&["batch", "jobs.jsonl"]).done();
    assert!(run.stdout.starts_with("2 motions,"), "{run:?}");
    let ids: Vec<String> = results(&desk).into_iter().map(|result| result.id).collect();
    assert_eq!(ids, ["a", "b", "c"]);
}

#[test]
fn a_folder_of_job_files_is_a_batch_and_names_that_lead_elsewhere_are_refused() {
    let desk = desk("batch_folder");
    std::fs::create_dir(desk.folder.join("jobs")).expect("a folder");
    desk.write("jobs/slow.toml", "[path]\nfile = \"../six.json\"\n[feed]\nfeed_mm_s = 5.0\n");
    desk.write("jobs/fast.toml", "[path]\nfile = \"../six.json\"\n[feed]\nfeed_mm_s = 50.0\n");
    desk.run(&["batch", "jobs", "--robot", "ur5e"]).done();
    let [fast, slow] = &results(&desk)[..] else { panic!("two results") };
    assert!(fast.duration_s < slow.duration_s && fast.robot == "ur5e", "{fast:?} {slow:?}");

    desk.write("out.jsonl", "{\"id\": \"../x\", \"path\": {\"file\": \"six.json\"}}\n");
    let run = desk.run(&["batch", "out.jsonl", "--out", "other", "--trajectories"]);
    assert!(run.code == 1 && run.stdout.contains("cannot be the name of a file"), "{run:?}");
    desk.write("twice.jsonl", "{\"id\": \"x\"}\n{\"id\": \"x\"}\n");
    let run = desk.run(&["batch", "twice.jsonl", "--out", "third"]);
    assert!(run.code == 2 && run.stderr.contains("twice.jsonl:2: id \"x\" is that of line 1"), "{run:?}");
    desk.write("number.jsonl", "{\"id\": \"2\"}\n{\"feed\": {\"feed_mm_s\": 20}}\n");
    let run = desk.run(&["batch", "number.jsonl", "--out", "fourth"]);
    assert!(run.code == 2 && run.stderr.contains("number.jsonl:2: id \"2\" is that of line 1"), "{run:?}");
    desk.write("empty.jsonl", "\n");
    assert_eq!(desk.run(&["batch", "empty.jsonl"]).code, 2);
}

#[test]
fn a_name_that_is_given_twice_in_a_line_is_the_last_one_everywhere() {
    let desk = desk("batch_twice_in_a_line");
    desk.write("jobs.jsonl", "{\"id\": \"b\", \"id\": \"a\"}\n{\"id\": \"a\"}\n");
    let run = desk.run(&["batch", "jobs.jsonl", "-j", "2", "--trajectories"]);
    run.refused(2, &["jobs.jsonl:2: id \"a\" is that of line 1"]);
}
