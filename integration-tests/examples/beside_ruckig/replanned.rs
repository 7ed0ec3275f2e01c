//! One axis, and a target that moves and is set in every cycle: where it will be at the end of the cycle.

use arcfeed_feedrate::{AxisLimits, AxisState, TargetTracker};
use arcfeed_sync::{OnlineGenerator, Synchronisation};
use arcfeed_testing::Random;
use ruckig::{InputParameter, OutputParameter, Ruckig};

const CYCLE: f64 = 1e-3;
/// Cycles of a run.
const CYCLES: usize = 10_000;
/// The axis is with its target within this (m),
const WITHIN: f64 = 1e-6;
/// for so many cycles at the end of a run.
const LAST: usize = 100;

struct Run {
    start: AxisState,
    target: AxisState,
    limits: [f64; 3],
}

impl Run {
    fn draw(rng: &mut Random) -> Self {
        let limits = [rng.between(0.5, 2.0), rng.between(2.0, 10.0), rng.between(20.0, 200.0)];
        let start = AxisState::new(rng.signed(), 0.5 * limits[0] * rng.signed(), 0.3 * limits[1] * rng.signed());
        // Half as fast as the axis can be.
        let target = AxisState::new(rng.signed(), 0.5 * limits[0] * rng.signed(), 0.0);
        Self { start, target, limits }
    }

    fn target(&self, cycle: usize) -> AxisState {
        AxisState::new(self.target.p + self.target.v * CYCLE * (cycle + 1) as f64, self.target.v, 0.0)
    }

    fn limits(&self) -> AxisLimits {
        let [v, a, j] = self.limits;
        AxisLimits::symmetric(v, a, j).expect("limits above 0")
    }
}

/// What became of a run.
#[derive(Default)]
struct Ending {
    /// The axis was within [`WITHIN`] of its target at the end of some cycle.
    ever: bool,
    /// It was so in all of the last cycles.
    at_the_end: bool,
}

/// Drives the axis with `drive`, which takes the target of a cycle and gives the position at its end.
fn play(run: &Run, mut drive: impl FnMut(&AxisState) -> Option<f64>) -> Ending {
    let mut ending = Ending { ever: false, at_the_end: true };
    for cycle in 0..CYCLES {
        let target = run.target(cycle);
        let Some(position) = drive(&target) else { return Ending { at_the_end: false, ..ending } };
        let within = (position - target.p).abs() < WITHIN;
        ending.ever |= within;
        ending.at_the_end &= within || cycle + LAST < CYCLES;
    }
    ending
}

fn with_ruckig(run: &Run) -> Ending {
    let mut otg = Ruckig::new_direct(1, CYCLE);
    let mut input = InputParameter::new(1);
    let mut output = OutputParameter::new_direct(1);
    let [v, a, j] = run.limits;
    (input.max_velocity[0], input.max_acceleration[0], input.max_jerk[0]) = (v, a, j);
    input.current_position[0] = run.start.p;
    input.current_velocity[0] = run.start.v;
    input.current_acceleration[0] = run.start.a;
    play(run, |target| {
        (input.target_position[0], input.target_velocity[0]) = (target.p, target.v);
        match otg.update(&mut input, &mut output) {
            ruckig::Result::Working | ruckig::Result::Finished => output.pass_to_input(&mut input),
            _ => return None,
        }
        Some(output.new_position[0])
    })
}

fn with_generator(run: &Run) -> Ending {
    let made = OnlineGenerator::new([run.start], [run.limits()], CYCLE, Synchronisation::Time);
    let Ok(mut generator) = made else { return Ending::default() };
    play(run, |target| {
        generator.set_target([*target]).ok()?;
        Some(generator.step().state.q[0])
    })
}

fn with_tracker(run: &Run) -> Ending {
    let Ok(mut tracker) = TargetTracker::new(&run.start, &run.limits(), CYCLE) else { return Ending::default() };
    play(run, |target| tracker.step(target).ok().map(|step| step.state.p))
}

/// A way to follow a target.
type Way = fn(&Run) -> Ending;

/// A line for each way to follow.
pub fn print(runs: usize) {
    let mut rng = Random::new(255);
    let all: Vec<Run> = (0..runs).map(|_| Run::draw(&mut rng)).collect();
    let ways: [(&str, Way); 3] = [
        ("ruckig, a new target in every cycle", with_ruckig),
        ("arcfeed `OnlineGenerator`, a new target in every cycle", with_generator),
        ("arcfeed `TargetTracker`", with_tracker),
    ];
    for (name, with) in ways {
        let endings: Vec<Ending> = all.iter().map(with).collect();
        let ever = endings.iter().filter(|ending| ending.ever).count();
        let at_the_end = endings.iter().filter(|ending| ending.at_the_end).count();
        println!("| {name} | {runs} | {ever} | {at_the_end} |");
    }
}
