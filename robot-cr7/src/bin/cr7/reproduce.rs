//! `cr7 reproduce`: the numbers of a paper beside ours.

use clap::ValueEnum;
use robot_cr7::reproduce::{Reproduction, liu_2023};

use crate::Failure;
use crate::output::{say, say_as_is};
use crate::plan::spinner;

/// Arguments of `cr7 reproduce`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 reproduce pn                         tables 1 and 2 and the segment counts, beside ours
  cr7 reproduce pn --json")]
pub struct Args {
    /// Which paper
    paper: Paper,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Paper {
    /// Liu et al. 2023, planar NURBS interpolation (Appl. Sci. 13, 13210)
    Pn,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let bar = spinner("reproducing");
    let reproduction: Reproduction = match args.paper {
        Paper::Pn => liu_2023()?,
    };
    bar.finish_and_clear();
    if args.json {
        say!("{}", reproduction.to_json());
    } else {
        say_as_is!("{reproduction}");
    }
    match reproduction.broken().count() {
        0 => Ok(()),
        n => Err(Failure::Undoable(format!("{n} guarantees do not hold: see the lines marked BROKEN"))),
    }
}
