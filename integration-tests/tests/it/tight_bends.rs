//! Paths with places that are nearly a corner: see `integration_tests::tight_bends`; the example `soak` plans as
//! many as you like.

use std::path::Path;

use arcfeed_interp::{LimitError, MotionPath, PlanError, ToolPath};
use integration_tests::tight_bends::{Outcome, TightBend};
use robot_cr7::{Cr7Error, Job, PathFile, Robot, Task};

fn read(path: &str, job: &str) -> (Job, PathFile) {
    let job = Job::from_bytes(job.as_bytes(), Path::new("job.toml")).expect("a valid job");
    (job, PathFile::from_bytes(path.as_bytes(), Path::new("path.json"), None).expect("a valid path"))
}

/// A bend of radius 15 um lay between two grid points that both saw nothing of it; the joint jerk there reached 25537 %.
#[test]
fn a_bend_between_two_grid_points_is_seen() {
    let (job, file) = read(include_str!("../data/near_cusp.json"), include_str!("../data/near_cusp.toml"));
    let task = Task::of_cr7(&job, &file).expect("in reach");
    let motion = task.plan().expect("it can be followed");
    let plan = motion.trajectory();
    assert!(plan.verification().holds(1e-6));
    let bend = 0.812_552;
    let near = plan.joint_path().nodes().iter().filter(|node| (node.s - bend).abs() < 3e-5).count();
    assert!(near >= 8, "{near} grid points within two radii of the bend");
}

/// Two corners nearer together than the grid keeps apart left an empty stretch between two stops: "the list of segments is
/// empty".
#[test]
fn corners_a_hundredth_of_a_nanometre_apart_can_be_planned() -> Result<(), Cr7Error> {
    let (job, file) = read(include_str!("../data/empty_segments.json"), include_str!("../data/empty_segments.toml"));
    let robot = Robot::load("puma560", None, None)?;
    let (limits, _) = robot.limits::<6>(&job.joints)?;
    let arm = robot.arm::<6>(job.tool).map_err(Cr7Error::from)?;
    let start = |path: &arcfeed_geometry::PosePath| {
        let start = ToolPath::new(&arm, path.clone(), limits.range())?.start();
        Ok((arm, start))
    };
    let task = Task::new(&job, &file, &limits, None, start)?;
    assert!(task.plan()?.trajectory().verification().holds(1e-6));
    Ok(())
}

/// A feed that no acceleration on the path reaches changes nothing; it lengthened the motion threefold, and above 1e12 mm/s the
/// planner did not come back.
#[test]
fn a_feed_out_of_reach_changes_nothing() {
    let file = robot_cr7::butterfly().expect("embedded");
    let at = |feed: f64| {
        let mut job = Job::default();
        job.feed.feed = feed;
        let task = Task::of_cr7(&job, &file).expect("in reach");
        task.plan().expect("it can be followed").trajectory().duration()
    };
    let high = at(10.0);
    for feed in [1e9, 1e12, 1e100, 1e300] {
        assert_eq!(at(feed), high, "at {feed} m/s");
    }
}

/// A motion of more setpoints than are taken names the key that makes it so long.
#[test]
fn a_motion_that_is_too_long_names_the_key() {
    let file = robot_cr7::butterfly().expect("embedded");
    let error = |job: Job| Task::of_cr7(&job, &file).expect("in reach").plan().expect_err("too long");
    let mut slow = Job::default();
    slow.feed.feed = 1e-7;
    let mut lazy = Job::default();
    lazy.feed.tangential_acceleration = 1e-8;
    for (job, key) in [(slow, "feed.feed_mm_s"), (lazy, "feed.tangential_acceleration_mm_s2")] {
        let error = error(job);
        let Cr7Error::Plan { source, .. } = &error else { panic!("{error}") };
        assert!(
            matches!(**source, PlanError::Limit(LimitError::TooLong { longest, .. }) if longest == 5000.0),
            "{error}"
        );
        assert!(error.to_string().contains(key), "{error}");
    }
}

/// Four knots within 1e-12 of the length: a step of the acceleration kept its part of the jerk over the whole interval that follows the
/// last one, 1 % of the path, and the motion took 290 s where the feed asks for 7.1 s.
#[test]
fn knots_that_nearly_coincide_make_a_motion_slow_beside_them_alone() {
    let outcome = TightBend::random(40).play();
    assert!(matches!(outcome, Ok(Outcome::Planned(slower)) if slower < 1.1), "{outcome:?}");
}

/// Intervals between knots that are one rounding apart were divided: "drop duplicate points".
#[test]
fn knots_one_rounding_apart_can_be_planned() {
    for seed in [61, 122] {
        let outcome = TightBend::random(seed).play();
        assert!(matches!(outcome, Ok(Outcome::Planned(_))), "seed {seed}: {outcome:?}");
    }
}

#[test]
fn random_paths_are_planned_or_refused_with_a_reason() {
    let mut planned = 0;
    for seed in 0..8 {
        match TightBend::random(seed).play() {
            Ok(outcome) => planned += usize::from(matches!(outcome, Outcome::Planned(_))),
            Err(what) => panic!("`soak --family tight-bends --count 1 --seed {seed}`: {what}"),
        }
    }
    assert!(planned >= 5, "{planned} of 8 planned: too few to say anything");
}
