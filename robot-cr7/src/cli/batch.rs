//! `cr7 batch`: many jobs, one line of results each.

use std::collections::{HashMap, HashSet};
use std::fs::{self, File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::channel;
use std::time::Instant;

use crate::{BatchItem, BatchResult, InputError};

use crate::cli::Failure;
use crate::cli::output::{say, show};
use crate::cli::progress::Progress;
use crate::output::folder_lock::FolderLock;
use crate::output::whole_file::{unwritten, write_whole};

/// The file of the results in the folder of the batch.
const RESULTS: &str = "results.jsonl";
/// The folder of the trajectories in it.
const TRAJECTORIES: &str = "trajectories";
/// Failures that are told one by one; all are in the results.
const TOLD: usize = 10;

/// Arguments of `cr7 batch`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 batch jobs/                      every .toml file of the folder is a job
  cr7 batch jobs.jsonl -j 8            one job a line, eight at a time
  cr7 batch jobs.jsonl --trajectories  the samples of each motion as CSV, too

A line holds the tables of a job file as JSON, and beside them a name and a robot:
  {\"id\": \"a1\", \"robot\": \"ur5e\", \"path\": {\"file\": \"part.json\"}, \"feed\": {\"feed_mm_s\": 50}}

Each result is a line of OUT/results.jsonl. A batch that was interrupted goes on where it was: what has a result is not done again.
A result belongs to a name: a job that has changed under its old name is not done again. The name of a job without id is
the number of its line: give ids where lines may be added. Exit code 1 if any job has no motion.")]
pub struct Args {
    /// A folder of job files (.toml), or a file with a job on each line (.jsonl)
    jobs: PathBuf,
    /// Jobs at a time [default: as many as the machine has cores]
    #[arg(short = 'j', long = "at-a-time", value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs_at_a_time: Option<u16>,
    /// Folder for the results; created when missing
    #[arg(long, default_value = "batch")]
    out: PathBuf,
    /// Robot of the job files of a folder
    #[arg(long, default_value = "cr7")]
    robot: String,
    /// Also write the samples of each motion, as OUT/trajectories/ID.csv
    #[arg(long)]
    trajectories: bool,
    /// Do jobs again that have failed
    #[arg(long)]
    retry: bool,
    /// Print the summary as one JSON object
    #[arg(long)]
    json: bool,
}

/// A job before it is read.
enum Source {
    Line(String, usize),
    File(PathBuf),
}

impl Source {
    fn item(&self, args: &Args) -> BatchItem {
        match self {
            Self::Line(line, number) => BatchItem::from_line(line, *number, &args.jobs),
            Self::File(file) => BatchItem::from_file(file, &args.robot),
        }
    }
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let sources = sources(&args.jobs)?;
    let trajectories = args.trajectories.then(|| args.out.join(TRAJECTORIES));
    let folder = trajectories.as_deref().unwrap_or(&args.out);
    fs::create_dir_all(folder).map_err(unwritten(folder))?;
    // Held until the end: two batches would give the jobs two results each.
    let lock = FolderLock::take(&args.out)?;
    lock.remove_left_parts(&args.out);
    lock.remove_left_parts(folder);
    let results = args.out.join(RESULTS);
    let mut earlier = read_results(&results, args.retry)?;
    if let Some(folder) = &trajectories {
        // A motion without its trajectory is made again.
        earlier.retain(|result| result.error.is_some() || folder.join(format!("{}.csv", result.id)).exists());
    }
    let done: HashMap<&str, bool> = earlier.iter().map(|result| (result.id.as_str(), result.error.is_some())).collect();
    let mut file = begin(&results, &earlier)?;

    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let workers = args.jobs_at_a_time.map_or(cores, usize::from).min(sources.len().max(1));
    let progress = Progress::new("planning");
    let begin = Instant::now();
    let next = AtomicUsize::new(0);
    let mut tally = Tally::default();
    std::thread::scope(|scope| -> Result<(), InputError> {
        let (sender, receiver) = channel::<Result<BatchResult, bool>>();
        for _ in 0..workers {
            let (sender, sources, next, done, trajectories) = (sender.clone(), &sources, &next, &done, &trajectories);
            scope.spawn(move || {
                while let Some(source) = sources.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let item = source.item(args);
                    let result = match done.get(item.id.as_str()) {
                        Some(failed) => Err(*failed),
                        None => Ok(item.run(trajectories.as_deref())),
                    };
                    if sender.send(result).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        for result in receiver {
            let result = match result {
                Ok(result) => result,
                Err(failed) => {
                    tally.skipped += 1;
                    tally.failed_before += usize::from(failed);
                    continue;
                }
            };
            let line = serde_json::to_string(&result).unwrap_or_default() + "\n";
            file.write_all(line.as_bytes()).map_err(|source| {
                // Nobody takes results any more: the workers stop after their present job.
                next.store(usize::MAX / 2, Ordering::Relaxed);
                InputError::Write { file: results.clone(), source }
            })?;
            tally.take(&result);
            let (finished, seconds) = (tally.done + tally.failed, begin.elapsed().as_secs_f64());
            progress.step(&format!(
                "{finished} of {} done, {} failed, {:.1} a second",
                sources.len() - tally.skipped,
                tally.failed,
                finished as f64 / seconds
            ));
        }
        Ok(())
    })?;
    drop(progress);
    tally.seconds = begin.elapsed().as_secs_f64();
    conclude(args, &tally, &results)
}

#[derive(Debug, Default, serde::Serialize)]
struct Tally {
    /// Motions, failures, and jobs that had a result before.
    done: usize,
    failed: usize,
    skipped: usize,
    /// Those of them that had failed.
    failed_before: usize,
    /// Sum of the durations of the motions, s.
    motion_s: f64,
    /// Time of the whole batch, s.
    seconds: f64,
    /// The first failures, name and reason.
    failures: Vec<(String, String)>,
}

impl Tally {
    fn take(&mut self, result: &BatchResult) {
        match &result.error {
            None => self.done += 1,
            Some(error) => {
                self.failed += 1;
                if self.failures.len() < TOLD {
                    self.failures.push((result.id.clone(), error.clone()));
                }
            }
        }
        self.motion_s += result.duration_s.unwrap_or(0.0);
    }
}

fn conclude(args: &Args, tally: &Tally, results: &Path) -> Result<(), Failure> {
    if args.json {
        show(&"", Some(serde_json::to_string(tally).unwrap_or_default()));
    } else {
        let per_second = (tally.done + tally.failed) as f64 / tally.seconds.max(1e-9);
        say!(
            "{} motions, {:.1} s in all, in {:.1} s ({per_second:.1} jobs a second)",
            tally.done,
            tally.motion_s,
            tally.seconds
        );
        if tally.skipped > 0 {
            let failed = match tally.failed_before {
                0 => String::new(),
                failed => format!(", {failed} of them a failure: --retry does these again"),
            };
            say!("{} jobs had a result before{failed}", tally.skipped);
        }
        for (id, error) in &tally.failures {
            say!("! {id}: {error}");
        }
        if tally.failed > tally.failures.len() {
            say!("  and {} more failures", tally.failed - tally.failures.len());
        }
        say!("  wrote {}", results.display());
    }
    match tally.failed + tally.failed_before {
        0 => Ok(()),
        failed => Err(Failure::Undoable(format!("{failed} jobs have no motion; {} says why", results.display()))),
    }
}

/// The jobs of a folder by their names, or of a file by line.
fn sources(jobs: &Path) -> Result<Vec<Source>, Failure> {
    let unreadable = |source| InputError::Read { file: jobs.to_owned(), source, remedy: "check the name" };
    let mut sources = Vec::new();
    if jobs.is_dir() {
        for entry in fs::read_dir(jobs).map_err(unreadable)? {
            let file = entry.map_err(unreadable)?.path();
            if file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
                sources.push(file);
            }
        }
        sources.sort();
        let mut names = HashSet::new();
        for file in &sources {
            let stem = file.file_stem().unwrap_or_default().to_string_lossy().to_lowercase();
            if !names.insert(stem) {
                return Err(Failure::BadInput(format!("{}: another job file has this name", file.display())));
            }
        }
        if sources.is_empty() {
            return Err(Failure::BadInput(format!("{}: no job file (.toml) in this folder", jobs.display())));
        }
        return Ok(sources.into_iter().map(Source::File).collect());
    }
    let mut names: HashMap<String, usize> = HashMap::new();
    let reader = BufReader::new(File::open(jobs).map_err(unreadable)?);
    let mut lines = Vec::new();
    for (i, line) in reader.lines().enumerate() {
        let line = line.map_err(unreadable)?;
        let line = line.strip_prefix('\u{feff}').unwrap_or(&line).to_owned();
        if line.trim().is_empty() {
            continue;
        }
        let id = BatchItem::id_of(&line, i + 1);
        if let Some(before) = names.insert(id.to_lowercase(), i + 1) {
            let what =
                format!("{}:{}: id \"{id}\" is that of line {before}: give each job its own", jobs.display(), i + 1);
            return Err(Failure::BadInput(what));
        }
        lines.push(Source::Line(line, i + 1));
    }
    match lines.is_empty() {
        true => Err(Failure::BadInput(format!("{}: no job in this file: give one JSON object a line", jobs.display()))),
        false => Ok(lines),
    }
}

/// The results of an earlier run, without the failures where they are to be tried again. A last line that was not finished does not count.
fn read_results(file: &Path, retry: bool) -> Result<Vec<BatchResult>, Failure> {
    let text = match fs::read_to_string(file) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(source) => {
            return Err(InputError::Read { file: file.to_owned(), source, remedy: "choose another --out" }.into());
        }
    };
    let mut results = Vec::new();
    let lines = text.lines().count();
    for (i, line) in text.lines().enumerate() {
        match serde_json::from_str::<BatchResult>(line) {
            Ok(result) if retry && result.error.is_some() => {}
            Ok(result) => results.push(result),
            Err(_) if i + 1 == lines && !text.ends_with('\n') => {}
            Err(error) => {
                let what = format!("{}:{}: no result of a batch: {error}; choose another --out", file.display(), i + 1);
                return Err(Failure::BadInput(what));
            }
        }
    }
    Ok(results)
}

/// The file of the results, open behind those of earlier runs, which are written anew.
fn begin(file: &Path, earlier: &[BatchResult]) -> Result<File, InputError> {
    let mut text = String::new();
    for result in earlier {
        text += &serde_json::to_string(result).unwrap_or_default();
        text.push('\n');
    }
    write_whole(file, |mut part| part.write_all(text.as_bytes()).map_err(unwritten(file)))?;
    OpenOptions::new().append(true).open(file).map_err(unwritten(file))
}
