//! `cr7 advise`: the seconds that limits cost, against closed forms and against the order that limits have.

use std::path::Path;

use robot_cr7::{Advice, Job, PathFile, SamplePath, Task};

fn job(text: &str) -> Job {
    Job::from_bytes(text.as_bytes(), Path::new("job.toml")).expect("a valid job")
}

/// Time from rest to rest over `length` with seven phases, none of which is empty.
fn seven_phases(length: f64, v: f64, a: f64, j: f64) -> f64 {
    assert!(v * j >= a * a && length >= v * (v / a + a / j), "a phase is empty");
    length / v + v / a + a / j
}

#[test]
fn what_limits_save_on_a_straight_line_is_known_in_closed_form() {
    // Joints that are no limit.
    let job =
        job("[joints]\nvelocity_deg_s = 1e4\nacceleration_deg_s2 = 1e6\njerk_deg_s3 = 1e8\n[feed]\nfeed_mm_s = 200\n\
         tangential_acceleration_mm_s2 = 1000\ntangential_jerk_mm_s3 = 20000");
    let file = PathFile::from_bytes(b"x_mm,y_mm\n0,0\n100,0\n200,0\n", Path::new("line.csv"), None).expect("points");
    let advice = Advice::new(&Task::of_cr7(&job, &file).expect("in reach"), |_| {}).expect("a motion");
    let (v, a, j) = (0.2, 1.0, 20.0);
    let time = |v: f64, a: f64, j: f64| seven_phases(0.2, v, a, j);
    let base = time(v, a, j);
    assert!((advice.duration_s / base - 1.0).abs() < 1e-5, "{} {base}", advice.duration_s);
    for (name, raised) in [
        ("feed", time(1.1 * v, a, j)),
        ("tangential acceleration", time(v, 1.1 * a, j)),
        ("tangential jerk", time(v, a, 1.1 * j)),
    ] {
        let cost = advice.costs.iter().find(|cost| cost.name == name).expect(name);
        // The planner is that near to the optimum.
        let (saved, lifted) = (cost.raised_saves_s.expect("planned"), cost.lifted_saves_s.expect("planned"));
        assert!((saved - (base - raised)).abs() < 5e-4 * base, "{name}: {cost:?} {}", base - raised);
        assert!(lifted > saved, "{cost:?}");
    }
    assert_eq!(advice.costs.len(), 3, "{advice}");
    assert_eq!(advice.costs[0].name, "feed");
    assert!(advice.costs.windows(2).all(|pair| pair[0].raised_saves_s >= pair[1].raised_saves_s));
    let text = advice.to_string();
    for part in ["feed.feed_mm_s", "Raise the feed first", "joint jerk J1 J2 J3 J4 J5 J6"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn raising_a_limit_never_costs_time() {
    for (sample, text) in [(SamplePath::Butterfly, "[feed]\n"), (SamplePath::Fan, "[feed]\nfeed_mm_s = 300\n")] {
        let file = sample.load().expect("comes with the program");
        let advice = Advice::new(&Task::of_cr7(&job(text), &file).expect("in reach"), |_| {}).expect("a motion");
        for cost in &advice.costs {
            let least = -1e-3 * advice.duration_s;
            let saved = [cost.raised_saves_s, cost.lifted_saves_s].map(|saved| saved.expect("planned"));
            assert!(saved.iter().all(|saved| *saved >= least), "{}: {cost:?}", sample.name());
        }
    }
}

#[test]
fn the_feed_of_a_program_is_that_of_its_lines() {
    let text = b"G21 G90 G61\nG0 X0 Y0 Z0\nG1 X150 F1200\nG4 P2\nG1 X0 F1200\nM2\n";
    let file = PathFile::from_bytes(text, Path::new("part.ngc"), None).expect("a program");
    let advice = Advice::new(&Task::of_cr7(&Job::default(), &file).expect("in reach"), |_| {}).expect("a motion");
    assert!(advice.costs[0].name == "feed" && advice.costs[0].key.starts_with("F of the program"), "{advice}");
    assert!(advice.warnings.iter().any(|warning| warning.contains("does not wait")), "{:?}", advice.warnings);
}

#[cfg(feature = "cli")]
#[test]
fn the_command_says_which_limit_to_raise_first() {
    let desk = crate::common::Desk::new("advise");
    desk.write("line.csv", "x_mm,y_mm\n0,0\n100,0\n200,0\n");
    desk.write("job.toml", "[path]\nfile = \"line.csv\"\n");
    let run = desk.run(&["advise", "job.toml", "--json"]).done();
    let first = &run.json()["costs"][0];
    assert_eq!(first["key"], "feed.feed_mm_s");
    assert!(first["raised_saves_s"].as_f64().expect("a number") > 0.0);
    assert!(desk.run(&["advise", "job.toml"]).done().stdout.contains("Raise the feed first"));
    desk.run(&["advise", "missing.toml"]).refused(2, &["missing.toml"]);
}
