//! Cases of way-points and of targets that move.

use core::fmt::{Error, Write};

use arcfeed_feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{
    MOST_WAY_POINTS, OnlineGenerator, Route, Synchronisation, TrackingGenerator, WayPoint, WayPointPlanner,
    WayPointTrajectory,
};

use crate::stack;

/// Control cycle, s.
const CYCLE: f64 = 1e-3;

/// A generator with a place for a route.
pub type OnRoutes<const N: usize> = OnlineGenerator<N, WayPointTrajectory<N>>;

/// Six axes through way-points, and behind a target that moves. Returns true if both end where they should.
pub fn routes(out: &mut dyn Write, limits: AxisLimits) -> Result<bool, Error> {
    Ok(way_points(out, limits)? && tracking(out, limits)?)
}

/// Passes points, takes the longest routes that there can be on the way, free and with lines and blends between, holds, and stops.
fn way_points(out: &mut dyn Write, limits: AxisLimits) -> Result<bool, Error> {
    let at = |k: usize| [0, 1, 2, 3, 4, 5].map(|axis| ((k * 7 + axis * 37) % 19) as f64 / 16.0 - 0.6);
    let points: [_; MOST_WAY_POINTS] = core::array::from_fn(|k| WayPoint::new(at(k)));
    let target = [0.5; 6].map(AxisState::rest);
    let short = Route::new(&points[..5], target, [limits; 6]);
    let long = Route::new(&points, target, [limits; 6]);
    // Two lines with a blend between them, two free sections, and again; each blend counts as a point.
    let by_turns: [_; MOST_WAY_POINTS / 4 * 3] = core::array::from_fn(|k| match k % 4 {
        0 => WayPoint::new(at(k)).with_straight_section().with_blend(0.02),
        1 => WayPoint::new(at(k)).with_straight_section(),
        _ => WayPoint::new(at(k)),
    });
    let mixed = Route::new(&by_turns, target, [limits; 6]);
    let made = OnlineGenerator::new([AxisState::rest(0.0); 6], [limits; 6], CYCLE, Synchronisation::Time);
    let Ok(mut generator) = made.map(OnlineGenerator::with_way_points) else { return Ok(false) };
    let mut planner = WayPointPlanner::new();
    let (mut step, mut good) = (0, true);
    let mut go = |generator: &mut OnRoutes<6>, cycles: usize| {
        let (mut reached, mut passed) = (false, 0);
        for _ in 0..cycles {
            step = step.max(stack::used(|| {
                let after = generator.step();
                passed += after.events.passed;
                reached |= after.events.reached;
                good &= after.state.qd.iter().all(|v| v.abs() <= 1.0 + 1e-9);
            }));
        }
        (passed, reached)
    };
    let mut set = generator.jog([0.2; 6], 1.0).is_ok();
    go(&mut generator, 200);
    let mut set_route = stack::used_deep(|| set &= generator.set_route(&short, &mut planner).is_ok());
    let on_the_way = go(&mut generator, 3000);
    set_route = set_route.max(stack::used_deep(|| set &= generator.set_route(&long, &mut planner).is_ok()));
    let under_way = go(&mut generator, 4000);
    set_route = set_route.max(stack::used_deep(|| set &= generator.set_route(&mixed, &mut planner).is_ok()));
    let on_lines = go(&mut generator, 4000);
    generator.hold();
    let held = go(&mut generator, 2000);
    generator.resume();
    let resumed = go(&mut generator, 4000);
    let stop = stack::used(|| set &= generator.stop().is_ok());
    let at_rest = go(&mut generator, 1000);
    writeln!(out, "stack of set_route, 6 axes      {set_route:6} bytes")?;
    writeln!(out, "stack of step on it, 6 axes     {step:6} bytes")?;
    writeln!(out, "stack of stop on it, 6 axes     {stop:6} bytes")?;
    let passes = [on_the_way, under_way, on_lines, resumed].iter().all(|(passed, _)| *passed > 0);
    let ends = passes && ![under_way, on_lines, held, resumed].iter().any(|(_, reached)| *reached) && at_rest.1;
    Ok(good && set && ends && generator.state().iter().all(|s| s.v.abs() < 1e-12))
}

/// Six axes behind one target.
fn tracking(out: &mut dyn Write, limits: AxisLimits) -> Result<bool, Error> {
    let made = TrackingGenerator::new(&[AxisState::rest(0.0); 6], &[limits; 6], CYCLE);
    let Ok(mut tracking) = made else { return Ok(false) };
    let (mut used, mut following) = (0, false);
    for cycle in 0..2000_u32 {
        let conveyor = AxisState::new(0.2 + 0.3 * CYCLE * f64::from(cycle + 1), 0.3, 0.0);
        used = used.max(stack::used(|| following = tracking.step(&[conveyor; 6]).is_ok_and(|s| s.is_following())));
    }
    writeln!(out, "stack of tracking, 6 axes       {used:6} bytes")?;
    Ok(following)
}
