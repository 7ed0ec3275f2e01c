//! How much longer motions through way-points take than an optimum on a fine grid: `way_point_gap [COUNT] [ROUNDS] [AXES]`,
//! with AXES for the rows of so many axes alone.
//!
//! The optimum is local, found from the motion itself by a sequence of convex programs (clarabel), with 16 to 40 intervals of
//! constant jerk in each section. Its velocities are bounded at the ends of the intervals only, and its jerks may change there
//! only: a gap can be a little below 0. A third each of the routes has independent points, samples of a smooth curve, and a walk
//! with small steps.
mod oracle;

use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{Route, WayPoint, WayPointPlanner};
use arcfeed_testing::Random;
use oracle::Case;

fn points<const N: usize>(rng: &mut Random, count: usize, kind: u64) -> Vec<[f64; N]> {
    let (step, size) = (rng.log(0.1, 1.5), rng.log(0.02, 0.5));
    let frequency: [f64; N] = std::array::from_fn(|_| rng.between(0.2, 1.0));
    let phase: [f64; N] = std::array::from_fn(|_| rng.between(0.0, std::f64::consts::TAU));
    let mut place = [0.0; N];
    (0..count)
        .map(|i| {
            for (k, x) in place.iter_mut().enumerate() {
                match kind {
                    0 => *x = rng.between(-1.0, 1.0),
                    1 => *x = (frequency[k] * step * i as f64 + phase[k]).sin(),
                    _ => *x += rng.between(-size, size),
                }
            }
            place
        })
        .collect()
}

/// The gap of a route (%); `None` where the optimum is not found.
fn gap<const N: usize>(planner: &mut WayPointPlanner<N>, count: usize, pieces: usize, seed: u64) -> Option<f64> {
    let mut rng = Random::new(Random::new(seed).bits());
    let limits: [AxisLimits; N] = std::array::from_fn(|_| {
        AxisLimits::symmetric(rng.log(0.5, 2.0), rng.log(2.0, 10.0), rng.log(10.0, 200.0)).expect("limits above 0")
    });
    let places = points::<N>(&mut rng, count + 2, seed % 3);
    let way: Vec<_> = places[1..=count].iter().map(|x| WayPoint::new(*x)).collect();
    let route = Route::new(&way, places[count + 1].map(AxisState::rest), limits);
    let motion = planner.plan(&places[0].map(AxisState::rest), &route).expect("every route has a motion");
    let (states, durations) = (motion.states().to_vec(), motion.section_durations().to_vec());
    let optimum = Case { states, durations, limits: &limits, pieces }.solve()?;
    Some(100.0 * (motion.duration() / optimum - 1.0))
}

fn table<const N: usize>(way_points: usize, pieces: usize, (count, rounds): (u64, usize)) {
    let default = rounds == WayPointPlanner::<N>::DEFAULT_ROUNDS;
    let mut planner =
        Box::new(if default { WayPointPlanner::<N>::new() } else { WayPointPlanner::with_rounds(rounds) });
    let mut gaps: Vec<f64> = (0..count).filter_map(|seed| gap(&mut planner, way_points, pieces, seed)).collect();
    gaps.sort_by(f64::total_cmp);
    let Some(worst) = gaps.last() else { return };
    let at = |part: f64| gaps[(part * gaps.len() as f64) as usize];
    println!(
        "{N} axes, {way_points:>2} way-points: median {:5.2} %, 90 % within {:5.2} %, worst {worst:5.2} %; {} of {count} routes",
        at(0.5),
        at(0.9),
        gaps.len()
    );
}

fn main() {
    let numbers: Vec<u64> = std::env::args().skip(1).filter_map(|x| x.parse().ok()).collect();
    let count = numbers.first().copied().unwrap_or(30);
    let rounds = numbers.get(1).map_or(WayPointPlanner::<1>::DEFAULT_ROUNDS, |&n| n as usize);
    let wanted = |axes: u64| numbers.get(2).is_none_or(|&n| n == axes);
    if wanted(1) {
        table::<1>(1, 40, (count, rounds));
        table::<1>(5, 24, (count, rounds));
    }
    if wanted(3) {
        table::<3>(3, 24, (count, rounds));
        table::<3>(10, 16, (count, rounds));
    }
    if wanted(6) {
        table::<6>(10, 16, (count, rounds));
    }
    if wanted(3) {
        table::<3>(64, 12, (count.div_ceil(3), rounds));
    }
}
