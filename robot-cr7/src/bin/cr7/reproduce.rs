//! `cr7 reproduce`: the numbers of a paper beside ours.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use robot_cr7::InputError;
use robot_cr7::plot::{Line, joint_panels_picture, lines_picture, save_picture, speed_picture};
use robot_cr7::reproduce::{
    Figure, Overview, Reproduction, ScheduleFigures, huang_2025, liu_2023, liu_2024, liu_2024_pictures,
};

use crate::Failure;
use crate::output::{say, say_as_is};
use crate::progress::Progress;

/// Arguments of `cr7 reproduce`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 reproduce pn                         tables 1 and 2 and the segment counts, beside ours
  cr7 reproduce hs --out figures           tables 3 to 8, and figures 5, 7, 9 and 11 to 14 drawn anew
  cr7 reproduce qb --out figures           tables 1 to 3, and figures 2 to 9 drawn anew
  cr7 reproduce all --markdown             every paper's numbers beside ours, as tables
  cr7 reproduce pn --json")]
pub struct Args {
    /// Which paper
    paper: Paper,
    /// Draw the figures into this folder (hs and qb have some, pn has none)
    #[arg(long)]
    out: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// Print tables in Markdown: what the papers print, beside ours
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
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

pub fn run(args: &Args) -> Result<(), Failure> {
    let progress = Progress::new("reproducing");
    let (mut figures, mut schedules) = (Vec::new(), ScheduleFigures::default());
    let reproduction: Reproduction = match args.paper {
        Paper::Pn => liu_2023()?,
        Paper::Hs => {
            let (reproduction, drawn) = liu_2024();
            figures = drawn;
            reproduction
        }
        Paper::Qb => {
            let (reproduction, drawn) = huang_2025();
            schedules = drawn;
            reproduction
        }
        Paper::All => return all(args),
    };
    let files = match &args.out {
        Some(out) => {
            let mut files = draw(out, &figures)?;
            files.extend(draw_schedules(out, &schedules)?);
            if let Paper::Hs = args.paper {
                files.extend(draw_runs(out)?);
            }
            files
        }
        None => Vec::new(),
    };
    drop(progress);
    if args.json {
        say!("{}", reproduction.to_json());
    } else if args.markdown {
        let broken = reproduction.broken().count();
        let guarantees = reproduction.claims.iter().filter(|c| c.holds.is_some()).count();
        let papers = vec![reproduction.clone()];
        say_as_is!("{}", Overview { papers, guarantees, broken }.to_markdown());
    } else {
        say_as_is!("{reproduction}");
        for file in files {
            say!("wrote {}", file.display());
        }
    }
    verdict(reproduction.broken().count())
}

fn verdict(broken: usize) -> Result<(), Failure> {
    match broken {
        0 => Ok(()),
        n => Err(Failure::Undoable(format!("{n} guarantees do not hold: see the lines marked BROKEN"))),
    }
}

fn all(args: &Args) -> Result<(), Failure> {
    let progress = Progress::new("reproducing all papers");
    let overview = Overview::new()?;
    drop(progress);
    if args.json {
        say!("{}", overview.to_json());
    } else if args.markdown {
        say_as_is!("{}", overview.to_markdown());
    } else {
        for paper in &overview.papers {
            say!("{paper}");
        }
        say!("all papers: {} of {} guarantees hold", overview.guarantees - overview.broken, overview.guarantees);
    }
    verdict(overview.broken)
}

fn draw_runs(out: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    for (name, svg) in liu_2024_pictures()? {
        let file = out.join(name);
        let svg = svg.map_err(|source| InputError::Write { file: file.clone(), source })?;
        save_picture(&file, &svg)?;
        files.push(file);
    }
    Ok(files)
}

fn draw(out: &Path, figures: &[Figure]) -> Result<Vec<PathBuf>, Failure> {
    std::fs::create_dir_all(out).map_err(|source| InputError::Write { file: out.to_owned(), source })?;
    let mut files = Vec::new();
    for figure in figures {
        let file = out.join(figure.file);
        let lines: Vec<Line<'_>> =
            figure.lines.iter().map(|line| Line { name: &line.name, points: &line.points }).collect();
        let svg = lines_picture(figure.title, &figure.facts, (figure.across, figure.label), &lines, &[])
            .map_err(|source| InputError::Write { file: file.clone(), source })?;
        save_picture(&file, &svg)?;
        files.push(file);
    }
    Ok(files)
}

fn draw_schedules(out: &Path, figures: &ScheduleFigures) -> Result<Vec<PathBuf>, Failure> {
    let speeds = figures.speeds.iter().map(|figure| (&figure.file, speed_picture(figure)));
    let joints = figures.joints.iter().map(|figure| (&figure.file, joint_panels_picture(figure)));
    let mut files = Vec::new();
    for (name, svg) in speeds.chain(joints) {
        let file = out.join(name);
        let svg = svg.map_err(|source| InputError::Write { file: file.clone(), source })?;
        save_picture(&file, &svg)?;
        files.push(file);
    }
    Ok(files)
}
