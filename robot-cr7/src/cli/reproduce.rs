//! `cr7 reproduce`: the numbers of a paper beside ours.

use std::path::PathBuf;

use crate::Cr7Error;
use crate::reproduce::{Overview, PAPERS, Reproduced, write_figures};
use clap::ValueEnum;

use crate::cli::Failure;
use crate::cli::output::{say, say_as_is};
use crate::cli::progress::Progress;

/// Arguments of `cr7 reproduce`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 reproduce pn                         tables 1 and 2 and the segment counts, beside ours
  cr7 reproduce hs --out figures           tables 1 to 8, and figures 1, 2, 5, 7, 9 and 11 to 14 drawn anew
  cr7 reproduce qb --out figures           tables 1 to 3, and figures 2 to 9 and 11 to 14 drawn anew
  cr7 reproduce all --out figures          every paper, with a page that shows rows and figures
  cr7 reproduce all --markdown             every row, as tables
  cr7 reproduce pn --json

Exit code 1 tells that a row which counts does not hold.")]
pub struct Args {
    /// Which paper
    paper: Paper,
    /// Draw the figures into this folder, with an index.html
    #[arg(long)]
    out: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// Print tables in Markdown: what the papers print, beside ours
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Paper {
    /// Liu et al. 2023, planar NURBS interpolation (Appl. Sci. 13, 13210)
    Pn,
    /// Liu et al. 2024, online trajectories in task and joint space (Actuators 13, 108)
    Hs,
    /// Huang, Wong, Cheng 2025, velocity scheduling between poses (Electronics 14, 3869)
    Qb,
    /// All of them
    All,
}

impl Paper {
    /// Short name in [`PAPERS`]; `None` for all.
    fn name(self) -> Option<&'static str> {
        match self {
            Self::Pn => Some("pn"),
            Self::Hs => Some("hs"),
            Self::Qb => Some("qb"),
            Self::All => None,
        }
    }
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let progress = Progress::new("reproducing");
    let wanted = PAPERS.iter().filter(|(name, _)| args.paper.name().is_none_or(|wanted| wanted == *name));
    let papers: Vec<Reproduced> = wanted.map(|(_, run)| run()).collect::<Result<_, Cr7Error>>()?;
    let files = args.out.as_ref().map_or(Ok(Vec::new()), |out| write_figures(out, &papers))?;
    drop(progress);
    let overview = Overview::of(papers.into_iter().map(|p| p.reproduction).collect());
    if args.json {
        match overview.papers.as_slice() {
            [one] if args.paper != Paper::All => say!("{}", one.to_json()),
            _ => say!("{}", overview.to_json()),
        }
    } else if args.markdown {
        say_as_is!("{}", overview.to_markdown());
    } else {
        for paper in &overview.papers {
            say!("{paper}");
        }
        if args.paper == Paper::All {
            say!("all papers: {}", overview.tally);
        }
        for file in files {
            say!("wrote {}", file.display());
        }
    }
    match overview.exit_code() {
        0 => Ok(()),
        _ => Err(Failure::Undoable(format!(
            "{} of {} rows that count do not hold: see the lines marked BROKEN",
            overview.broken,
            overview.tally.counted()
        ))),
    }
}
