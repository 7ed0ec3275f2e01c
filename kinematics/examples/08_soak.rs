//! Forward, then inverse, at many random and exactly singular poses of every built-in arm: the joints that made the pose
//! must be among the solutions to 1e-9 rad; for the Panda, the search must end at the pose and inside the joint range.
//!
//! `cargo run --release -p arcfeed-kinematics --example 08_soak -- 1000000 7` (count and seed; 10000 and 1 unless given).
//! Ends with an error if a pose fails. Measured at 1e6: 1.2 s per closed form, 45 s for the Panda (2-core AMD EPYC VM).
//!
//! Where the pose does not determine the joints to 1e-9, as its own rounding moves them further, the bound is that rounding:
//! 1e-15 / sigma_min^2, at most 1e-5. Where the wrist lines up and elbow or shoulder are within 1e-3 of a singular pose as
//! well, only the pose is asked for. How often the joints were beyond 1e-9 is told.

use arcfeed_kinematics::{
    ClosedForm, ClosedFormArm, ForwardKinematics, InverseKinematics, JointRange, Joints, models,
    smallest_singular_value,
};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A multiplicative sequence, the same on every machine.
struct Sequence(u64);

impl Sequence {
    /// From 0 to 1.
    fn draw(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[derive(Default)]
struct Tally {
    poses: usize,
    singular: usize,
    failed: usize,
    loose: usize,
    worst: f64,
}

fn closed_form<S: ClosedForm>(name: &str, arm: &ClosedFormArm<S>, count: usize, draw: &mut Sequence) -> Tally {
    // Limits are not the question here.
    let wide = JointRange::new(Joints::repeat(-4.0), Joints::repeat(4.0)).unwrap_or(*arm.range());
    let arm = arm.with_range(wide);
    let mut tally = Tally::default();
    for k in 0..count {
        let mut q = Joints::from_fn(|_, _| (2.0 * draw.draw() - 1.0) * PI);
        if k % 10 == 0 {
            // A joint exactly where singular poses are: wrist straight or folded, arm stretched or folded, ...
            let joint = [4, 4, 2, 1][k / 10 % 4];
            q[joint] = [0.0, PI, FRAC_PI_2, -FRAC_PI_2][k / 40 % 4];
            tally.singular += 1;
        }
        tally.poses += 1;
        let pose = arm.forward(&q);
        let sigma = smallest_singular_value(&arm.jacobian(&q));
        // The solution nearest to the joints, free joints of singular poses taken from them.
        let (apart, pose_error) = match arm.inverse(&pose, &q) {
            Err(_) => (f64::INFINITY, f64::INFINITY),
            Ok(found) => (
                (found - q).map(|d| d - TAU * (d / TAU).round()).amax(),
                (arm.forward(&found).to_homogeneous() - pose.to_homogeneous()).amax(),
            ),
        };
        let allowed = if sigma > 1e-3 { 1e-9 } else { (1e-15 / (sigma * sigma)).clamp(1e-9, 1e-5) };
        let near = arm.singularity_distances(&q);
        let twice = near.wrist < 1e-9 && (near.elbow < 1e-3 || near.shoulder < 1e-3);
        if pose_error > 2e-10 || (apart > allowed && !twice) {
            tally.failed += 1;
            println!("{name} {k}: {apart:.2e} rad, pose {pose_error:.1e}, sigma {sigma:.1e}, at {q:?}");
        }
        tally.loose += usize::from(apart > 1e-9);
        tally.worst = tally.worst.max(if sigma > 1e-3 { apart } else { 0.0 });
    }
    tally
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let count: usize = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(10_000);
    let seed: u64 = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(1);
    let mut draw = Sequence(seed);
    let mut failed = 0;
    let tallies = [
        ("cr7", closed_form("cr7", &models::cr7(), count, &mut draw)),
        ("ur5e", closed_form("ur5e", &models::ur5e(), count, &mut draw)),
        ("kr6_r700", closed_form("kr6_r700", &models::kr6_r700(), count, &mut draw)),
        ("puma560", closed_form("puma560", &models::puma560(), count, &mut draw)),
    ];
    for (name, tally) in tallies {
        println!(
            "{name}: {} poses ({} at singular joint values), {} failed; worst {:.1e} rad away from singular poses, {} beyond 1e-9 near them",
            tally.poses, tally.singular, tally.failed, tally.worst, tally.loose
        );
        failed += tally.failed;
    }

    let panda = models::panda();
    let (lower, upper) = (panda.range().lower(), panda.range().upper());
    let mut some = || Joints::<7>::from_fn(|i, _| lower[i] + draw.draw() * (upper[i] - lower[i]));
    let (mut missed, mut outside, mut restarts) = (0, 0, 0);
    for _ in 0..count {
        let (pose, seed) = (panda.forward(&some()), some());
        if let Ok(end) = panda.search(&pose, &seed) {
            let reached = (panda.forward(&end.q).to_homogeneous() - pose.to_homogeneous()).amax() < 1e-10;
            missed += usize::from(!(end.converged && reached));
            outside += usize::from(!panda.range().contains(&end.q));
            restarts += end.restarts;
        } else {
            missed += 1;
        }
    }
    println!(
        "panda: {count} poses from random seeds, {missed} missed, {outside} outside the range, {:.2} restarts each",
        restarts as f64 / count.max(1) as f64
    );
    if failed + outside > 0 || missed * 1000 > count {
        std::process::exit(1);
    }
}
