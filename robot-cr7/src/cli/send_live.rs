//! `cr7 send --scenario`: a Dobot CR is led along a scenario that is planned while the arm moves.

use std::io::BufRead;
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};

use crate::controller::{LiveSetpoints, SendLog, SendSettings, SetpointSource, VerifiedMotion};
use crate::{Clock, Cr7, Cr7Error, JointReport, LimitsHold, ReportHead, Robot, RunReport, Scenario, Staging};
use arcfeed_interp::{Command, JointTrajectory, PathArm};
use arcfeed_kinematics::{AnalyticInverse, JointLimits};

use crate::cli::Failure;
use crate::cli::send_args::Args;
use crate::cli::send_motion::{SendMotion, within_its_own};
use crate::cli::send_steps::{connect, describe, finish, lead, look, tell, write_log, write_setpoints};

/// How long the arm is told to rest at the start before the scenario begins, s.
const REST: f64 = 0.1;
/// The highest override that is taken, percent.
const MOST_OVERRIDE: f64 = 150.0;

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
        let (name, count) = (stage.name().to_owned(), source.count(settings.period));
        let rest = JointTrajectory::resting(&source.start(), REST).map_err(|e| Failure::Undoable(e.to_string()))?;
        let rest = VerifiedMotion::new(rest, limits).map_err(|e| Failure::Undoable(format!("{name}: {e}")))?;
        let planned = SendMotion { name, motion: rest, warnings: rehearsal.warnings.clone() };

        let mut facts = Vec::new();
        let mut fact = |name: &str, value: String| facts.push((name.to_owned(), value));
        fact("scenario", format!("{} events, planned while the arm moves", rehearsal.events.len()));
        let mut outcome = None;
        match args.address {
            None => {
                fact("dry run", "nothing is sent; --address looks at a controller, --really leads its arm".to_owned())
            }
            Some(address) => {
                let mut link = connect(args, address)?;
                let way = look(args, &mut link, &planned, &mut fact)?;
                if args.really {
                    let mut log = SendLog::new(way.trajectory().duration() + rehearsal.duration_s);
                    let orders = orders();
                    let told = move |_| orders.try_recv().unwrap_or(Command::None);
                    let source = source.with_way(&way, settings.period).with_operator(told);
                    let led = lead(source, settings, &mut link, &mut log);
                    write_log(&led, &log, &mut staging)?;
                    outcome = Some(led);
                } else {
                    fact("dry run", "no motion is ordered; --really leads the arm".to_owned());
                }
            }
        }
        let mut again = LiveSetpoints::new(&stage, settings.period)?;
        let places: Result<Vec<_>, _> = (0..count).map(|i| again.setpoint(i, settings.period)).collect();
        let places = places.map_err(|fault| Failure::Undoable(fault.to_string()))?;
        let places: Vec<_> = places.into_iter().map(|next| next.q).collect();
        describe(args, &places, settings, &mut fact);
        if let Some(outcome) = &outcome {
            tell(outcome, &mut fact);
        }
        write_setpoints(&places, settings, robot.any().joint_names(), &mut staging)?;
        let report = JointReport {
            name: planned.name,
            duration_s: rehearsal.duration_s,
            samples: count,
            period_s: settings.period,
            facts,
            events: Vec::new(),
            limits: rehearsal.limits,
            warnings: planned.warnings,
            files: Vec::new(),
        };
        finish(args, &ReportHead::new("send", robot), (report, outcome), staging)
    }
}

/// Orders on stdin, one a line.
fn orders() -> Receiver<Command> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            match order(&line) {
                Some(order) => {
                    if sender.send(order).is_err() {
                        return;
                    }
                }
                None => eprintln!(
                    "cr7: {line:?} is no order: hold, resume, stop, or override with 0 to {MOST_OVERRIDE} percent"
                ),
            }
        }
    });
    receiver
}

/// What a line orders.
fn order(line: &str) -> Option<Command> {
    let words: Vec<&str> = line.split_whitespace().collect();
    Some(match words[..] {
        ["hold"] => Command::Hold,
        ["resume"] => Command::Resume,
        ["stop"] => Command::Stop,
        ["override", percent] => {
            let percent: f64 = percent.trim_end_matches('%').parse().ok()?;
            Command::Override((0.0..=MOST_OVERRIDE).contains(&percent).then_some(percent / 100.0)?)
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_words_and_a_percentage() {
        assert_eq!(order(" hold "), Some(Command::Hold));
        assert_eq!(order("resume"), Some(Command::Resume));
        assert_eq!(order("stop"), Some(Command::Stop));
        assert_eq!(order("override 50"), Some(Command::Override(0.5)));
        assert_eq!(order("override 0%"), Some(Command::Override(0.0)));
        for wrong in ["", "override", "override -1", "override 151", "override nan", "hold on", "leave"] {
            assert_eq!(order(wrong), None, "{wrong}");
        }
    }
}
