//! `cr7`: plan tool paths for the Dobot CR7, look at them, and check what the papers claim.

mod advise;
mod batch;
mod compare;
mod formats;
mod inspect;
mod joint_move;
mod joint_space;
mod online;
mod output;
mod page_file;
mod path_places;
mod picture_files;
mod place;
mod plan;
mod plan_args;
mod plan_files;
mod plan_program;
mod pose;
mod progress;
mod reproduce;
mod robot_args;
mod robots;
mod ros;
mod run;
mod schedule;
#[cfg(feature = "controller")]
mod send;
#[cfg(feature = "controller")]
mod send_args;
#[cfg(feature = "controller")]
mod send_live;
#[cfg(feature = "controller")]
mod send_motion;
#[cfg(feature = "controller")]
mod send_orders;
#[cfg(feature = "controller")]
mod send_steps;
mod shell;
mod tool_path;
mod verify;

use std::process::ExitCode;

use crate::Cr7Error;
use clap::{Parser, Subcommand};

/// Plans tool paths for the Dobot CR7 and other robot arms: NURBS paths cut within a chord tolerance, speed planned under tool and
/// joint limits, every result verified before it is handed out.
///
/// Exit codes: 0 done, 1 cannot be planned (or a limit or guarantee does not hold), 2 bad usage or input, 130 interrupted; `cr7 send`: 3
/// stopped by an order.
/// With another code than 0 no trajectory stands in the folder: neither a new one nor that of an earlier run.
#[derive(Debug, Parser)]
#[command(name = "cr7", version, arg_required_else_help = true, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "Examples:
  cr7 plan                              the embedded butterfly: trajectory, pictures and report in out/
  cr7 plan part.json --out part         a path of your own
  cr7 plan --job job.toml --json        a job file; the report as JSON on stdout
  cr7 compare job.toml                  every planner on one job
  cr7 advise job.toml                   what each limit costs, and which to raise first
  cr7 batch jobs.jsonl -j 8             many jobs, one line of JSON each; goes on after an interruption
  cr7 inspect part.csv --unit mm        length, curvature and segments of a path
  cr7 place part.ngc --z-mm 0 --turn    where the workpiece can stand
  cr7 fk --deg 0 -30 90 30 -90 0        where the tool stands
  cr7 ik --xyz-mm 400 0 300 --rpy-deg 180 0 0
  cr7 move --from-deg 0 -30 90 30 -90 0 --to-deg 60 0 60 30 -90 45
                                        a joint move: trajectory, pictures and report
  cr7 online scenario.toml              targets and limits that change while the arm moves
  cr7 schedule pick.toml --robot kr6_r700
                                        from pose to pose or through way-points, torque limits included
  cr7 run scenario.toml                 a path with events, holds and other feeds while it runs
  cr7 verify recorded.csv               a trajectory of any source against the limits
  cr7 plan --robot panda                another robot; `cr7 robots` lists them, files do as well
  cr7 reproduce pn                      the numbers of a paper beside ours";

#[derive(Debug, Subcommand)]
enum Command {
    /// Plan a motion along a path: trajectory CSV, SVG pictures, report
    Plan(plan_args::Args),
    /// Compare all planners on one job: duration, computing time, limits broken, a picture
    Compare(compare::Args),
    /// What each limit of a job costs in seconds, and which to raise first
    Advise(advise::Args),
    /// Many jobs: a folder of job files or a file with one a line; each planned, verified and told as one line
    Batch(batch::Args),
    /// Look at a path: length, curvature, segments by each method, a picture
    Inspect(inspect::Args),
    /// Where a workpiece can stand so that the whole path is in reach
    Place(place::Args),
    /// Forward kinematics: where the tool stands at given joint angles
    Fk(pose::ForwardArgs),
    /// Inverse kinematics: all joint angles that reach a pose
    Ik(pose::InverseArgs),
    /// Jacobian and distance from singular poses at given joint angles
    Jacobian(pose::JacobianArgs),
    /// Torque of the drives for given joint angles, velocities and accelerations
    Torque(pose::TorqueArgs),
    /// The robots that come with the program
    Robots(robots::Args),
    /// Joint move: from one joint state to another, all joints together
    Move(joint_move::Args),
    /// Joint motion towards targets, and within limits, that change on the way
    Online(online::Args),
    /// Speed from pose to pose or through joint way-points, under limits of joints, torque and tool
    Schedule(schedule::Args),
    /// A tool path with events, holds, overrides and other feeds while it runs
    Run(run::Args),
    /// Lead a Dobot CR along a verified motion; without --address and --really only say what would be sent
    #[cfg(feature = "controller")]
    Send(send_args::Args),
    /// Hold a joint trajectory of any source against the limits of an arm and a job
    Verify(verify::Args),
    /// Reproduce a paper's numbers beside ours, and check our guarantees
    Reproduce(reproduce::Args),
    /// The JSON schema of all reports: what every key means
    Schema(shell::SchemaArgs),
    /// A script with which a shell completes the commands
    Completions(shell::CompletionArgs),
    /// The manual page, with all commands
    Man(shell::ManArgs),
}

/// The failure of a command, which is also its exit code.
enum Failure {
    /// The input is fine but the thing cannot be done: exit code 1.
    Undoable(String),
    /// Bad usage or input: exit code 2.
    BadInput(String),
    /// An arm did not come to the end of its motion, and what became of it is on stderr already: the exit code.
    #[cfg(feature = "controller")]
    Told(u8),
}

impl From<Cr7Error> for Failure {
    fn from(error: Cr7Error) -> Self {
        match error {
            Cr7Error::Compile { file, source } => Self::Undoable(format!("{file}, --compile-rad: {source}")),
            Cr7Error::Plan { .. }
            | Cr7Error::Configuration { .. }
            | Cr7Error::Unsuited { .. }
            | Cr7Error::TooManySamples { .. } => Self::Undoable(error.to_string()),
            _ => Self::BadInput(error.to_string()),
        }
    }
}

impl From<crate::TooManySamples> for Failure {
    fn from(error: crate::TooManySamples) -> Self {
        Self::Undoable(error.to_string())
    }
}

impl Failure {
    /// A limit that the motion exceeds, and the way out.
    fn exceeded(error: &crate::Exceeded, remedy: &str) -> Self {
        Self::Undoable(format!("{error}; no file is written: {remedy}"))
    }
}

impl From<crate::InputError> for Failure {
    fn from(error: crate::InputError) -> Self {
        Self::BadInput(error.to_string())
    }
}

/// The exit code of a program that Ctrl-C ended.
const INTERRUPTED: i32 = 130;

/// Ends the program, unless an arm is led: that is stopped first.
fn on_interrupt() {
    #[cfg(feature = "controller")]
    if send_steps::stop_is_asked() {
        return;
    }
    crate::interrupt(INTERRUPTED)
}

/// The command `cr7` with the arguments of the process: its exit code, 0 for done, else as the help says.
pub fn command_line() -> ExitCode {
    let command = Cli::parse().command;
    let handler = ctrlc::set_handler(on_interrupt);
    if let Err(error) = &handler {
        eprintln!("cr7: no handler for Ctrl-C: {error}; an interrupted run may leave hidden files");
    }
    let outcome = match command {
        Command::Plan(args) => plan::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Advise(args) => advise::run(&args),
        Command::Batch(args) => batch::run(&args),
        Command::Inspect(args) => inspect::run(&args),
        Command::Place(args) => place::run(&args),
        Command::Fk(args) => pose::forward(&args),
        Command::Ik(args) => pose::inverse(&args),
        Command::Jacobian(args) => pose::jacobian(&args),
        Command::Torque(args) => pose::torque(&args),
        Command::Robots(args) => robots::run(&args),
        Command::Move(args) => joint_move::run(&args),
        Command::Online(args) => online::run(&args),
        Command::Schedule(args) => schedule::run(&args),
        Command::Run(args) => run::run(&args),
        #[cfg(feature = "controller")]
        Command::Send(args) => send::run(&args, handler.is_ok()),
        Command::Verify(args) => verify::run(&args),
        Command::Reproduce(args) => reproduce::run(&args),
        Command::Schema(args) => shell::schema(&args),
        Command::Completions(args) => shell::completions(&args),
        Command::Man(args) => shell::man(&args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Undoable(message)) => {
            eprintln!("cr7: {message}");
            ExitCode::from(1)
        }
        Err(Failure::BadInput(message)) => {
            eprintln!("cr7: {message}");
            ExitCode::from(2)
        }
        #[cfg(feature = "controller")]
        Err(Failure::Told(code)) => ExitCode::from(code),
    }
}
