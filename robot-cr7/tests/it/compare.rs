//! All planners on one job, and torque, sections and speeds at the ends through job files.

use arcfeed_interp::{MotionPath, ToolPath};
use std::path::Path;

use arcfeed_kinematics::Arm;
use robot_cr7::{Cr7Error, Job, Robot, SamplePath, Task, compare};

fn job(text: &str) -> Job {
    Job::from_bytes(text.as_bytes(), Path::new("job.toml")).expect("a valid job")
}

fn on(robot: &str, job: &Job) -> Result<Task<Arm<6>>, Cr7Error> {
    let robot = Robot::load(robot, None, None)?;
    let (limits, _) = robot.limits::<6>(&job.joints)?;
    let arm = robot.arm::<6>(job.tool)?;
    let file = SamplePath::SixPoint.load().expect("comes with the program");
    Task::new(job, &file, &limits, robot.drives::<6>(job)?, |path| {
        let start = ToolPath::new(&arm, path.clone(), limits.range())?.start();
        Ok((arm, start))
    })
}

#[test]
fn every_planner_is_held_against_the_same_limits() {
    let file = SamplePath::SixPoint.load().expect("comes with the program");
    // Quick joints are the limit, so that the scans have something to break.
    let job =
        job("[feed]\nfeed_mm_s = 1000\nnormal_acceleration_mm_s2 = 50000\ntangential_acceleration_mm_s2 = 5000\n\
                   tangential_jerk_mm_s3 = 1e6\n[tolerance]\nchord_mm = 0.05");
    let mut seen = Vec::new();
    let comparison = compare(&Task::of_cr7(&job, &file).expect("a task"), |name| seen.push(name)).expect("all plan");
    let entry = |name: &str| comparison.entries.iter().find(|e| e.planner == name).expect("in the table");
    let duration = |name: &str| entry(name).duration_s.expect("a motion");
    println!("{comparison}");
    // The optimum of second order is a bound for everything that keeps more limits, but for the constant acceleration between
    // grid points that it assumes: that costs up to 0.5 %.
    let best = duration("reachability");
    for name in [
        "forward-backward",
        "interpolated-reachability",
        "jerk-limited",
        "continuous-acceleration",
        "per-segment",
        "cr7 plan, verified",
    ] {
        assert!(duration(name) > best * (1.0 - 5e-3), "{name}: {} against {best}", duration(name));
    }
    assert!(duration("jerk-limited") < duration("continuous-acceleration"));
    assert!(duration("continuous-acceleration") < duration("per-segment"));
    for name in ["jerk-limited", "continuous-acceleration", "per-segment", "cr7 plan, verified"] {
        let worst = &entry(name).worst[0];
        assert!(entry(name).jerk_limited && worst.ratio < 1.001, "{name}: {worst:?}");
        assert!(entry(name).worst.iter().any(|w| w.name == "joint jerk"));
    }
    assert!(entry("cr7 plan, verified").keeps());
    let published = &entry("published").worst[0];
    assert!(published.ratio > 1.001 && published.ratio > entry("forward-backward").worst[0].ratio, "{published:?}");
    assert!(!entry("published").jerk_limited && entry("published").worst.iter().all(|w| w.name != "joint jerk"));
    for name in ["published", "interpolated-reachability", "jerk-limited", "plan of the job"] {
        assert!(seen.contains(&name), "{name} in {seen:?}");
    }
    // Either the bound, or how to get it.
    let text = comparison.to_string();
    if cfg!(feature = "baseline") {
        let bound = comparison.lower_bound_s.expect("solved");
        assert!(duration("forward-backward") >= bound && duration("conic optimum") / bound < 1.0001, "{bound}");
        assert!(entry("jerk-limited").ratio_to_bound.expect("known") > 1.0);
    } else {
        assert!(comparison.lower_bound_s.is_none() && text.contains("--features baseline"));
    }
    assert!(text.contains("ignored") && text.contains("BROKEN by"), "{text}");
    let json: serde_json::Value = serde_json::to_value(&comparison).expect("valid JSON");
    assert_eq!(json["entries"].as_array().expect("a list").len(), comparison.entries.len());
    assert!(json["entries"][0]["worst"][0]["at_s_m"].is_number());
    #[cfg(feature = "plot")]
    {
        let svg = robot_cr7::plot::compare_picture(&comparison).expect("drawn");
        assert!(svg.contains("jerk-limited") && svg.contains("published") && !svg.contains("NaN"));
    }
}

#[test]
fn a_payload_too_heavy_is_refused_by_joint_and_place() {
    let base = "[torque]\nlimited = true\n";
    let task = on("ur5e", &job(&format!("{base}payload_kg = 5"))).expect("a task");
    let light = task.plan().expect("light enough");
    let check = light.report(0, std::time::Duration::ZERO);
    let torque: Vec<_> = check.limits.iter().filter(|l| l.name == "joint torque").collect();
    assert!(torque.len() == 6 && torque.iter().all(|l| l.ratio < 1.0), "{torque:?}");
    assert_eq!((check.planner.as_str(), check.planning_rounds), ("jerk-limited", 1));
    let error = on("ur5e", &job(&format!("{base}payload_kg = 60"))).expect("a task").plan().expect_err("too heavy");
    let text = error.to_string();
    for part in ["torque of joint", "N m over its limit", "tool at x", "carry less"] {
        assert!(text.contains(part), "{part} in {text}");
    }
}

#[test]
fn torque_limits_nobody_knows_are_asked_for() {
    let file = SamplePath::SixPoint.load().expect("comes with the program");
    let error = Task::of_cr7(&job("[torque]\nlimited = true"), &file).expect_err("the maker gives none").to_string();
    assert!(error.contains("torque limits are not known") && error.contains("torque.limit_nm"), "{error}");
    let own = Task::of_cr7(&job("[torque]\nlimit_nm = 300"), &file).expect("own limits");
    assert!(own.drives().is_some_and(|drives| drives.torque[5] == 300.0));
    let count = Task::of_cr7(&job("[torque]\nlimit_nm = [300, 300]"), &file).expect_err("two of six").to_string();
    assert!(count.contains("torque.limit_nm") && count.contains("lists 2 numbers"), "{count}");
}

#[test]
fn the_feeds_of_a_job_are_those_of_the_motion() {
    let file = SamplePath::SixPoint.load().expect("comes with the program");
    let text = "[feed]\nfeed_mm_s = 60\nend_mm_s = 20\n[[sections]]\nfeed_mm_s = 20\nfrom_mm = 10\nto_mm = 16";
    let task = Task::of_cr7(&job(text), &file).expect("a task");
    let motion = task.plan().expect("a motion");
    for setpoint in motion.setpoints().expect("a period") {
        let at = setpoint.expect("on the path");
        let feed = if at.s > 0.010 && at.s < 0.016 { 0.020 } else { 0.060 };
        assert!(at.feed <= feed * (1.0 + 1e-6), "{} m/s at {} m", at.feed, at.s);
    }
    let end = motion.setpoints().expect("a period").last().expect("an end").expect("on the path");
    assert!((end.feed - 0.020).abs() < 1e-9, "{}", end.feed);
    let wrong = "[[sections]]\nfeed_mm_s = 20\nfrom_mm = 10\nto_mm = 9999";
    let error = Task::of_cr7(&job(wrong), &file).expect("a task").plan().expect_err("off the path").to_string();
    assert!(error.contains("feed section 1") && error.contains("on the path"), "{error}");
}
