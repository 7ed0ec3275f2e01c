//! Dwells (G4): the tool waits, and all that comes after is later by that.

use crate::common::Desk;
use crate::program_case::{Script, planned};

/// A line with a stop in its middle, at rest there for some time.
fn line(seconds: Option<f64>) -> Script {
    let mut script = Script::new([0.0, 0.0, 0.0], 0.0);
    script.to([60.0, 0.0, 0.0], Some(80.0));
    match seconds {
        Some(seconds) => script.rest(seconds),
        None => script.say("G61.1"),
    }
    script.to([120.0, 0.0, 0.0], Some(80.0));
    script
}

#[test]
fn a_dwell_takes_its_time_and_nothing_more() {
    let desk = Desk::new("dwell_line");
    // G61.1 is the mode of the line after it: a stop in the corner without an angle needs it on the line before.
    let mut stop = Script::new([0.0, 0.0, 0.0], 0.0);
    stop.say("G61.1");
    stop.to([60.0, 0.0, 0.0], Some(80.0));
    stop.to([120.0, 0.0, 0.0], Some(80.0));
    let stop = planned(&desk, &stop, "");
    assert!(stop.parts("path").is_empty());
    for seconds in [0.0, 1e-4, 0.0123, 0.5, 12.0] {
        let script = line(Some(seconds));
        let planned = planned(&desk, &script, "");
        planned.keeps(&script, Some(100.0), 1e-3);
        let longer = planned.duration() - stop.duration();
        assert!((longer - seconds).abs() < 1e-4, "{longer} s longer for a dwell of {seconds} s");
        assert_eq!(planned.parts("path").len(), 2);
    }
}

#[test]
fn dwells_stand_before_behind_and_between_paths() {
    let desk = Desk::new("dwell_places");
    for job in ["", "[feed]\nrapid = \"joints\"\n"] {
        let mut script = Script::new([0.0, 0.0, 10.0], 0.05);
        script.rest(0.25);
        script.say("M3");
        script.to([0.0, 0.0, 0.0], Some(50.0));
        script.to([40.0, 0.0, 0.0], Some(50.0));
        script.say("M5");
        script.rest(0.3);
        script.rest(0.1);
        script.say("M7");
        script.to([40.0, 0.0, 10.0], None);
        script.to([40.0, 50.0, 10.0], None);
        script.rest(0.2);
        script.to([40.0, 50.0, 0.0], None);
        script.to([0.0, 50.0, 0.0], Some(50.0));
        script.to([0.0, 50.0, 10.0], None);
        script.rest(0.15);
        script.say("M30");
        let planned = planned(&desk, &script, job);
        planned.keeps(&script, if job.is_empty() { Some(100.0) } else { None }, 1e-3);
        let time = |what: &str| {
            let marks = planned.report["program"]["markers"].as_array().expect("a list");
            let mark = marks.iter().find(|mark| mark["what"] == what).unwrap_or_else(|| panic!("no {what}"));
            mark["t_s"].as_f64().expect("a time")
        };
        let dwell = |i: usize| planned.parts("dwell")[i]["begin_s"].as_f64().expect("a time");
        for (what, at) in [("M3", 0.25), ("M5", dwell(1)), ("M7", dwell(2) + 0.1), ("M30", planned.duration())] {
            assert!((time(what) - at).abs() < 1e-9, "{what} at {} s, not {at} s", time(what));
        }
    }
}

#[test]
fn the_tool_turns_on_through_dwells_in_step_with_the_way() {
    let desk = Desk::new("dwell_slerp");
    let job = "[orientation]\nmode = \"slerp\"\nfrom_rpy_deg = [180, 0, 0]\nto_rpy_deg = [180, 0, 60]\n";
    let script = line(Some(0.2));
    let rests = planned(&desk, &script, job);
    rests.keeps(&script, Some(100.0), 1e-3);
    for (row, point) in rests.rows.iter().zip(&rests.points) {
        // Half a turn about x, then about z: x y z w = cos(a), sin(a), 0, 0 with a half of the turn about z.
        let half = (30.0 * point.x / 120.0_f64).to_radians();
        let off = row.quaternion[0].abs() - half.cos();
        assert!(off.abs() < 1e-9 && row.quaternion[3].abs() < 1e-9, "{:?} at {} mm", row.quaternion, point.x);
    }
}

#[test]
fn a_program_that_waits_too_long_is_refused_by_line() {
    let desk = Desk::new("dwell_long");
    for (program, parts) in [
        ("G21 G0 X0 Y0\nG1 X20 F600\nG4 P1000000000\nX40\n", &["p.ngc:3", "G4", "3600 s"][..]),
        ("G21 G0 X0 Y0\nG1 X20 F600\nG4 P3000\nX40\nG4 P601\nX60\n", &["p.ngc:5", "makes 3601 s in all"]),
    ] {
        desk.write("p.ngc", program);
        desk.run(&["plan", "p.ngc"]).refused(2, parts);
    }
    desk.write("p.ngc", "G21 G4 P1000000000\nG0 X5 Y0\nG1 X20 F600\n");
    desk.run(&["plan", "p.ngc"]).refused(2, &["p.ngc:1", "G4", "3600 s"]);
}

/// A dwell among the rapid moves that lead to the start is a rest there.
#[test]
fn a_dwell_before_the_first_working_move_is_waited_for() {
    let desk = Desk::new("dwell_first");
    let duration = |dwells: &str| {
        desk.write("p.ngc", &format!("G21 G90 G61\n{dwells}G0 X5 Y0\nG1 X40 F1200\nM2\n"));
        let report = desk.run(&["plan", "p.ngc", "--json"]).done().json();
        report["duration_s"].as_f64().expect("a number")
    };
    let without = duration("");
    for (dwells, seconds) in [("G4 P0.7\n", 0.7), ("G0 X9\nM3 S100\nG4 P0.5\nG0 X7\nG4 P0.25\n", 0.75)] {
        assert!((duration(dwells) - without - seconds).abs() < 1e-3, "{} s", duration(dwells) - without);
    }
}

/// Where the path behind a dwell asks for other joints than those in which the arm waits, the tool would have to leave its place.
#[test]
fn the_arm_does_not_turn_in_place_at_a_dwell() {
    let desk = Desk::new("dwell_turns");
    let head = "G21 G90 G61\nG0 X0 Y0 Z0\n";
    // A corner with a tool that follows the tangent, and two circles that wind up joint 6.
    for (name, body) in [
        ("corner.ngc", "G1 X40 F1200\nG4 P0.5\nG1 Y40\nM2\n"),
        ("circles.ngc", "G2 I20 F1200\nG4 P0.5\nG2 I20\nG4 P0.5\nG2 I20\nM2\n"),
    ] {
        desk.write(name, &format!("{head}{body}"));
        desk.write("job.toml", "[orientation]\nmode = \"tangent\"\n");
        let run = desk.run(&["plan", name, "--job", "job.toml"]);
        assert_eq!(run.code, 1, "{run:?}");
        assert!(run.stderr.contains(name), "{run:?}");
        // Whatever the reason, it is told, and no file is left.
        assert!(!desk.folder.join("out/trajectory.csv").exists());
    }
    let run = desk.run(&["plan", "corner.ngc", "--job", "job.toml"]);
    assert!(run.stderr.contains("behind a dwell") && run.stderr.contains("feed.rapid"), "{run:?}");
}

/// The last row is at rest whatever planner makes the law, and wherever its time rounds to.
#[test]
fn every_planner_ends_at_rest_behind_a_dwell() {
    let desk = Desk::new("dwell_planners");
    for planner in ["jerk-limited", "per-segment", "reachability", "interpolated-reachability"] {
        desk.write("job.toml", &format!("[plan]\nplanner = \"{planner}\"\n"));
        for i in (1..=20).step_by(4) {
            // Ends on which the difference of two times rounds down, among others.
            let (wait, end) = (format!("0.0{}", 37 * i + 11), format!("1{i:02}.{i}"));
            let text = format!("G21 G90 G61\nG0 X0 Y0 Z0\nG1 X60 F3000\nG4 P{wait}\nG1 X{end}\nM2\n");
            desk.write("part.ngc", &text);
            desk.run(&["plan", "part.ngc", "--job", "job.toml"]).done();
            let rows = desk.trajectory::<6>("out");
            let last = rows.last().expect("rows");
            assert!(last.qd.iter().chain(&last.qdd).all(|v| v.abs() < 1e-9), "{planner} {wait}: {last:?}");
        }
    }
}
