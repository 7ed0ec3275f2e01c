//! `cr7 send`: a Dobot CR is led along a verified motion.

use std::path::Path;

use crate::controller::{SendLog, SetpointSource, VerifiedMotion};
use crate::{JointReport, ReportHead, Robot, Staging};
use arcfeed_kinematics::{JointKind, Joints};

use crate::cli::Failure;
use crate::cli::output::REPORTS;
use crate::cli::progress::Progress;
use crate::cli::send_args::Args;
use crate::cli::send_live;
use crate::cli::send_motion;
use crate::cli::send_steps::{
    PICTURE, SENT, SETPOINTS, connect, describe, finish, lead, look, tell, write_log, write_setpoints,
};
use crate::cli::tool_path::read_job;

/// Numbers of the models that are a CR7: CR7, CR7A, CR7V.
const CR7_MODELS: &[u8] = &[7, 117, 207];
/// The files of the command.
const FILES: [&str; 5] = [SETPOINTS, SENT, PICTURE, REPORTS[0], REPORTS[1]];

/// The numbers of the models of arm that a motion of this robot may be sent to; none for any, which is only looked at.
fn models(args: &Args, robot: &Robot) -> Result<&'static [u8], Failure> {
    let (name, joints) = (&robot.description().name, &robot.description().joints);
    if joints.len() != 6 {
        let words = format!("the arms of Dobot's CR series have six joints, and {name} has {}", joints.len());
        return Err(Failure::BadInput(words));
    }
    if let Some(joint) = joints.iter().find(|joint| joint.kind != JointKind::Revolute) {
        let words = format!("the arms of Dobot's CR series have joints that turn, and {} of {name} slides", joint.name);
        return Err(Failure::BadInput(words));
    }
    match args.model {
        None if robot.is_cr7() => Ok(CR7_MODELS),
        Some(model) if robot.is_cr7() && !CR7_MODELS.contains(&model) => Err(Failure::BadInput(format!(
            "--model {model}: the CR7 has the numbers {CR7_MODELS:?}; choose its --robot"
        ))),
        // It lives as long as the program.
        Some(model) => Ok(vec![model].leak()),
        None if args.really => {
            let words = format!(
                "which arm {name} is has to be known: give the number of its model with --model, which a look without --really shows"
            );
            Err(Failure::BadInput(words))
        }
        None => Ok(&[]),
    }
}

/// Runs the command. `stoppable` is true if Ctrl-C stops an arm.
pub fn run(args: &Args, stoppable: bool) -> Result<(), Failure> {
    if args.really && !stoppable {
        return Err(Failure::Undoable("--really: Ctrl-C would not stop the arm, so that it is not led".to_owned()));
    }
    let inputs: Vec<&Path> =
        [&args.motion, &args.job, &args.scenario].into_iter().filter_map(|file| file.as_deref()).collect();
    let painter = args.pictures.painter()?;
    let mut staging = Staging::new(&args.out, &FILES, &inputs)?;
    staging.reads(args.robot.robot.as_ref())?;
    painter.draw(&mut staging);
    let robot = args.robot.load()?;
    let settings = args.settings(models(args, &robot)?)?;
    if let Some(scenario) = &args.scenario {
        return send_live::run(args, scenario, &robot, &settings, staging);
    }
    let progress = Progress::new("planning and certifying");
    let mut planned = send_motion::load(args, &robot)?;
    drop(progress);
    if let Some(path) = &read_job(args.job.as_deref())?.path_file {
        staging.reads(path)?;
    }
    staging.clear()?;

    let mut facts = Vec::new();
    let mut fact = |name: &str, value: String| facts.push((name.to_owned(), value));
    let mut motion = planned.motion.clone();
    let mut outcome = None;
    match args.address {
        None => fact("dry run", "nothing is sent; --address looks at a controller, --really leads its arm".to_owned()),
        Some(address) => {
            let mut link = connect(args, address)?;
            motion = look(args, &mut link, &planned, &mut fact)?;
            if args.really {
                let mut log = SendLog::new(motion.trajectory().duration());
                let led = lead(&motion, &settings, &mut link, &mut log).outcome().clone();
                planned.warnings.extend(write_log(&led, &log, &mut staging)?);
                planned.warnings.extend(log.bound());
                outcome = Some(led);
            } else {
                fact("dry run", "no motion is ordered; --really leads the arm".to_owned());
            }
        }
    }
    let setpoints = setpoints_of(&motion, settings.period);
    describe(args, &setpoints, &settings, &mut fact);
    if let Some(outcome) = &outcome {
        tell(outcome, &mut fact);
    }
    let head = ReportHead::new("send", &robot);
    write_setpoints(&setpoints, &settings, robot.any().joint_names(), &mut staging)?;
    let report = JointReport {
        name: planned.name,
        duration_s: motion.trajectory().duration(),
        samples: setpoints.len(),
        period_s: settings.period,
        facts,
        events: Vec::new(),
        limits: motion.limit_lines(),
        warnings: planned.warnings,
        files: Vec::new(),
    };
    finish(args, &head, (report, outcome), staging)
}

/// The setpoints of a motion, one every `period` (s).
fn setpoints_of(motion: &VerifiedMotion, period: f64) -> Vec<Joints<6>> {
    (0..motion.count(period)).map(|i| motion.trajectory().at(i as f64 * period).q).collect()
}
