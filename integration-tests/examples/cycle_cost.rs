//! The cost of one call of a control cycle in the worst of many hostile cases.
//!
//! ```console
//! $ integration-tests/cycle_cost.sh 1000000
//! ```
//!
//! `search COUNT` draws that many cases for each row of the table, times each call (the least of three), and prints the seeds of
//! the slowest. `one ROW SEED` runs a single case, so that callgrind counts the instructions of [`measured`] alone. The script
//! does both and prints the table.

use std::hint::black_box;
use std::time::{Duration, Instant};

use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{MotionOptions, OnlineGenerator, Synchronisation, Trajectory};
use arcfeed_testing::Random;

const CYCLE: f64 = 1e-3;
/// Cases of a row that are counted.
const SLOWEST: usize = 4;

/// The call that is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Call {
    Step,
    StepScaled,
    Target,
    TargetInRange,
    Stop,
    StopInRange,
    StopOnPath,
    Jog,
    Motion,
}

const CALLS: [(Call, &str); 9] = [
    (Call::Step, "step"),
    (Call::StepScaled, "step while the scale of time changes"),
    (Call::Target, "set_target in motion"),
    (Call::TargetInRange, "set_target in motion, inside ranges"),
    (Call::Stop, "stop"),
    (Call::StopInRange, "stop, inside ranges"),
    (Call::StopOnPath, "stop_on_path and the next step"),
    (Call::Jog, "jog"),
    (Call::Motion, "a motion from state to state"),
];

/// A generator in motion, and what it is told.
#[derive(Clone)]
struct Case<const N: usize> {
    generator: OnlineGenerator<N>,
    target: [AxisState; N],
    velocity: [f64; N],
}

/// Limits over six powers of ten, different in the two directions.
fn limits(rng: &mut Random) -> AxisLimits {
    let v = rng.log(1e-2, 1e2);
    let a = v * rng.log(1e-1, 1e2);
    let j = a * rng.log(1e-1, 1e2);
    let mut pair = |x: f64| (-x * rng.log(0.3, 3.0), x);
    let (v, a, j) = (pair(v), pair(a), pair(j));
    AxisLimits::new(v, a, j).expect("limits around 0")
}

/// A state inside the limits, often at them, and a place from far too near to far away.
fn state(rng: &mut Random, limits: &AxisLimits) -> AxisState {
    let share = |rng: &mut Random| if rng.chance(0.3) { rng.sign() } else { rng.signed() };
    let v = share(rng) * limits.v_max().min(-limits.v_min()) * if rng.chance(0.3) { 0.0 } else { 0.99 };
    let a = share(rng) * limits.a_max().min(-limits.a_min()) * if rng.chance(0.5) { 0.0 } else { 0.5 };
    let way = limits.v_max() * rng.log(1e-6, 10.0);
    AxisState::new(rng.sign() * way, v, a)
}

fn draw<const N: usize>(call: Call, seed: u64) -> Option<Case<N>> {
    let mut rng = Random::new(seed.wrapping_mul(9).wrapping_add(call as u64));
    let limits: [_; N] = std::array::from_fn(|_| limits(&mut rng));
    let start: [_; N] = std::array::from_fn(|k| state(&mut rng, &limits[k]));
    let mode = if rng.chance(0.2) { Synchronisation::StraightLine } else { Synchronisation::Time };
    let mut generator = OnlineGenerator::new(start, limits, CYCLE, mode).ok()?;
    let ranged = matches!(call, Call::TargetInRange | Call::StopInRange);
    let way: Option<[f64; N]> = ranged.then(|| std::array::from_fn(|k| limits[k].v_max() * rng.log(1e-2, 10.0)));
    if let Some(way) = way {
        let ranges = std::array::from_fn(|k| (start[k].p - way[k], start[k].p + way[k]));
        generator = generator.with_ranges(ranges).ok()?;
    }
    let goal = |rng: &mut Random| std::array::from_fn(|k| state(rng, &limits[k]));
    // The first of a few targets that is possible.
    let first = goal(&mut rng);
    generator.set_target(first).ok().or_else(|| generator.set_target(start.map(|s| AxisState::rest(s.p))).ok())?;
    for _ in 0..rng.below(400) {
        generator.step();
    }
    if call == Call::StepScaled {
        generator.set_scale(rng.between(0.0, 1.5)).ok()?;
        for _ in 0..rng.below(3) {
            generator.step();
        }
    }
    let mut target: [_; N] = goal(&mut rng);
    if let Some(way) = way {
        for k in 0..N {
            target[k].p = start[k].p + 0.99 * way[k] * rng.signed();
        }
    }
    let velocity = std::array::from_fn(|k| limits[k].v_max().min(-limits[k].v_min()) * rng.signed());
    Some(Case { generator, target, velocity })
}

/// The call. Its result is not looked at: a refusal is a case, too.
#[inline(never)]
fn measured<const N: usize>(call: Call, case: &mut Case<N>) {
    let Case { generator, target, velocity } = case;
    match call {
        Call::Step | Call::StepScaled => {
            let _ = black_box(generator.step());
        }
        Call::Target | Call::TargetInRange => {
            let _ = black_box(generator.set_target(*target));
        }
        Call::Stop | Call::StopInRange => {
            let _ = black_box(generator.stop());
        }
        // The search for a way to slow down is part of the next step.
        Call::StopOnPath => {
            generator.stop_on_path();
            let _ = black_box(generator.step());
        }
        Call::Jog => {
            let _ = black_box(generator.jog(*velocity, 0.1));
        }
        Call::Motion => {
            let options = MotionOptions::new(Synchronisation::Time);
            let _ = black_box(Trajectory::new(generator.state(), target, generator.limits(), &options));
        }
    }
}

/// The least of three times.
fn time<const N: usize>(call: Call, case: &Case<N>) -> Duration {
    let once = || {
        let mut case = case.clone();
        let begin = Instant::now();
        measured(call, black_box(&mut case));
        begin.elapsed()
    };
    once().min(once()).min(once())
}

/// The seeds of the slowest cases.
fn search<const N: usize>(call: Call, count: u64) -> Vec<u64> {
    let mut times = Vec::new();
    for seed in 0..count {
        times.extend(draw::<N>(call, seed).map(|case| (time(call, &case), seed)));
    }
    times.sort_unstable_by(|a, b| b.cmp(a));
    times.iter().take(SLOWEST).map(|(_, seed)| *seed).collect()
}

fn one<const N: usize>(call: Call, seed: u64) {
    if let Some(mut case) = draw::<N>(call, seed) {
        measured(call, black_box(&mut case));
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize| arguments.get(i).and_then(|text| text.parse::<u64>().ok());
    match (arguments.first().map(String::as_str), number(1), number(2)) {
        (Some("one"), Some(row), Some(seed)) => {
            let row = row as usize;
            let Some((call, _)) = CALLS.get(row / 2) else { return };
            if row.is_multiple_of(2) { one::<1>(*call, seed) } else { one::<6>(*call, seed) }
        }
        (_, count, _) => {
            let count = count.unwrap_or(1000);
            for (i, (call, name)) in CALLS.into_iter().enumerate() {
                for (axes, seeds) in [(1, search::<1>(call, count)), (6, search::<6>(call, count))] {
                    let row = 2 * i + usize::from(axes == 6);
                    let seeds: Vec<String> = seeds.iter().map(u64::to_string).collect();
                    println!("{row};{name};{axes};{}", seeds.join(" "));
                }
            }
        }
    }
}
