//! Random `cr7 schedule`, `cr7 move` and `cr7 online`: whenever the exit code is 0, the file that was written keeps every limit,
//! by differences of its numbers; otherwise there is none.
//!
//! `ARCFEED_CASES=100 cargo test --release -p robot-cr7 --test it random_jobs -- --nocapture` searches longer; `ARCFEED_CASES=S..T` plays
//! the cases of these seeds. A failing case prints its command and its file.
#![cfg(feature = "cli")]

use crate::common;
use crate::keeps;

use arcfeed_kinematics::{ArmDynamics, Dynamics, ForwardKinematics, Inertial, Joints};
use arcfeed_testing::{Random, cases};
use common::{Desk, Run};
use keeps::{Limits, broken};
use nalgebra::{Isometry3, Matrix3, Vector3};
use robot_cr7::{Robot, TrajectoryRow};

/// By its logarithm, with four digits.
fn size(random: &mut Random, low: f64, high: f64) -> f64 {
    format!("{:.3e}", random.log(low, high)).parse().expect("a number")
}

/// Joints around `home`, degrees.
fn around<const N: usize>(random: &mut Random, home: [f64; N], by: f64) -> [f64; N] {
    home.map(|q| {
        let q = q + random.between(-by, by);
        if random.chance(0.5) { (q * 10.0).round() / 10.0 } else { q }
    })
}

/// Runs `case` for every seed and tells how many ended how.
fn search(name: &str, case: impl Fn(&Desk, u64) -> i32) {
    let (seeds, desk) = (cases(8), Desk::new(name));
    let mut codes = [0, 0, 0];
    for seed in seeds.clone() {
        codes[usize::try_from(case(&desk, seed)).expect("a code")] += 1;
    }
    println!("{name}: seeds {seeds:?}: {} done, {} refused, {} bad", codes[0], codes[1], codes[2]);
    assert_eq!(codes[2], 0, "all inputs are good ones");
    assert!(seeds.count() < 8 || codes[0] > 0, "some are done");
}

/// What a run may do: keep the limits, or leave nothing.
fn judge<const N: usize>(desk: &Desk, run: &Run, limits: &Limits<N>, said: &str) {
    let file = desk.folder.join("out/trajectory.csv");
    if run.code != 0 {
        assert!(!file.exists(), "a file of a refused job: {run:?}\n{said}");
        return;
    }
    if let Some(what) = broken(&desk.trajectory::<N>("out"), limits) {
        panic!("{what}\n{}\n{said}", run.command);
    }
}

/// Limits of the joints (degrees) with the robot's own range.
fn limits<const N: usize>(robot: &Robot, rates: [f64; 3]) -> Limits<N> {
    let range = robot.limits::<N>(&Default::default()).expect("limits").0;
    let [velocity, acceleration, jerk] = rates.map(|v| [v.to_radians(); N]);
    // A place on the very end of the range is good to rounding.
    let ends = |k: usize| [range.lower()[k] - 1e-9, range.upper()[k] + 1e-9];
    let range = std::array::from_fn(ends);
    Limits { velocity, acceleration, jerk, range, linear: f64::INFINITY, angular: f64::INFINITY }
}

fn list(values: &[f64]) -> String {
    format!("{values:?}")
}

const SIX: [(&str, [f64; 6]); 3] = [
    ("cr7", [0.0, -30.0, 90.0, 30.0, -90.0, 0.0]),
    ("kr6_r700", [0.0, -70.0, 100.0, 0.0, 60.0, 0.0]),
    ("ur5e", [0.0, -90.0, 90.0, -90.0, -90.0, 0.0]),
];
const PANDA: [f64; 7] = [0.0, -20.0, 0.0, -110.0, 0.0, 95.0, 40.0];
const PLANAR: [f64; 2] = [10.0, 60.0];

fn schedule_case(desk: &Desk, seed: u64) -> i32 {
    let mut random = Random::new(seed);
    match random.below(5) {
        0 => schedule_of(desk, &mut random, ("panda", PANDA), seed),
        1 => schedule_of(desk, &mut random, ("planar_2r", PLANAR), seed),
        _ => {
            let robot = SIX[random.below(3)];
            schedule_of(desk, &mut random, robot, seed)
        }
    }
}

fn schedule_of<const N: usize>(desk: &Desk, random: &mut Random, (name, home): (&str, [f64; N]), seed: u64) -> i32 {
    let robot = Robot::load(name, None, None).expect("built in");
    let planner = random.one_of(&[
        "forward-backward",
        "continuous-acceleration",
        "reachability",
        "interpolated-reachability",
        "jerk-limited",
    ]);
    let rates = [size(random, 10.0, 200.0), size(random, 30.0, 2000.0), size(random, 500.0, 40_000.0)];
    let mut limits = limits::<N>(&robot, rates);
    if !["jerk-limited", "continuous-acceleration"].contains(&planner) {
        limits.jerk = [f64::INFINITY; N];
    }
    let mut text = String::from("[motion]\n");
    if random.chance(0.8) {
        text += &format!("intervals = {}\n", size(random, 4.0, 600.0).round());
    }
    if random.chance(0.2) {
        text += &format!("start_speed = {}\n", size(random, 0.1, 10.0));
    }
    if random.chance(0.2) {
        text += &format!("end_speed = {}\n", size(random, 0.1, 10.0));
    }
    text += &format!("[sampling]\nperiod_ms = {}\n", [0.5, 1.0, 2.0, 4.0, 8.0][random.below(5)]);
    let [velocity, acceleration, jerk] = rates;
    text +=
        &format!("[limits]\nvelocity_deg_s = {velocity}\nacceleration_deg_s2 = {acceleration}\njerk_deg_s3 = {jerk}\n");
    if random.chance(0.4) {
        let speed = size(random, 5.0, 800.0);
        limits.linear = speed * 1e-3;
        text += &format!("linear_mm_s = {speed}\n");
    }
    if random.chance(0.4) {
        let speed = size(random, 3.0, 200.0);
        limits.angular = speed.to_radians();
        text += &format!("angular_deg_s = {speed}\n");
    }
    let torque = torque_limits(random, &robot, home, &mut text);
    let ends = if N == 6 && random.chance(0.5) { poses(random, &robot, home, &mut text) } else { None };
    let ends = ends.unwrap_or_else(|| waypoints(random, home, &mut text));
    desk.write("s.toml", &text);
    let run = desk.run(&["schedule", "s.toml", "--robot", name, "--planner", planner]);
    let said = format!("seed {seed}, s.toml:\n{text}");
    judge(desk, &run, &limits, &said);
    if run.code == 0 {
        let rows = desk.trajectory::<N>("out");
        if let Some(what) = torque.and_then(|(arm, limit)| too_much_torque(&rows, &arm, &limit)) {
            panic!("{what}\n{}\n{said}", run.command);
        }
        for (row, end) in [rows[0], rows[rows.len() - 1]].iter().zip(&ends) {
            let Some(end) = end else { continue };
            for (k, (q, end)) in row.q.iter().zip(end).enumerate() {
                assert!((q - end.to_radians()).abs() < 1e-6, "J{} at {}\n{said}", k + 1, row.t);
            }
        }
    }
    run.code
}

type Torque<const N: usize> = (ArmDynamics<N>, [f64; N]);

/// The arm's own limits of the torque, or some that hold it up with something to spare and a payload or none; `None` for an arm
/// whose masses or limits are unknown.
fn torque_limits<const N: usize>(
    random: &mut Random,
    robot: &Robot,
    home: [f64; N],
    text: &mut String,
) -> Option<Torque<N>> {
    let arm = robot.arm::<N>(Isometry3::identity()).expect("an arm");
    let mut dynamics = *arm.dynamics()?;
    if random.chance(0.5) {
        return Some((dynamics, arm.drive_limits().torque?.into()));
    }
    let held = dynamics.gravity_torque(&Joints::from(home.map(f64::to_radians)));
    let limit = std::array::from_fn(|k| (1.3 * held[k].abs() + 0.05 * held.amax()) * size(random, 1.0, 5.0));
    *text += &format!("torque_nm = {limit:?}\n");
    if random.chance(0.3) {
        let mass = size(random, 0.1, 2.0);
        *text += &format!("[payload]\nmass_kg = {mass}\ncentre_mm = [0.0, 0.0, 50.0]\n");
        let payload = Inertial::new(mass, Vector3::new(0.0, 0.0, 0.05), Matrix3::zeros()).expect("a payload");
        dynamics = dynamics.with_payload(payload).expect("a payload");
    }
    Some((dynamics, limit))
}

/// Torques of the rows by the arm's inverse dynamics, against the limits.
fn too_much_torque<const N: usize>(
    rows: &[TrajectoryRow<N>],
    arm: &ArmDynamics<N>,
    limit: &[f64; N],
) -> Option<String> {
    rows.iter().find_map(|row| {
        let torque = arm.torque(&Joints::from(row.q), &Joints::from(row.qd), &Joints::from(row.qdd));
        let over = (0..N).find(|&k| torque[k].is_nan() || torque[k].abs() > limit[k] * (1.0 + 1e-6))?;
        Some(format!("torque {} of {}, J{} at {}", torque[over], limit[over], over + 1, row.t))
    })
}

type Ends<const N: usize> = [Option<[f64; N]>; 2];

fn waypoints<const N: usize>(random: &mut Random, home: [f64; N], text: &mut String) -> Ends<N> {
    let mut points = vec![around(random, home, 20.0)];
    for _ in 0..1 + random.below(5) {
        // Sometimes hardly away from the one before.
        let by = if random.chance(0.2) { size(random, 1e-4, 1.0) } else { 30.0 };
        let from = if by < 2.0 { points[points.len() - 1] } else { home };
        points.push(from.map(|q| q + random.between(-by, by)));
    }
    for point in &points {
        *text += &format!("[[waypoint]]\nq_deg = {}\n", list(point));
    }
    [Some(points[0]), Some(points[points.len() - 1])]
}

/// Start and goal, each by joints or as a pose.
fn poses<const N: usize>(random: &mut Random, robot: &Robot, home: [f64; N], text: &mut String) -> Option<Ends<N>> {
    let arm = robot.arm::<N>(Isometry3::identity()).ok()?;
    let mut ends: Ends<N> = [None, None];
    for (end, by, key) in [(0, 20.0, "start"), (1, 40.0, "goal")] {
        let q = around(random, home, by);
        if random.chance(0.5) {
            *text += &format!("[{key}]\nq_deg = {}\n", list(&q));
            ends[end] = Some(q);
            continue;
        }
        let pose = arm.forward(&Joints::from(q.map(f64::to_radians)));
        let (roll, pitch, yaw) = pose.rotation.euler_angles();
        let (at, turned) = (pose.translation.vector * 1e3, [roll, pitch, yaw].map(f64::to_degrees));
        *text += &format!("[{key}]\nposition_mm = {}\nrotation_rpy_deg = {}\n", list(at.as_slice()), list(&turned));
        if end == 0 && random.chance(0.5) {
            *text += &format!("near_deg = {}\n", list(&q));
        }
    }
    Some(ends)
}

fn move_case(desk: &Desk, seed: u64) -> i32 {
    let mut random = Random::new(seed);
    match random.below(3) {
        0 => move_of(desk, &mut random, ("planar_2r", PLANAR), seed),
        1 => move_of(desk, &mut random, SIX[0], seed),
        _ => move_of(desk, &mut random, ("panda", PANDA), seed),
    }
}

fn move_of<const N: usize>(desk: &Desk, random: &mut Random, (name, home): (&str, [f64; N]), seed: u64) -> i32 {
    let robot = Robot::load(name, None, None).expect("built in");
    let rates = [size(random, 10.0, 200.0), size(random, 30.0, 2000.0), size(random, 500.0, 40_000.0)];
    let period = [0.5, 1.0, 4.0][random.below(3)];
    let [velocity, acceleration, jerk] = rates;
    let job = format!(
        "[joints]\nvelocity_deg_s = {velocity}\nacceleration_deg_s2 = {acceleration}\njerk_deg_s3 = {jerk}\n\
         [sampling]\nperiod_ms = {period}\n"
    );
    desk.write("job.toml", &job);
    let from = around(random, home, 20.0);
    let mut to = if random.chance(0.2) { from } else { around(random, home, 40.0) };
    if random.chance(0.3) {
        // Hardly anything to go for one joint.
        let k = random.below(N);
        to[k] = from[k] * (1.0 + 4.0 * f64::EPSILON);
    }
    let mut words: Vec<String> = vec!["move".into(), "--robot".into(), name.into(), "--job".into(), "job.toml".into()];
    let mut add = |flag: &str, values: &[f64]| {
        words.push(flag.to_owned());
        words.extend(values.iter().map(f64::to_string));
    };
    add("--from-deg", &from);
    add("--to-deg", &to);
    let mut start_v = [0.0; N];
    for (flag, most) in [("from", 0.9), ("to", 0.5)] {
        if random.chance(0.5) {
            let rate = [0.0; N].map(|_: f64| if random.chance(0.6) { random.between(-most, most) } else { 0.0 });
            let v = rate.map(|part| part * velocity);
            add(&format!("--{flag}-deg-s"), &v);
            if flag == "from" {
                start_v = v;
            }
            if random.chance(0.3) {
                add(&format!("--{flag}-deg-s2"), &rate.map(|_| random.between(-0.3, 0.3) * acceleration));
            }
        }
    }
    words.extend(["--mode", random.one_of(&["time", "line", "forced-line", "none"])].map(str::to_owned));
    if random.chance(0.2) {
        words.extend(["--least-s".to_owned(), random.between(0.1, 5.0).to_string()]);
    }
    if random.chance(0.2) {
        words.push("--whole-cycles".to_owned());
    }
    let run = desk.run(&words.iter().map(String::as_str).collect::<Vec<_>>());
    // A start that has to brake exceeds its velocity on the way to no acceleration, within what the start leads to.
    let mut limits = limits::<N>(&robot, rates);
    let overshoot = 0.5 * (0.3 * acceleration).powi(2) / jerk;
    limits.velocity = limits.velocity.map(|v| v.max((0.9 * velocity + overshoot).to_radians()));
    let said = format!("seed {seed}, job.toml:\n{job}");
    judge(desk, &run, &limits, &said);
    if run.code == 0 {
        let first = desk.trajectory::<N>("out")[0];
        for k in 0..N {
            let off = [first.q[k] - from[k].to_radians(), first.qd[k] - start_v[k].to_radians()];
            assert!(off[0].abs() < 1e-12 && off[1].abs() < 1e-12, "J{} starts off by {off:?}\n{said}", k + 1);
        }
    }
    run.code
}

fn online_case(desk: &Desk, seed: u64) -> i32 {
    let mut random = Random::new(seed);
    match random.below(3) {
        0 => online_of(desk, &mut random, ("planar_2r", PLANAR), seed),
        1 => online_of(desk, &mut random, SIX[0], seed),
        _ => online_of(desk, &mut random, ("panda", PANDA), seed),
    }
}

fn online_of<const N: usize>(desk: &Desk, random: &mut Random, (name, home): (&str, [f64; N]), seed: u64) -> i32 {
    let robot = Robot::load(name, None, None).expect("built in");
    let rates = [size(random, 20.0, 200.0), size(random, 100.0, 2000.0), size(random, 1000.0, 40_000.0)];
    let [velocity, acceleration, jerk] = rates;
    let mut text = format!(
        "[run]\nmode = \"{}\"\n[joints]\nvelocity_deg_s = {velocity}\nacceleration_deg_s2 = {acceleration}\n\
         jerk_deg_s3 = {jerk}\n[start]\nq_deg = {}\n[target]\nq_deg = {}\n",
        random.one_of(&["time", "line", "none"]),
        list(&around(random, home, 20.0)),
        list(&around(random, home, 40.0)),
    );
    if random.chance(0.3) {
        text += &format!("qd_deg_s = {}\n", list(&[0.0; N].map(|_: f64| random.between(-0.2, 0.2) * velocity)));
    }
    let mut at = 0.0;
    for _ in 0..random.below(5) {
        at += random.between(0.01, 0.6);
        text += &format!("[[change]]\nat_s = {at}\n");
        match random.below(3) {
            0 => text += &format!("q_deg = {}\n", list(&around(random, home, 40.0))),
            1 => text += &format!("joint = {}\nq_deg = {}\n", 1 + random.below(N), random.between(-20.0, 0.0)),
            // Lower than at the start, so that the first limits are the widest.
            _ => text += &format!("velocity_deg_s = {}\n", random.between(0.3, 1.0) * velocity),
        }
    }
    desk.write("s.toml", &text);
    let run = desk.run(&["online", "s.toml", "--robot", name]);
    judge(desk, &run, &limits::<N>(&robot, rates), &format!("seed {seed}, s.toml:\n{text}"));
    run.code
}

#[test]
fn random_schedules_that_are_done_keep_every_limit() {
    search("random_schedules", schedule_case);
}

#[test]
fn random_moves_that_are_done_keep_every_limit() {
    search("random_moves", move_case);
}

#[test]
fn random_online_motions_that_are_done_keep_every_limit() {
    search("random_online", online_case);
}
