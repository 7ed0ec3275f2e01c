//! Scenarios that are planned while the simulated arm moves.

use arcfeed_interp::Command;
use arcfeed_kinematics::Joints;
use arcfeed_testing::Random;
use robot_cr7::controller::{LiveSetpoints, SetpointSource};
use robot_cr7::{Cr7, Scenario, Stage};

use super::case::{Case, PERIOD};
use super::judge::Judged;

/// The number of scenarios that come with the program.
pub const SCENARIOS: usize = Scenario::ALL.len();

/// Does something with a scenario that comes with the program, made ready for the CR7.
///
/// # Panics
/// Never: the scenarios are tested with the program.
pub fn on_stage<R>(index: usize, then: impl FnOnce(&Stage<'_>) -> R) -> R {
    let (name, text) = Scenario::ALL[index % SCENARIOS];
    let scenario = Scenario::parse(text, name.as_ref()).expect("an embedded scenario");
    let cr7 = Cr7::of(scenario.job()).expect("its limits");
    then(&scenario.stage(cr7.arm(), cr7.limits()).expect("in reach"))
}

/// What an operator orders besides the events of a scenario: times in s, increasing.
#[derive(Debug, Clone, Default)]
pub struct Operator {
    orders: Vec<(f64, Command)>,
}

impl Operator {
    /// These orders: times in s, increasing.
    pub fn new(orders: Vec<(f64, Command)>) -> Self {
        Self { orders }
    }

    /// Up to six orders of a seed in the first `seconds`: overrides, and holds that end.
    pub fn random(seed: u64, seconds: f64) -> Self {
        let mut random = Random::new(seed);
        let mut orders = Vec::new();
        for _ in 0..random.below(4) {
            let at = random.between(0.0, seconds);
            if random.below(2) == 0 {
                orders.push((at, Command::Override(random.between(0.2, 1.5))));
            } else {
                orders.push((at, Command::Hold));
                orders.push((at + random.between(0.01, 1.5), Command::Resume));
            }
        }
        orders.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { orders }
    }

    /// The setpoints of a scenario with these orders.
    ///
    /// # Panics
    /// Where the scenario cannot be played without them.
    pub fn source<'s>(&self, stage: &'s Stage<'s>) -> LiveSetpoints<'s> {
        let mut orders = self.orders.clone().into_iter().peekable();
        let order = move |t: f64| orders.next_if(|(at, _)| *at <= t).map_or(Command::None, |(_, order)| order);
        LiveSetpoints::new(stage, PERIOD).expect("a scenario that ends").with_operator(order)
    }

    /// All setpoints.
    ///
    /// # Errors
    /// The doubt in one of them, in words.
    pub fn setpoints<'s>(&self, stage: &'s Stage<'s>) -> Result<Vec<Joints<6>>, String> {
        let (mut source, mut all) = (self.source(stage), Vec::new());
        loop {
            let next = source.setpoint(all.len(), PERIOD).map_err(|fault| fault.to_string())?;
            all.push(next.q);
            if next.is_last {
                return Ok(all);
            }
        }
    }
}

impl Case {
    /// Runs a session that leads the simulated arm along a scenario, and judges it.
    ///
    /// # Errors
    /// The promise that is broken, in words.
    pub fn run_live(&self, stage: &Stage<'_>, operator: &Operator) -> Result<Judged, String> {
        self.run_source(operator.source(stage), &operator.setpoints(stage)?)
    }
}
