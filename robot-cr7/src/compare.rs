//! Every planner on one job: how long the motion is, how long planning takes, and which limits it breaks.
//!
//! All planners read the same rows on the grid of the job's own joint path; those of second order get them without the limits on
//! jerk. Each law then is held against the limits themselves on twenty places in every interval of the grid, with the inverse
//! kinematics solved anew there.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use arcfeed_feedrate::{
    BothEndsScan, CertifiedReachability, FeedError, FeedPlanner, FeedProblem, JerkLimited, PublishedScan, Reachability,
    SpeedLaw, caps,
};
use arcfeed_interp::{JointJet, PathArm, Plan, PlanError, Scan, joint_jet};
use arcfeed_kinematics::{Dynamics, Joints};
use serde::Serialize;

use crate::cr7::{Cr7Error, Task};
use crate::report::clip;
use crate::verdict::TOLERANCE;

/// Places looked at in every interval of the grid.
const DENSITY: usize = 20;
/// Places of the path at which profiles are drawn.
const DRAWN: usize = 3000;

/// Where one kind of limit is used most.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Use {
    /// The limit, such as "joint acceleration" or "feed".
    pub limit: &'static str,
    /// The joint, from 1, for limits that each joint has of its own.
    pub joint: Option<usize>,
    /// How much of it is used: above 1 it is broken.
    pub ratio: f64,
    /// Where, m along the path.
    pub at_s_m: f64,
}

/// One planner on the job.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    /// Name of the planner.
    pub planner: &'static str,
    /// Whether it keeps limits on jerk.
    pub jerk_limited: bool,
    /// Duration of the motion, s; none where it found no motion.
    pub duration_s: Option<f64>,
    /// Duration over the lower bound of second order, where that is known.
    pub ratio_to_bound: Option<f64>,
    /// Time to plan, s: rows or boxes included, joint path and verification not.
    pub planning_time_s: f64,
    /// Worst use of each kind of limit that the planner is to keep, the worst first.
    pub worst: Vec<Use>,
    /// Why there is no motion.
    pub error: Option<String>,
    /// Speed (m/s) over the path (m), for a picture.
    #[serde(skip)]
    pub profile: Vec<(f64, f64)>,
}

impl Entry {
    /// Whether every limit it is to keep is kept.
    pub fn keeps(&self) -> bool {
        self.duration_s.is_some() && self.worst.iter().all(|worst| worst.ratio <= 1.0 + TOLERANCE)
    }
}

/// All planners on one job.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Name of the path.
    pub path: String,
    /// Length of the path, m.
    pub length_m: f64,
    /// Intervals of the grid that all planners share.
    pub intervals: usize,
    /// No motion that keeps the limits without jerk at both ends of every interval, with constant acceleration in between, takes less
    /// than this, s: the dual bound of the conic program. Only with the feature `baseline`.
    pub lower_bound_s: Option<f64>,
    /// The planners.
    pub entries: Vec<Entry>,
    /// Files written.
    pub files: Vec<PathBuf>,
    /// Greatest speed (m/s) at constant speed over the path (m), for a picture.
    #[serde(skip)]
    pub limit_curve: Vec<(f64, f64)>,
}

/// Runs every planner on the job; `progress` is told which one is at work.
///
/// # Errors
/// [`Cr7Error::Plan`] where the arm cannot follow the path, or no speed keeps the limits.
pub fn compare<A: PathArm<N>, const N: usize>(
    task: &Task<A, N>,
    mut progress: impl FnMut(&'static str),
) -> Result<Comparison, Cr7Error> {
    let fail = |error: PlanError| task.error(error);
    let planner = task.planner()?;
    progress("joint path");
    let ground = task.planner()?.with_scan(Scan::JerkLimited).draft(task.path().clone(), task.start()).map_err(fail)?;
    let samples = samples(task, &ground).map_err(fail)?;
    let drawn = |speed: &SpeedLaw| profile(speed, task.path().length());
    let rows_begin = Instant::now();
    let second = planner.problem(&ground, false).map_err(fail)?;
    let second_rows = rows_begin.elapsed();

    let mut entries = Vec::new();
    let mut lower_bound_s = None;
    let mut on_rows = |name,
                       problem: &FeedProblem,
                       rows: Duration,
                       jerk,
                       run: &mut dyn FnMut(&FeedProblem) -> Result<SpeedLaw, FeedError>| {
        progress(name);
        let begin = Instant::now();
        let result = run(problem);
        let time = rows + begin.elapsed();
        entries.push(match result {
            Ok(law) => finished(name, jerk, time, &law, worst(task, &ground, &samples, &law, jerk), drawn(&law)),
            Err(error) => failed(name, jerk, time, error.to_string()),
        });
    };
    on_rows("published scan", &second, second_rows, false, &mut |p| PublishedScan.plan(p));
    on_rows("both ends", &second, second_rows, false, &mut |p| BothEndsScan.plan(p));
    on_rows("reachability", &second, second_rows, false, &mut |p| Reachability.plan(p));
    on_rows("certified", &second, second_rows, false, &mut |p| CertifiedReachability.plan(p));
    #[cfg(feature = "baseline")]
    on_rows("conic optimum", &second, second_rows, false, &mut |p| {
        let bounded = arcfeed_feedrate::ClarabelBaseline.solve(p)?;
        lower_bound_s = Some(bounded.lower_bound);
        Ok(bounded.plan)
    });
    let begin = Instant::now();
    let third = planner.problem(&ground, true).map_err(fail)?;
    let third_rows = begin.elapsed();
    on_rows("jerk-limited", &third, third_rows, true, &mut |p| JerkLimited::default().plan(p));
    #[cfg(not(feature = "baseline"))]
    let _ = &mut lower_bound_s;

    for (name, scan) in
        [("box scan, joined", Scan::Joined), ("box scan, per segment", Scan::PerSegment { window: None })]
    {
        progress(name);
        let begin = Instant::now();
        entries.push(match task.planner()?.with_scan(scan).draft(task.path().clone(), task.start()) {
            Ok(plan) => {
                let worst = worst(task, &ground, &samples, plan.speed(), true);
                finished(name, true, plan.timings().scan, plan.speed(), worst, drawn(plan.speed()))
            }
            Err(error) => failed(name, true, begin.elapsed(), error.to_string()),
        });
    }
    progress("plan of the job");
    let begin = Instant::now();
    entries.push(match planner.plan(task.path().clone(), task.start()) {
        Ok(plan) => {
            let worst = worst(task, &ground, &samples, plan.speed(), true);
            finished("cr7 plan, verified", true, plan.timings().scan, plan.speed(), worst, drawn(plan.speed()))
        }
        Err(error) => failed("cr7 plan, verified", true, begin.elapsed(), error.to_string()),
    });
    if let Some(bound) = lower_bound_s {
        entries.iter_mut().for_each(|entry| entry.ratio_to_bound = entry.duration_s.map(|duration| duration / bound));
    }
    Ok(Comparison {
        path: task.name().to_owned(),
        length_m: task.path().length(),
        intervals: second.intervals(),
        lower_bound_s,
        entries,
        files: Vec::new(),
        limit_curve: limit_curve(&second),
    })
}

fn finished(
    planner: &'static str,
    jerk_limited: bool,
    time: Duration,
    law: &SpeedLaw,
    worst: Vec<Use>,
    profile: Vec<(f64, f64)>,
) -> Entry {
    Entry {
        planner,
        jerk_limited,
        duration_s: Some(law.duration()),
        ratio_to_bound: None,
        planning_time_s: time.as_secs_f64(),
        worst,
        error: None,
        profile,
    }
}

fn failed(planner: &'static str, jerk_limited: bool, time: Duration, error: String) -> Entry {
    Entry {
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

fn profile(law: &SpeedLaw, length: f64) -> Vec<(f64, f64)> {
    (0..=DRAWN).map(|i| length * i as f64 / DRAWN as f64).map(|s| (s, law.v_at_s(s))).collect()
}

/// The greatest constant speed at every grid point that rows and caps allow.
fn limit_curve(problem: &FeedProblem) -> Vec<(f64, f64)> {
    let one = |i: usize| {
        let mut v = problem.cap(i).0.sqrt();
        for row in problem.rows(i) {
            // b v^2 + c v + d leaves its bounds where it first meets one.
            for bound in [row.hi - row.d, row.lo - row.d].into_iter().filter(|bound| bound.is_finite()) {
                let (b, c) = if bound < 0.0 { (-row.b, -row.c) } else { (row.b, row.c) };
                let square = c * c + 4.0 * b * bound.abs();
                let root = c + square.sqrt();
                if square >= 0.0 && root > 0.0 {
                    v = v.min(2.0 * bound.abs() / root);
                }
            }
        }
        v
    };
    problem.grid().iter().enumerate().map(|(i, &s)| (s, one(i))).collect()
}

/// What a path demands at one place, whatever the speed there.
struct Sample<const N: usize> {
    jet: JointJet<N>,
    /// Curvature of the path, 1/m, and angle the tool turns by per length, rad/m.
    curvature: f64,
    turning: f64,
}

fn samples<A: PathArm<N>, const N: usize>(task: &Task<A, N>, ground: &Plan<N>) -> Result<Vec<Sample<N>>, PlanError> {
    let nodes = ground.joint_path().nodes();
    let mut samples = Vec::with_capacity(DENSITY * nodes.len());
    for pair in nodes.windows(2) {
        let h = pair[1].s - pair[0].s;
        for i in 0..DENSITY {
            // Just inside at both ends, where derivatives may jump.
            let fraction = (i as f64 / (DENSITY - 1) as f64).clamp(1e-6, 1.0 - 1e-6);
            let s = pair[0].s + h * fraction;
            let tool = task.path().jet(s);
            let jet = joint_jet(task.arm(), s, &tool, &pair[0].ahead(h * fraction))?;
            let (curvature, turning) = (tool.d2.fixed_rows::<3>(0).norm(), tool.d1.fixed_rows::<3>(3).norm());
            samples.push(Sample { jet, curvature, turning });
        }
    }
    Ok(samples)
}

/// The worst use of each kind of limit, the worst first.
fn worst<A: PathArm<N>, const N: usize>(
    task: &Task<A, N>,
    ground: &Plan<N>,
    samples: &[Sample<N>],
    law: &SpeedLaw,
    jerk: bool,
) -> Vec<Use> {
    let (joints, tool) = (task.joint_limits(), task.tool_limits());
    let mut uses: Vec<Use> = Vec::new();
    let mut see = |limit: &'static str, joint: Option<usize>, ratio: f64, s: f64| {
        // A NaN, once seen, stays.
        match uses.iter_mut().find(|known| known.limit == limit) {
            Some(known) if known.ratio.is_nan() || ratio <= known.ratio => {}
            Some(known) => *known = Use { limit, joint, ratio, at_s_m: s },
            None => uses.push(Use { limit, joint, ratio, at_s_m: s }),
        }
    };
    for sample in samples {
        let (jet, state) = (&sample.jet, law.at_position(sample.jet.s));
        let (s, v, a, j) = (jet.s, state.v, state.a, state.j);
        let (qd, qdd) = (jet.d1 * v, jet.d1 * a + jet.d2 * (v * v));
        let mut each = |limit, values: &Joints<N>, limits: &Joints<N>| {
            for k in 0..N {
                see(limit, Some(k + 1), values[k].abs() / limits[k], s);
            }
        };
        each("joint velocity", &qd, joints.velocity());
        each("joint acceleration", &qdd, joints.acceleration());
        if let Some(drives) = task.drives() {
            each("joint torque", &drives.dynamics.torque(&jet.q, &qd, &qdd), &drives.torque);
        }
        if jerk {
            let jerk = jet.d1 * j + jet.d2 * (3.0 * v * a) + jet.d3 * (v * v * v);
            each("joint jerk", &jerk, joints.jerk());
            see("tangential jerk", None, j.abs() / tool.tangential_jerk, s);
        }
        see("feed", None, v / ground.feed_at(s, tool.feed), s);
        see("tangential acceleration", None, a.abs() / tool.tangential_acceleration, s);
        see("normal acceleration", None, sample.curvature * v * v / tool.normal_acceleration, s);
        let chord = caps::chord_error_speed(sample.curvature, ground.chord_tolerance(), ground.period());
        see("chord error", None, (v / chord).powi(2), s);
        if let Some(limit) = tool.normal_jerk {
            see("normal jerk", None, sample.curvature.powi(2) * v.powi(3) / limit, s);
        }
        if let Some(limit) = tool.angular_speed {
            see("angular speed", None, sample.turning * v / limit, s);
        }
    }
    uses.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    uses
}

impl Comparison {
    /// The whole comparison as one JSON object on one line.
    pub fn to_json(&self) -> String {
        // As for the report: plain fields and lists.
        serde_json::to_string(self).unwrap_or_else(|e| serde_json::json!({ "error": e.to_string() }).to_string())
    }
}

impl Display for Comparison {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {:.2} mm, {} intervals", clip(&self.path, 60), self.length_m * 1e3, self.intervals)?;
        if let Some(bound) = self.lower_bound_s {
            writeln!(f, "  lower bound without jerk {bound:.6} s (dual of the conic program)")?;
        }
        let ratio = if self.lower_bound_s.is_some() { "/ bound" } else { "" };
        writeln!(
            f,
            "\n  {:<22}{:<9}{:>13}{ratio:>10}{:>12}   worst on {DENSITY} places per interval",
            "planner", "jerk", "duration [s]", "plan [ms]"
        )?;
        for entry in &self.entries {
            let jerk = if entry.jerk_limited { "limited" } else { "ignored" };
            write!(f, "  {:<22}{jerk:<9}", entry.planner)?;
            let Some(duration) = entry.duration_s else {
                writeln!(f, "  no motion: {}", entry.error.as_deref().unwrap_or_default())?;
                continue;
            };
            let ratio = entry.ratio_to_bound.map_or(String::new(), |ratio| format!("{ratio:.5}"));
            let worst = entry.worst.first().map_or(String::new(), |worst| {
                let joint = worst.joint.map(|joint| format!(" J{joint}")).unwrap_or_default();
                let place = format!("{}{joint} at {:.2} mm", worst.limit, worst.at_s_m * 1e3);
                if worst.ratio > 1.0 + TOLERANCE {
                    format!("BROKEN by {:.3} %: {place}", 100.0 * (worst.ratio - 1.0))
                } else {
                    format!("kept, {:.2} % of {place}", 100.0 * worst.ratio)
                }
            });
            writeln!(f, "{duration:>13.6}{ratio:>10}{:>12.3}   {worst}", entry.planning_time_s * 1e3)?;
        }
        writeln!(
            f,
            "\n  Planners that ignore jerk are of second order: their acceleration steps, and no drive follows them exactly.\n  The \
             published scan stands here for reproduction: it tests one end of each interval only."
        )?;
        if self.lower_bound_s.is_some() {
            writeln!(
                f,
                "  The bound holds for constant acceleration between grid points and without limits on jerk; planners that vary it \
                 there\n  (certified, jerk-limited) may come out below it by what that costs, a few 0.1 %."
            )?;
        } else {
            writeln!(
                f,
                "  For the ratio to a proven lower bound build with --features baseline (the conic optimum by clarabel)."
            )?;
        }
        self.files.iter().try_for_each(|file| writeln!(f, "  wrote {}", clip(&file.display().to_string(), 90)))
    }
}
