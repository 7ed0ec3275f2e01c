//! Random motions, compiled.
//!
//! Curves with and without jumps of curvature and paths through way-points, three planners with limited jerk, tolerances from 1e-7
//! to 1e-4 rad. A compiled motion has to keep the limits by its certificate, and to stay within its bound on samples that are denser
//! than those of the compiler.

use std::sync::Arc;

use arcfeed_geometry::{OrientationPath, PosePath};
use arcfeed_interp::{
    CompileError, JointRates, JointSpline, Limits, Method, PlanError, Planner, ToolLimits, ToolPath, Trajectory,
};
use arcfeed_kinematics::{Joints, ParallelAxisArm};
use arcfeed_testing::Random;
use integration_tests::random_jobs::random_curve;
use nalgebra::UnitQuaternion;

use crate::family::Outcome;

/// A random motion; `None` where the arm cannot follow or no plan is found. A plan that its own check withholds is an error.
fn motion<'a>(random: &mut Random, arm: &'a ParallelAxisArm) -> Option<Result<Trajectory<'a>, PlanError>> {
    let held = |planned| match planned {
        Ok(trajectory) => Some(Ok(trajectory)),
        Err(error @ PlanError::Unverified { .. }) => Some(Err(error)),
        Err(_) => None,
    };
    let rates = [random.log(1.0, 4.0), random.log(3.0, 30.0), random.log(30.0, 1000.0)].map(Joints::repeat);
    let limits = arm.range().with_rates(rates[0], rates[1], rates[2]).ok()?;
    let method =
        [Method::JerkLimited, Method::ContinuousAcceleration, Method::PerSegment { window: None }][random.below(3)];
    let period = random.log(1e-3, 4e-3);
    if random.below(3) == 0 {
        let points: Vec<Joints<6>> =
            (0..2 + random.below(5)).map(|_| Joints::from_fn(|_, _| random.between(-1.0, 1.0))).collect();
        let planner = Planner::new(arm, Limits::new(limits)).with_method(method).with_period(period).ok()?;
        return held(planner.plan_shared(Arc::new(JointSpline::through(&points).ok()?)));
    }
    let curve = random_curve(random)?;
    let down = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0);
    let path = ToolPath::new(arm, PosePath::new(curve, OrientationPath::Constant(down)), limits.range()).ok()?;
    let tool = ToolLimits::new().with_feed(random.log(0.05, 0.5)).ok()?;
    let tool = tool.with_tangential_acceleration(random.log(0.5, 5.0)).ok()?.with_normal_acceleration(1.0).ok()?;
    let planner =
        Planner::new(arm, Limits::new(limits).with_tool(tool)).with_method(method).with_period(period).ok()?;
    held(planner.with_chord_tolerance(random.log(1e-6, 1e-4)).ok()?.plan_shared(Arc::new(path)))
}

/// What is wrong with the compiled motion; false if the compiler says by what it cannot stay within the tolerance or a limit.
fn check(trajectory: &Trajectory<'_>, tolerance: f64, random: &mut Random) -> Result<bool, String> {
    let compiled = match trajectory.compile(tolerance) {
        Ok(compiled) => compiled,
        Err(CompileError::Deviation { .. } | CompileError::Limit { .. } | CompileError::AccelerationSteps) => {
            return Ok(false);
        }
        Err(error) => return Err(error.to_string()),
    };
    let limits = trajectory.limits().joints();
    let certificate = compiled.certify(limits.range(), &JointRates::from(limits));
    if !certificate.holds(1e-6) {
        return Err(format!("{certificate}"));
    }
    let deviation = compiled.deviation().ok_or("no deviation")?;
    let mut planned = trajectory.setpoints(trajectory.period()).map_err(|error| error.to_string())?;
    let steps = 20_000;
    for i in 0..steps {
        let t = trajectory.duration() * (f64::from(i) + random.between(0.0, 1.0)) / f64::from(steps);
        let off = (compiled.at(t).q - planned.at(t).map_err(|error| error.to_string())?.q).amax();
        if !(off <= deviation.bound && off <= tolerance) {
            return Err(format!("{off:e} at {t}, {deviation:?}"));
        }
    }
    Ok(true)
}

/// A random motion, compiled to polynomials.
pub fn play(arm: &ParallelAxisArm, seed: u64) -> Outcome {
    let mut random = Random::new(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let trajectory = match motion(&mut random, arm) {
        Some(Ok(trajectory)) => trajectory,
        Some(Err(error)) => return Outcome::Failed(error.to_string()),
        None => return Outcome::Refused,
    };
    let tolerance = random.log(1e-7, 1e-4);
    match check(&trajectory, tolerance, &mut random) {
        Ok(true) => Outcome::Done,
        Ok(false) => Outcome::Refused,
        Err(what) => {
            let (path, planner) = (trajectory.path().parameter(), trajectory.info());
            Outcome::Failed(format!(
                "{planner}, {path:?}, tolerance {tolerance:.2e}, period {}: {what}",
                trajectory.period()
            ))
        }
    }
}
