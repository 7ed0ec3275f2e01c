//! The steps of `cr7 send`, for certified motions and for scenarios: look at the controller, lead the arm, tell what came of it.

use std::io::Write;
use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::controller::{
    DobotLink, Fault, JointStream, Order, Outcome, Ports, SendLog, SendSettings, Session, SetpointSource, TcpWire,
    VerifiedMotion, drive, lead_in, survey,
};
use crate::plot::sent_picture;
use crate::{JointReport, LimitsHold, ReportHead, Staging, trajectory_columns};
use arcfeed_kinematics::Joints;

use crate::cli::output::{REPORTS, show};
use crate::cli::send_args::Args;
use crate::cli::send_motion::SendMotion;
use crate::cli::{Failure, INTERRUPTED};

/// The files besides the reports.
pub const SETPOINTS: &str = "setpoints.csv";
pub const SENT: &str = "sent.csv";
pub const PICTURE: &str = "sent.svg";

/// The exit code where an order has stopped the motion on the way.
const STOPPED_BY_ORDER: u8 = 3;

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

/// The connections to the controller.
pub fn connect(args: &Args, address: IpAddr) -> Result<DobotLink<TcpWire>, Failure> {
    let [dashboard, motion, feedback] = [0, 1, 2].map(|i| args.ports.get(i).copied().unwrap_or_default());
    let wire = TcpWire::connect(address, Ports { dashboard, motion, feedback }, args.dialect());
    Ok(DobotLink::new(wire.map_err(|e| Failure::Undoable(format!("{address}: {e}")))?, args.dialect()))
}

/// Looks at the controller, and puts the way to the start before the motion.
pub fn look(
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

/// Leads the arm, and says how it ended.
pub fn lead<M: SetpointSource>(
    source: M,
    settings: &SendSettings,
    link: &mut DobotLink<TcpWire>,
    log: &mut SendLog,
) -> Session<M> {
    LEADING.store(true, Ordering::SeqCst);
    let mut session = Session::new(source, settings, link.now());
    drive(&mut session, link, log, || ASKED.load(Ordering::SeqCst));
    LEADING.store(false, Ordering::SeqCst);
    // Said before any file is written, which may fail, as may stderr.
    let _ = writeln!(std::io::stderr(), "cr7: {}", session.outcome());
    session
}

/// Writes what came back. Returns why it could not be drawn, if so: what was moved stays on record.
pub fn write_log(outcome: &Outcome, log: &SendLog, staging: &mut Staging) -> Result<Option<String>, Failure> {
    let file = staging.create(SENT)?;
    log.write_csv(file).map_err(|source| staging.failed(SENT, source))?;
    let facts = format!("{} setpoints; {}", outcome.sent, outcome.deadlines);
    let drawn = staging.write_picture(PICTURE, sent_picture("sent and actual joints", &facts, log.rows()));
    Ok(drawn.err().map(|error| error.to_string()))
}

/// Says what is sent.
pub fn describe(args: &Args, setpoints: &[Joints<6>], settings: &SendSettings, fact: &mut impl FnMut(&str, String)) {
    fact("setpoints", format!("{}, one every {} ms, {}", setpoints.len(), args.period_ms, args.dialect()));
    for (name, q) in [("first", setpoints.first()), ("last", setpoints.last())] {
        let Some(q) = q else { continue };
        let mut text = String::new();
        args.dialect().write(&Order::Setpoint { q: *q, period: settings.period }, &mut text);
        fact(name, text);
    }
}

/// Says what became of it.
pub fn tell(outcome: &Outcome, fact: &mut impl FnMut(&str, String)) {
    fact("sent", format!("{} of {} setpoints", outcome.sent, outcome.setpoints));
    fact("deadlines", outcome.deadlines.to_string());
    let (joint, off) = outcome.off;
    fact("behind", format!("{:.3} deg at most (joint {})", off.to_degrees(), joint + 1));
    fact("end", outcome.end());
    fact("arm", outcome.arm());
}

pub fn write_setpoints(
    setpoints: &[Joints<6>],
    settings: &SendSettings,
    names: &[String],
    staging: &mut Staging,
) -> Result<(), Failure> {
    // The first columns of a trajectory: time and positions.
    let columns = &trajectory_columns(names)[..=names.len()];
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(staging.create(SETPOINTS)?);
    let mut write = || {
        writer.write_record(columns)?;
        for (i, q) in setpoints.iter().enumerate() {
            writer.serialize((i as f64 * settings.period, q.as_slice()))?;
        }
        writer.flush().map_err(csv::Error::from)
    };
    write().map_err(|error| Failure::from(staging.failed(SETPOINTS, error.into())))
}

/// Publishes the files, and ends with the doubt where there was one.
pub fn finish(
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
    let Some(outcome) = outcome else { return Ok(()) };
    match outcome.fault {
        None if outcome.stopped_by_order => Err(Failure::Told(STOPPED_BY_ORDER)),
        None => Ok(()),
        Some(Fault::Interrupted) => Err(Failure::Told(INTERRUPTED as u8)),
        Some(_) => Err(Failure::Told(1)),
    }
}
