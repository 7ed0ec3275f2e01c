//! `cr7 send --scenario`: a Dobot CR is led along a scenario that is planned while the arm moves.

use std::path::Path;

use crate::controller::{LiveSetpoints, Outcome, SendLog, SendSettings, SetpointSource, VerifiedMotion};
use crate::{
    Clock, Cr7, Cr7Error, Happening, JointReport, LimitsHold, ReportHead, Robot, RunReport, Scenario, Staging,
};
use arcfeed_interp::{JointTrajectory, PathArm};
use arcfeed_kinematics::{AnalyticInverse, JointLimits};

use crate::cli::Failure;
use crate::cli::send_args::Args;
use crate::cli::send_motion::{SendMotion, within_its_own};
use crate::cli::send_orders::Mailbox;
use crate::cli::send_steps::{connect, describe, finish, lead, look, tell, write_log, write_setpoints};

/// How long the arm is told to rest at the start before the scenario begins, s.
const REST: f64 = 0.1;

/// Runs the command for the scenario of a file.
pub fn run(
    args: &Args,
    file: &Path,
    robot: &Robot,
    settings: &SendSettings,
    mut staging: Staging,
) -> Result<(), Failure> {
    let scenario = Scenario::read(file)?;
    if let Some(path) = scenario.path_file() {
        staging.reads(path)?;
    }
    staging.clear()?;
    if robot.is_cr7() {
        let cr7 = Cr7::of(scenario.job())?;
        return Live { args, robot, settings, scenario: &scenario }.send(
            (cr7.arm(), cr7.limits()),
            Vec::new(),
            staging,
        );
    }
    let (limits, assumed) = robot.limits::<6>(&scenario.job().joints)?;
    let arm = robot.arm::<6>(scenario.job().tool).map_err(Cr7Error::from)?;
    Live { args, robot, settings, scenario: &scenario }.send((&arm, &limits), assumed, staging)
}

struct Live<'a> {
    args: &'a Args,
    robot: &'a Robot,
    settings: &'a SendSettings,
    scenario: &'a Scenario,
}

impl Live<'_> {
    fn send<A>(
        &self,
        (arm, limits): (&A, &JointLimits<6>),
        assumed: Vec<String>,
        mut staging: Staging,
    ) -> Result<(), Failure>
    where
        A: PathArm<6> + AnalyticInverse<6>,
    {
        let Self { args, robot, settings, scenario } = *self;
        within_its_own(robot, limits)?;
        let mut stage = scenario.stage(arm, limits)?;
        stage.warn(assumed);
        // The rehearsal: a scenario that would exceed a limit is not begun.
        let played = stage.play(Clock::Simulated)?;
        let rehearsal = RunReport::new(&stage, &played);
        LimitsHold::of(&rehearsal.limits)
            .map_err(|error| Failure::exceeded(&error, "lower the feed, or take another path or start"))?;
        let source = LiveSetpoints::new(&stage, settings.period)?;
        let places = source.rehearsed().to_vec();
        let name = stage.name().to_owned();
        let rest = JointTrajectory::resting(&source.start(), REST).map_err(|e| Failure::Undoable(e.to_string()))?;
        let rest = VerifiedMotion::new(rest, limits).map_err(|e| Failure::Undoable(format!("{name}: {e}")))?;
        let planned = SendMotion { name, motion: rest, warnings: rehearsal.warnings.clone() };
        let cycles = settings.period / stage.live().period();
        let slow = slow_planner(played.times().p99_s * cycles, settings);

        let mut facts = Vec::new();
        let mut fact = |name: &str, value: String| facts.push((name.to_owned(), value));
        fact("scenario", format!("{} events, planned while the arm moves", rehearsal.events.len()));
        let led = self.lead(source, (&planned, rehearsal.duration_s), &mut fact, &mut staging)?;
        describe(args, &places, settings, &mut fact);
        let (mut events, mut warnings, mut outcome) = (Vec::new(), planned.warnings, None);
        warnings.extend(slow);
        if let Some(led) = led {
            tell(&led.outcome, &mut fact);
            events = led.happenings;
            warnings.extend(led.warnings);
            outcome = Some(led.outcome);
        }
        write_setpoints(&places, settings, robot.any().joint_names(), &mut staging)?;
        let report = JointReport {
            name: planned.name,
            duration_s: rehearsal.duration_s,
            samples: places.len(),
            period_s: settings.period,
            facts,
            events,
            limits: rehearsal.limits,
            warnings,
            files: Vec::new(),
        };
        finish(args, &ReportHead::new("send", robot), (report, outcome), staging)
    }

    /// Looks at the controller and leads its arm, as far as the arguments say; the scenario takes so many seconds.
    fn lead(
        &self,
        source: LiveSetpoints<'_>,
        (planned, seconds): (&SendMotion, f64),
        fact: &mut impl FnMut(&str, String),
        staging: &mut Staging,
    ) -> Result<Option<Led>, Failure> {
        let Self { args, settings, .. } = *self;
        let Some(address) = args.address else {
            fact("dry run", "nothing is sent; --address looks at a controller, --really leads its arm".to_owned());
            return Ok(None);
        };
        // A shell suspends a program in the background that reads its terminal: that has to be before the arm is touched.
        let orders = args.really.then(Mailbox::of_stdin);
        let mut link = connect(args, address)?;
        let way = look(args, &mut link, planned, fact)?;
        let Some(orders) = orders else {
            fact("dry run", "no motion is ordered; --really leads the arm".to_owned());
            return Ok(None);
        };
        let mut log = SendLog::with_holds(way.trajectory().duration() + seconds);
        let source = source.with_way(&way).with_operator(move |_| orders.take());
        let session = lead(source, settings, &mut link, &mut log);
        let (outcome, happenings) = (session.outcome().clone(), session.source().happenings());
        let warnings = write_log(&outcome, &log, staging)?.into_iter().chain(log.bound()).collect();
        Ok(Some(Led { outcome, happenings, warnings }))
    }
}

/// What came of leading the arm.
struct Led {
    outcome: Outcome,
    happenings: Vec<Happening>,
    /// What could not be drawn, and what the log does not hold.
    warnings: Vec<String>,
}

/// A warning where planning a setpoint took `seconds` in the rehearsal, which is more than a setpoint may be late.
fn slow_planner(seconds: f64, settings: &SendSettings) -> Option<String> {
    (seconds > settings.lateness).then(|| {
        format!(
            "planning a setpoint takes {:.1} ms on this computer, and one that is {:.1} ms late ends the motion: use a computer with less load, \
             a longer --period-ms, or a longer sampling.period_ms",
            1e3 * seconds,
            1e3 * settings.lateness
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_planner_that_takes_half_a_period_is_told() {
        let settings = SendSettings::new(0.03).expect("a period");
        assert_eq!(slow_planner(0.014, &settings), None);
        let words = slow_planner(0.016, &settings).expect("a warning");
        assert!(words.contains("16.0 ms") && words.contains("15.0 ms late"), "{words}");
    }
}
