//! Every planner on one job: how long the motion is, how long planning takes, and which limits it breaks.
//!
//! All planners read the same rows on the grid of the job's own joint path; those of second order get them without the limits on
//! jerk. Each law is then verified as a plan is: on dense samples, by code that knows no planner.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use arcfeed_feedrate::{FeedError, FeedPlanner, FeedProblem, SpeedLaw};
use arcfeed_interp::{Method, MotionPath, PathArm, PathParameter, PathProblem, PlanError, Planner, Verification};
use serde::Serialize;

use super::error::Cr7Error;
use super::limit_line::{LimitLine, TOLERANCE};
use super::limit_lines::limit_lines;
use super::task::Task;
use crate::output::bound_report::BoundReport;
use crate::reproduce::qb::published::PublishedScan;
use crate::text::clip;

/// Places of the path at which profiles are drawn.
const DRAWN: usize = 3000;

/// One planner on the job.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    /// Name of the planner.
    pub planner: &'static str,
    /// True if it keeps limits on jerk.
    pub jerk_limited: bool,
    /// Duration of the motion, s; none where it found no motion.
    pub duration_s: Option<f64>,
    /// Duration over the lower bound of its order, where that is known.
    pub ratio_to_bound: Option<f64>,
    /// Time to plan, s: rows or boxes included, joint path and verification not.
    pub planning_time_s: f64,
    /// The worst place of each kind of limit that the planner is to keep, the worst first.
    pub worst: Vec<LimitLine>,
    /// Why there is no motion.
    pub error: Option<String>,
    /// Speed (m/s) over the path (m), for a picture.
    #[serde(skip)]
    pub profile: Vec<(f64, f64)>,
}

impl Entry {
    /// True if every limit it is to keep is kept.
    pub fn keeps(&self) -> bool {
        self.duration_s.is_some() && self.worst.iter().all(LimitLine::holds)
    }
}

/// All planners on one job. Its fields are the keys of the JSON form, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Name of the path.
    pub name: String,
    /// Length of the path, m.
    pub length_m: f64,
    /// Intervals of the grid that all planners share.
    pub intervals: usize,
    /// No motion that keeps the limits without jerk at both ends of every interval, with constant acceleration in between, takes less
    /// than this, s: the dual bound of the conic program. Only with the feature `baseline`.
    pub lower_bound_s: Option<f64>,
    /// No motion that keeps the limits with jerk on the grid of the plan of the job takes less than this.
    pub jerk_limited_bound: Option<BoundReport>,
    /// The planners.
    pub entries: Vec<Entry>,
    /// What a person should know.
    pub warnings: Vec<String>,
    /// Files written.
    pub files: Vec<PathBuf>,
    /// Greatest speed (m/s) at constant speed over the path (m), for a picture.
    #[serde(skip)]
    pub limit_curve: Vec<(f64, f64)>,
}

/// Runs every planner on the job; `progress` is told which one is at work. Durations are not rounded up to whole control periods, which a
/// warning says where the job asks for these.
///
/// # Errors
/// [`Cr7Error::Plan`] where the arm cannot follow the path, or no speed keeps the limits.
pub fn compare<A: PathArm<N>, const N: usize>(
    task: &Task<A, N>,
    mut progress: impl FnMut(&'static str),
) -> Result<Comparison, Cr7Error> {
    let fail = |error: PlanError| task.error(error);
    let planner = task.planner_within(task.own_limits())?;
    let path = task.tool_path()?;
    progress("joint path");
    let second = Field::new(&planner, &path, Method::InterpolatedReachability).map_err(fail)?;
    let mut entries = Vec::new();
    let mut lower_bound_s = None;
    let mut on = |field: &Field<'_, N>, name, run: &mut dyn FnMut(&FeedProblem) -> Result<SpeedLaw, FeedError>| {
        progress(name);
        field.entry(&planner, name, run).map(|entry| entries.push(entry)).map_err(|error| task.error(error))
    };
    on(&second, "published", &mut |rows| PublishedScan.plan(rows))?;
    for method in [Method::ForwardBackward, Method::Reachability, Method::InterpolatedReachability] {
        on(&second, method.name(), &mut |rows| method.plan(rows))?;
    }
    #[cfg(feature = "baseline")]
    on(&second, "conic optimum", &mut |rows| {
        let bounded = arcfeed_feedrate::ClarabelBaseline.solve(rows)?;
        lower_bound_s = Some(bounded.lower_bound);
        Ok(bounded.plan)
    })?;
    let third = Field::new(&planner, &path, Method::JerkLimited).map_err(fail)?;
    on(&third, Method::JerkLimited.name(), &mut |rows| Method::JerkLimited.plan(rows))?;
    // The scans want chord segments to begin and end on the grid.
    for method in [Method::ContinuousAcceleration, Method::PerSegment { window: None }] {
        let field = Field::new(&planner.clone().with_method(method), &path, method).map_err(fail)?;
        on(&field, method.name(), &mut |rows| method.plan(rows))?;
    }
    #[cfg(not(feature = "baseline"))]
    let _ = &mut lower_bound_s;

    progress("plan of the job");
    let begin = Instant::now();
    let mut jerk_limited_bound = None;
    entries.push(match planner.plan(&path) {
        Ok(plan) => {
            progress("lower bound");
            let bound = plan.lower_bound().ok();
            jerk_limited_bound = bound.map(|bound| BoundReport::new(plan.duration(), &bound));
            Entry::new("cr7 plan, verified", true, plan.timings().speed, plan.law(), plan.verification())
        }
        Err(error) => Entry::failed("cr7 plan, verified", true, begin.elapsed(), error.to_string()),
    });
    let with_jerk = jerk_limited_bound.as_ref().map(|bound| bound.lower_bound_s);
    for entry in &mut entries {
        let bound = if entry.jerk_limited { with_jerk } else { lower_bound_s };
        entry.ratio_to_bound = entry.duration_s.zip(bound).map(|(duration, bound)| duration / bound);
    }
    let limit_curve = second.problem.initial_velocity_limit().map_err(|error| fail(error.into()))?;
    Ok(Comparison {
        name: task.name().to_owned(),
        length_m: path.length(),
        intervals: second.problem.intervals(),
        lower_bound_s,
        jerk_limited_bound,
        entries,
        warnings: task.warnings().iter().cloned().chain(task.unrounded_words()).collect(),
        files: Vec::new(),
        limit_curve: limit_curve.iter().map(|point| (point.s, point.speed)).collect(),
    })
}

/// A path with the rows for planners of one order.
struct Field<'p, const N: usize> {
    problem: PathProblem<'p, N>,
    rows: FeedProblem,
    /// Time spent on the rows.
    time: Duration,
    jerk_limited: bool,
}

impl<'p, const N: usize> Field<'p, N> {
    fn new(planner: &Planner<'p, N>, path: &'p dyn MotionPath<N>, method: Method) -> Result<Self, PlanError> {
        let problem = planner.prepare(path, method.needs())?;
        let begin = Instant::now();
        let rows = problem.rows(method.needs())?;
        Ok(Self { problem, rows, time: begin.elapsed(), jerk_limited: method.limits_jerk() })
    }

    fn entry(
        &self,
        planner: &Planner<'_, N>,
        name: &'static str,
        run: &mut dyn FnMut(&FeedProblem) -> Result<SpeedLaw, FeedError>,
    ) -> Result<Entry, PlanError> {
        let begin = Instant::now();
        let result = run(&self.rows);
        let time = self.time + begin.elapsed();
        Ok(match result {
            Ok(law) => {
                let verification = planner.verify(&self.problem, &law, self.jerk_limited)?;
                Entry::new(name, self.jerk_limited, time, &law, &verification)
            }
            Err(error) => Entry::failed(name, self.jerk_limited, time, error.to_string()),
        })
    }
}

impl Entry {
    fn new(
        planner: &'static str,
        jerk_limited: bool,
        time: Duration,
        law: &SpeedLaw,
        verification: &Verification,
    ) -> Self {
        let (from, length) = (law.start(), law.end().p - law.start());
        let at = |i: usize| from + length * i as f64 / DRAWN as f64;
        Self {
            planner,
            jerk_limited,
            duration_s: Some(law.duration()),
            ratio_to_bound: None,
            planning_time_s: time.as_secs_f64(),
            worst: worst(verification),
            error: None,
            profile: (0..=DRAWN).map(at).map(|s| (s, law.v_at_s(s))).collect(),
        }
    }

    fn failed(planner: &'static str, jerk_limited: bool, time: Duration, error: String) -> Self {
        Self {
            planner,
            jerk_limited,
            duration_s: None,
            ratio_to_bound: None,
            planning_time_s: time.as_secs_f64(),
            worst: Vec::new(),
            error: Some(error),
            profile: Vec::new(),
        }
    }
}

/// The worst place of each kind of limit, the worst first.
fn worst(verification: &Verification) -> Vec<LimitLine> {
    let mut worst: Vec<LimitLine> = Vec::new();
    for line in limit_lines(verification, PathParameter::ArcLength) {
        match worst.iter_mut().find(|known| known.name == line.name) {
            Some(known) if known.ratio.is_nan() || line.ratio <= known.ratio => {}
            Some(known) => *known = line,
            None => worst.push(line),
        }
    }
    worst.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    worst
}

impl Display for Comparison {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {:.2} mm, {} intervals", clip(&self.name, 60), self.length_m * 1e3, self.intervals)?;
        if let Some(bound) = self.lower_bound_s {
            writeln!(f, "  bound without jerk at least {bound:.6} s (dual of the conic program)")?;
        }
        if let Some(bound) = &self.jerk_limited_bound {
            writeln!(f, "  bound with jerk {}", bound.line())?;
        }
        let ratio = if self.lower_bound_s.is_some() || self.jerk_limited_bound.is_some() { "/ bound" } else { "" };
        writeln!(
            f,
            "\n  {:<27}{:<9}{:>13}{ratio:>10}{:>12}   worst on dense samples",
            "planner", "jerk", "duration [s]", "plan [ms]"
        )?;
        for entry in &self.entries {
            let jerk = if entry.jerk_limited { "limited" } else { "ignored" };
            write!(f, "  {:<27}{jerk:<9}", entry.planner)?;
            let Some(duration) = entry.duration_s else {
                writeln!(f, "  no motion: {}", entry.error.as_deref().unwrap_or_default())?;
                continue;
            };
            let ratio = entry.ratio_to_bound.map_or(String::new(), |ratio| format!("{ratio:.5}"));
            let worst = entry.worst.first().map_or(String::new(), |worst| {
                let joint = worst.joint.map(|joint| format!(" J{joint}")).unwrap_or_default();
                let place = worst.at_s_m.map(|s| format!(" at {:.2} mm", s * 1e3)).unwrap_or_default();
                let place = format!("{}{joint}{place}", worst.name);
                if worst.ratio > 1.0 + TOLERANCE {
                    format!("BROKEN by {:.3} %: {place}", 100.0 * (worst.ratio - 1.0))
                } else {
                    format!("kept, {:.2} % of {place}", 100.0 * worst.ratio)
                }
            });
            writeln!(f, "{duration:>13.6}{ratio:>10}{:>12.3}   {worst}", entry.planning_time_s * 1e3)?;
        }
        for warning in &self.warnings {
            writeln!(f, "  warning    {}", clip(warning, 200))?;
        }
        writeln!(
            f,
            "\n  Planners that ignore jerk are of second order: their acceleration steps, and no drive follows them exactly.\n  The \
             published scan stands here for reproduction: it tests one end of each interval only."
        )?;
        if self.lower_bound_s.is_some() {
            writeln!(
                f,
                "  The bound without jerk holds for constant acceleration between grid points and without limits on jerk; planners that vary it \
                 there\n  (certified, jerk-limited) may come out below it by what that costs, a few 0.1 %."
            )?;
        } else {
            writeln!(
                f,
                "  For the ratio of planners that ignore jerk build with --features baseline (the conic optimum by clarabel)."
            )?;
        }
        self.files.iter().try_for_each(|file| writeln!(f, "  wrote {}", clip(&file.display().to_string(), 90)))
    }
}
