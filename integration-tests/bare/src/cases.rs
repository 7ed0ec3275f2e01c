//! The cases: what a controller does, and whether it ends where it should.

use core::fmt::{Result, Write};
use core::mem::size_of;

use arcfeed_feedrate::{AxisLimits, AxisState, StateToState, TargetTracker};
use arcfeed_kinematics::{ForwardKinematics, InverseKinematics, Joints, models};
use arcfeed_sync::nalgebra::{Isometry3, Vector3};
use arcfeed_sync::{
    MotionOptions, OnlineGenerator, PoseLimits, PoseProjectionSync, PoseState, ProjectionStatus, Synchronisation,
    TrackingGenerator, Trajectory, WayPointPlanner,
};

use crate::routes::{OnRoutes, routes};
use crate::stack;

const CYCLE: f64 = 1e-3;

/// Runs everything and prints a table. Returns true if every motion ended where it should.
pub fn run(out: &mut dyn Write) -> core::result::Result<bool, core::fmt::Error> {
    sizes(out)?;
    let limits = AxisLimits::symmetric(1.0, 5.0, 50.0);
    let Ok(limits) = limits else { return Ok(false) };
    Ok(online(out, limits)? && axes(out, limits)? && routes(out, limits)? && tool(out)? && arm(out)?)
}

fn sizes(out: &mut dyn Write) -> Result {
    writeln!(out, "size of StateToState            {:6} bytes", size_of::<StateToState>())?;
    writeln!(out, "size of Trajectory<6>           {:6} bytes", size_of::<Trajectory<6>>())?;
    writeln!(out, "size of OnlineGenerator<1>      {:6} bytes", size_of::<OnlineGenerator<1>>())?;
    writeln!(out, "size of OnlineGenerator<6>      {:6} bytes", size_of::<OnlineGenerator<6>>())?;
    writeln!(out, "the same with a route           {:6} bytes", size_of::<OnRoutes<6>>())?;
    writeln!(out, "size of WayPointPlanner<6>      {:6} bytes", size_of::<WayPointPlanner<6>>())?;
    writeln!(out, "size of TrackingGenerator<6>    {:6} bytes", size_of::<TrackingGenerator<6>>())?;
    writeln!(out, "size of PoseProjectionSync      {:6} bytes", size_of::<PoseProjectionSync>())?;
    writeln!(out, "size of TargetTracker           {:6} bytes", size_of::<TargetTracker>())?;
    writeln!(out, "size of ParallelAxisArm         {:6} bytes", size_of::<arcfeed_kinematics::ParallelAxisArm>())
}

/// Retargets, jogs, holds and stops six axes.
fn online(out: &mut dyn Write, limits: AxisLimits) -> core::result::Result<bool, core::fmt::Error> {
    let made = OnlineGenerator::new([AxisState::rest(0.0); 6], [limits; 6], CYCLE, Synchronisation::Time);
    let Ok(mut generator) = made.and_then(|made| made.with_ranges([(-2.0, 2.0); 6])) else { return Ok(false) };
    let mut good = true;
    let (mut target, mut step, mut jog, mut stop, mut on_path) = (0, 0, 0, 0, 0);
    for cycle in 0..12_000_u32 {
        let at = |k: u32| AxisState::rest(f64::from((cycle / 7 + 37 * k) % 191) / 64.0 - 1.4);
        match cycle % 2000 {
            0 | 300 | 640 => {
                let goal = [at(0), at(1), at(2), at(3), at(4), at(5)];
                target = target.max(stack::used(|| good &= generator.set_target(goal).is_ok()));
            }
            900 => on_path = on_path.max(stack::used(|| generator.stop_on_path())),
            1300 => generator.hold(),
            1500 => generator.resume(),
            1600..1700 => {
                jog = jog.max(stack::used(|| good &= generator.jog([0.2, -0.1, 0.0, 0.3, 0.1, 0.2], 0.02).is_ok()))
            }
            1750 => stop = stop.max(stack::used(|| good &= generator.stop().is_ok())),
            _ => {}
        }
        step = step.max(stack::used(|| {
            let state = generator.step().state;
            good &= state.q.iter().all(|q| q.abs() <= 2.0) && state.qd.iter().all(|v| v.abs() <= 1.0 + 1e-9);
        }));
    }
    writeln!(out, "stack of set_target, 6 axes     {target:6} bytes")?;
    writeln!(out, "stack of step, 6 axes           {step:6} bytes")?;
    writeln!(out, "stack of jog, 6 axes            {jog:6} bytes")?;
    writeln!(out, "stack of stop, 6 axes           {stop:6} bytes")?;
    writeln!(out, "stack of stop_on_path, 6 axes   {on_path:6} bytes")?;
    Ok(good && generator.state().iter().all(|s| s.v == 0.0))
}

/// From state to state, and one axis behind a conveyor.
fn axes(out: &mut dyn Write, limits: AxisLimits) -> core::result::Result<bool, core::fmt::Error> {
    let start = [AxisState::new(0.0, 0.5, 0.0); 6];
    let target = [1.0, 0.8, -1.5, 0.1, 2.0, -0.7].map(AxisState::rest);
    let mut good = false;
    let used = stack::used(|| {
        let options = MotionOptions::new(Synchronisation::Time);
        if let Ok(motion) = Trajectory::new(&start, &target, &[limits; 6], &options) {
            good = motion.at(motion.duration()).q.iter().zip(&target).all(|(q, t)| *q == t.p);
        }
    });
    writeln!(out, "stack of a motion, 6 axes       {used:6} bytes")?;
    let Ok(mut tracker) = TargetTracker::new(&AxisState::rest(0.0), &limits, CYCLE) else { return Ok(false) };
    let (mut used, mut distance) = (0, f64::MAX);
    for cycle in 0..3000_u32 {
        let conveyor = AxisState::new(0.2 + 0.3 * CYCLE * f64::from(cycle + 1), 0.3, 0.0);
        used = used.max(stack::used(|| match tracker.step(&conveyor) {
            Ok(step) => distance = (step.state.p - conveyor.p).abs(),
            Err(_) => good = false,
        }));
    }
    writeln!(out, "stack of tracking, 1 axis       {used:6} bytes")?;
    Ok(good && distance < 1e-9)
}

/// A tool to a pose.
fn tool(out: &mut dyn Write) -> core::result::Result<bool, core::fmt::Error> {
    let start = PoseState::rest(Isometry3::new(Vector3::new(0.4, 0.0, 0.3), Vector3::zeros()));
    let target = Isometry3::new(Vector3::new(0.4, 0.3, 0.2), Vector3::new(0.0, 0.0, 1.0));
    let Ok(limits) = PoseLimits::new([0.5, 3.0, 40.0], [1.5, 8.0, 100.0]) else { return Ok(false) };
    let Ok(mut sync) = PoseProjectionSync::new(&start, target, &limits) else { return Ok(false) };
    let mut good = true;
    let mut used = 0;
    for cycle in 0..4000 {
        if cycle == 300 {
            used = used.max(stack::used(|| good &= sync.set_target(start.pose).is_ok()));
        }
        let mut reached = false;
        used = used.max(stack::used(|| match sync.step(CYCLE) {
            Ok(step) => reached = matches!(step.status, ProjectionStatus::Reached { .. }),
            Err(_) => good = false,
        }));
        if reached {
            break;
        }
    }
    writeln!(out, "stack of the projection         {used:6} bytes")?;
    Ok(good && sync.state().pose == start.pose)
}

/// Forward and back.
fn arm(out: &mut dyn Write) -> core::result::Result<bool, core::fmt::Error> {
    let arm = models::cr7();
    let q = Joints::<6>::from([0.3, -0.2, 1.4, 0.3, -1.5, 0.0]);
    let mut good = false;
    let used = stack::used(|| {
        let pose = arm.forward(&q);
        good = arm.inverse(&pose, &q).is_ok_and(|found| (found - q).amax() < 1e-12);
    });
    writeln!(out, "stack of forward and inverse    {used:6} bytes")?;
    Ok(good)
}
