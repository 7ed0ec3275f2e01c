//! The conditions of the paper's experiments, and how a scenario is played.

use arcfeed_sync::nalgebra::SVector;

use crate::input::scenario::Scenario;
use crate::run::cr7::Cr7;
use crate::run::error::Cr7Error;
use crate::run::play::{Clock, Played};
use crate::run::stage::Stage;

pub(super) type V6 = SVector<f64, 6>;

/// The paper's controller samples every 2 ms.
pub(super) const PERIOD: f64 = 2e-3;
/// Cap on the cycles of every loop: 40 s.
pub(super) const CYCLES: u32 = 20_000;

/// Position, velocity, acceleration at the start and at the end (mm, s), from the text before Table
/// 3.
pub(super) const START: [f64; 3] = [0.0, -1.0, -10.0];
pub(super) const END: [f64; 3] = [200.0, 5.0, 6.0];

/// Limits from a time on (s): velocity, acceleration, jerk in mm and s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    pub(super) from: f64,
    pub(super) v: (f64, f64),
    pub(super) a: (f64, f64),
    pub(super) j: (f64, f64),
}

/// Table 3.
pub(super) const TABLE_3: [Window; 3] = [
    Window { from: 0.0, v: (-6.0, 5.0), a: (-12.0, 10.0), j: (-25.0, 20.0) },
    Window { from: 3.0, v: (-13.0, 15.0), a: (-15.0, 12.0), j: (-100.0, 90.0) },
    Window { from: 6.0, v: (-50.0, 30.0), a: (-20.0, 30.0), j: (-80.0, 70.0) },
];

/// Plays a scenario on the CR7 and hands over what was played.
pub(super) fn played<T>(text: &str, name: &str, look: impl FnOnce(&Stage<'_>, &Played) -> T) -> Result<T, Cr7Error> {
    let scenario = Scenario::parse(text, name.as_ref())?;
    let cr7 = Cr7::of(scenario.job())?;
    let stage = scenario.stage(cr7.arm(), cr7.limits())?;
    let played = stage.play(Clock::Simulated)?;
    Ok(look(&stage, &played))
}
