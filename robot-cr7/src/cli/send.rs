//! `cr7 send`: a Dobot CR is led along a verified motion.

use std::net::IpAddr;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::controller::{
    DobotLink, Fault, JointStream, Order, Outcome, Ports, SendLog, SendSettings, Session, TcpWire, VerifiedMotion,
    drive, lead_in, survey,
};
use crate::plot::sent_picture;
use crate::{JointReport, LimitsHold, ReportHead, Robot, Staging, trajectory_columns};
use arcfeed_kinematics::{JointKind, Joints};

use crate::cli::output::{REPORTS, show};
use crate::cli::progress::Progress;
use crate::cli::send_args::Args;
use crate::cli::send_motion::{self, SendMotion};
use crate::cli::tool_path::read_job;
use crate::cli::{Failure, INTERRUPTED};

/// Numbers of the models that are a CR7: CR7, CR7A, CR7V.
const CR7_MODELS: &[u8] = &[7, 117, 207];
/// The files of the command.
const FILES: [&str; 5] = [SETPOINTS, SENT, PICTURE, REPORTS[0], REPORTS[1]];
const SETPOINTS: &str = "setpoints.csv";
const SENT: &str = "sent.csv";
const PICTURE: &str = "sent.svg";

/// True while an arm is led.
static LEADING: AtomicBool = AtomicBool::new(false);
/// True once the operator wants it to end.
static ASKED: AtomicBool = AtomicBool::new(false);

/// Called on Ctrl-C: true if an arm is led, which is then stopped.
pub fn stop_is_asked() -> bool {
    let leading = LEADING.load(Ordering::SeqCst);
    if leading {
        ASKED.store(true, Ordering::SeqCst);
    }
    leading
}

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
    let inputs: Vec<&Path> = [&args.motion, &args.job].into_iter().filter_map(|file| file.as_deref()).collect();
    let mut staging = Staging::new(&args.out, &FILES, &inputs)?;
    staging.reads(args.robot.robot.as_ref())?;
    let robot = args.robot.load()?;
    let settings = args.settings(models(args, &robot)?)?;
    let progress = Progress::new("planning and certifying");
    let planned = send_motion::load(args, &robot)?;
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
                outcome = Some(lead(&motion, &settings, &mut link, &mut staging)?);
            } else {
                fact("dry run", "no motion is ordered; --really leads the arm".to_owned());
            }
        }
    }
    let count = describe(args, &motion, &settings, &mut fact);
    if let Some(outcome) = &outcome {
        tell(outcome, &mut fact);
    }
    let head = ReportHead::new("send", &robot);
    write_setpoints(&motion, &settings, (count, robot.any().joint_names()), &mut staging)?;
    let report = JointReport {
        name: planned.name,
        duration_s: motion.trajectory().duration(),
        samples: count,
        period_s: settings.period,
        facts,
        events: Vec::new(),
        limits: motion.limit_lines(),
        warnings: planned.warnings,
        files: Vec::new(),
    };
    finish(args, &head, (report, outcome), staging)
}

/// The connections to the controller.
fn connect(args: &Args, address: IpAddr) -> Result<DobotLink<TcpWire>, Failure> {
    let [dashboard, motion, feedback] = [0, 1, 2].map(|i| args.ports.get(i).copied().unwrap_or_default());
    let wire = TcpWire::connect(address, Ports { dashboard, motion, feedback }, args.dialect());
    Ok(DobotLink::new(wire.map_err(|e| Failure::Undoable(format!("{address}: {e}")))?, args.dialect()))
}

/// Looks at the controller, and puts the way to the start before the motion.
fn look(
    args: &Args,
    link: &mut DobotLink<TcpWire>,
    planned: &SendMotion,
    fact: &mut impl FnMut(&str, String),
) -> Result<VerifiedMotion, Failure> {
    let seen = survey(link).map_err(|e| Failure::Undoable(e.to_string()))?;
    let (state, start) = (seen.state, planned.motion.start());
    fact(
        "controller",
        format!("{}, arm {}, model {}, {} errors", args.dialect(), state.mode, state.model, seen.errors),
    );
    let off: Joints<6> = (state.q - start).abs();
    let joint = off.imax();
    let degrees = off[joint].to_degrees();
    fact("at the start", format!("to {degrees:.3} deg (joint {})", joint + 1));
    if degrees > args.start_tolerance_deg && !args.approach {
        let words = format!(
            "joint {} is at {:.3} deg, and the motion starts at {:.3} deg: bring it there, or let this program do so with --approach",
            joint + 1,
            state.q[joint].to_degrees(),
            start[joint].to_degrees()
        );
        return Err(Failure::Undoable(words));
    }
    let whole = lead_in(&planned.motion, &state.q).map_err(|e| Failure::Undoable(e.to_string()))?;
    let way = whole.trajectory().duration() - planned.motion.trajectory().duration();
    fact("way there", format!("{way:.3} s, with a fifth of the limits"));
    Ok(whole)
}

/// Leads the arm, and writes what came back.
fn lead(
    motion: &VerifiedMotion,
    settings: &SendSettings,
    link: &mut DobotLink<TcpWire>,
    staging: &mut Staging,
) -> Result<Outcome, Failure> {
    let mut log = SendLog::new(motion.trajectory().duration());
    LEADING.store(true, Ordering::SeqCst);
    let mut session = Session::new(motion, settings, link.now());
    drive(&mut session, link, &mut log, || ASKED.load(Ordering::SeqCst));
    LEADING.store(false, Ordering::SeqCst);
    let outcome = session.outcome().clone();
    // Said before any file is written, which may fail.
    eprintln!("cr7: {outcome}");
    let file = staging.create(SENT)?;
    log.write_csv(file).map_err(|source| staging.failed(SENT, source))?;
    let facts = format!("{} setpoints; {}", outcome.sent, outcome.deadlines);
    let svg = sent_picture("sent and actual joints", &facts, log.rows()).map_err(|e| staging.failed(PICTURE, e))?;
    staging.write(PICTURE, &svg)?;
    Ok(outcome)
}

/// Says what is sent, and returns the number of setpoints.
fn describe(
    args: &Args,
    motion: &VerifiedMotion,
    settings: &SendSettings,
    fact: &mut impl FnMut(&str, String),
) -> usize {
    let count = Session::new(motion, settings, 0.0).outcome().setpoints;
    fact("setpoints", format!("{count}, one every {} ms, {}", args.period_ms, args.dialect()));
    let end = motion.trajectory().at(motion.trajectory().duration()).q;
    for (name, q) in [("first", motion.start()), ("last", end)] {
        let mut text = String::new();
        args.dialect().write(&Order::Setpoint { q, period: settings.period }, &mut text);
        fact(name, text);
    }
    count
}

/// Says what became of it.
fn tell(outcome: &Outcome, fact: &mut impl FnMut(&str, String)) {
    fact("sent", format!("{} of {} setpoints", outcome.sent, outcome.setpoints));
    fact("deadlines", outcome.deadlines.to_string());
    let (joint, off) = outcome.off;
    fact("behind", format!("{:.3} deg at most (joint {})", off.to_degrees(), joint + 1));
    fact("end", outcome.fault.as_ref().map_or("the motion is done".to_owned(), Fault::to_string));
    fact("arm", outcome.arm());
}

fn write_setpoints(
    motion: &VerifiedMotion,
    settings: &SendSettings,
    (count, names): (usize, &[String]),
    staging: &mut Staging,
) -> Result<(), Failure> {
    // The first columns of a trajectory: time and positions.
    let columns = &trajectory_columns(names)[..=names.len()];
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(staging.create(SETPOINTS)?);
    let mut write = || {
        writer.write_record(columns)?;
        for i in 0..count {
            let t = i as f64 * settings.period;
            writer.serialize((t, motion.trajectory().at(t).q.as_slice()))?;
        }
        writer.flush().map_err(csv::Error::from)
    };
    write().map_err(|error| Failure::from(staging.failed(SETPOINTS, error.into())))
}

/// Publishes the files, and ends with the doubt where there was one.
fn finish(
    args: &Args,
    head: &ReportHead,
    (mut report, outcome): (JointReport, Option<Outcome>),
    mut staging: Staging,
) -> Result<(), Failure> {
    let hold = LimitsHold::of(&report.limits).map_err(|e| Failure::Undoable(e.to_string()))?;
    report.files = staging.files_with(&REPORTS);
    staging.write(REPORTS[0], &(head.json(&report) + "\n"))?;
    staging.write(REPORTS[1], &report.to_string())?;
    staging.publish(&hold)?;
    show(&report, args.json.then(|| head.json(&report)));
    match outcome.and_then(|outcome| outcome.fault) {
        None => Ok(()),
        Some(Fault::Interrupted) => Err(Failure::Told(INTERRUPTED as u8)),
        Some(_) => Err(Failure::Told(1)),
    }
}
