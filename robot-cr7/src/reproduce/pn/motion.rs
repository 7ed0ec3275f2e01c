//! Liu et al. 2023, sections 4 and 6.1: the butterfly scanned, its samples, and what the joining of
//! segments saves.

use arcfeed_geometry::{NurbsCurve, SegmentationMethod};
use arcfeed_interp::{Method, PlanError};
use nalgebra::Vector3;

use super::competitors::Table2Run;
use crate::input::job::Job;
use crate::input::sample_paths::SamplePath;
use crate::reproduce::checker::{AxisBounds, SampledAxis, SampledMotion};
use crate::reproduce::spline::Spline;
use crate::reproduce::{Reproduction, cr7_dh};
use crate::run::error::Cr7Error;
use crate::run::motion::Motion;
use crate::run::task::Task;

const PLACE: &str = "Section 6.1, figure 10: the butterfly scanned, and interpolated every 1 ms";
const JOINING: &str = "Section 4: what zero acceleration at every segment boundary costs, butterfly";

/// The scanned butterfly.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionRun {
    /// Arc length, feed and tangential acceleration.
    pub path: SampledMotion,
    /// The joints.
    pub joints: SampledMotion,
    /// Tool points by the Denavit-Hartenberg table, m.
    pub tool: Vec<[f64; 3]>,
    /// The curve where the tool runs it.
    pub curve: Spline,
    /// Ends of the chord segments that the plan uses.
    pub breaks: Vec<f64>,
    /// Durations, s: zero acceleration at each boundary, joined, jerk-limited.
    pub durations: [f64; 3],
    /// Times to cut, to scan, and to interpolate, s.
    pub times: [f64; 3],
}

fn failed(source: PlanError) -> Cr7Error {
    Cr7Error::Plan { file: "butterfly".to_owned(), source: Box::new(source), hint: String::new() }
}

impl MotionRun {
    /// Plans the butterfly as the paper does, and runs the methods of Table 2 under its feed law.
    ///
    /// # Errors
    /// [`Cr7Error`] when the embedded path cannot be planned.
    pub fn measure() -> Result<(Self, Table2Run), Cr7Error> {
        // The paper scans; so does this, and the jerk-limited planner stands beside it.
        let job = Job { method: Method::ContinuousAcceleration, ..Job::default() };
        let task = Task::of_cr7(&job, &SamplePath::Butterfly.load()?)?;
        let motion = task.plan()?;
        let path = task.tool_path()?;
        let with = |method| task.planner()?.with_method(method).plan(&path).map(|t| t.duration()).map_err(failed);
        let separate = with(Method::PerSegment { window: None })?;
        let least = with(Method::JerkLimited)?;
        let table_2 = {
            let nurbs = super::curves::curve_of(SamplePath::Butterfly)?;
            let curve = arcfeed_geometry::ArcLengthCurve::new(nurbs, 1e-14).map_err(super::curves::failed)?;
            Table2Run::measure(&curve, motion.trajectory().law())?
        };
        Ok((Self::sampled(&task, &motion, [separate, motion.trajectory().duration(), least])?, table_2))
    }

    fn sampled(task: &Task, motion: &Motion<'_>, durations: [f64; 3]) -> Result<Self, Cr7Error> {
        let plan = motion.trajectory();
        let begin = std::time::Instant::now();
        let points =
            motion.setpoints().map_err(|e| failed(e.into()))?.collect::<Result<Vec<_>, _>>().map_err(failed)?;
        let sampling = begin.elapsed().as_secs_f64();
        let curve: NurbsCurve<3> = task.path().curve().curve().clone();
        let spline = Spline::new(&curve);
        let (lo, hi) = spline.domain();
        let feed = Job::default().feed;
        let t: Vec<f64> = points.iter().map(|p| p.t).collect();
        let bounds = AxisBounds::symmetric(feed.feed, feed.tangential_acceleration, feed.tangential_jerk);
        let axis = SampledAxis::of_path(points.iter(), spline.length(lo, hi, 4000), bounds);
        let limits = task.joint_limits();
        let joint = |k: usize| {
            let state = |i: usize| [points[i].q[k], points[i].qd[k], points[i].qdd[k]];
            let start = state(0);
            SampledAxis {
                name: format!("joint {}", k + 1),
                p: points.iter().map(|p| p.q[k]).collect(),
                v: points.iter().map(|p| p.qd[k]).collect(),
                a: points.iter().map(|p| p.qdd[k]).collect(),
                start: [start[0], 0.0, 0.0],
                // The curve is closed: the joints come back to where they began.
                end: [start[0], 0.0, 0.0],
                bounds: vec![(
                    0.0,
                    AxisBounds::symmetric(limits.velocity()[k], limits.acceleration()[k], limits.jerk()[k]),
                )],
            }
        };
        let timings = plan.timings();
        Ok(Self {
            path: SampledMotion { t: t.clone(), axes: vec![axis], arrived: None, tolerance: 1e-12 },
            joints: SampledMotion { t, axes: (0..6).map(joint).collect(), arrived: None, tolerance: 1e-12 },
            tool: points.iter().map(|p| cr7_dh::position(&p.q.into()).into()).collect(),
            curve: spline,
            breaks: plan.segmentation().map_or_else(
                || curve.segment(SegmentationMethod::CType, 1e-6).map_or_else(|_| Vec::new(), |s| s.breaks().to_vec()),
                |s| s.breaks().to_vec(),
            ),
            durations,
            times: [timings.grid.as_secs_f64(), timings.speed.as_secs_f64(), sampling],
        })
    }

    /// Adds the rows.
    pub fn judge(&self, r: &mut Reproduction) {
        self.path.judge(r, PLACE, "path");
        self.joints.judge(r, PLACE, "joints");
        let deviation = self.curve.largest_deviation(&self.breaks, 200);
        let shown = format!("{:.7}", deviation * 1e3);
        r.independent(PLACE, "chord error of the segments in use, mm", "0.001", shown, deviation <= 1e-6);
        let (mut u, mut off) = (self.curve.domain().0, 0.0f64);
        for p in &self.tool {
            let p = Vector3::from(*p);
            u = self.curve.nearest(&p, u);
            off = off.max((self.curve.point(u) - p).norm());
        }
        r.independent(
            PLACE,
            "tool off the curve, by its DH table and de Boor, mm",
            "0",
            format!("{:.1e}", off * 1e3),
            off < 1e-12,
        );
        let [cut, scan, sampling] = self.times;
        r.information(PLACE, "time to cut the curve, s", "0.7", format!("{cut:.4}"));
        r.information(PLACE, "bidirectional scan, s", "0.3", format!("{scan:.4}"))
            .note("up to four scans with different shares of the joint limits, the fastest kept");
        r.information(PLACE, "interpolation with inverse kinematics, s", "10", format!("{sampling:.4}")).note(format!(
            "{:.2} us a cycle; the paper uses MATLAB on an i7-11800H",
            sampling / self.tool.len() as f64 * 1e6
        ));
        let [separate, joined, least] = self.durations;
        r.information(PLACE, "duration of the motion, s", "", format!("{joined:.3}"))
            .note("the paper prints neither its feed nor its limits; ours are the defaults of `cr7 plan`, scanned");
        r.information(JOINING, "zero acceleration at each boundary, s", "", format!("{separate:.3}"));
        let saves = |d: f64| format!("saves {:.1} % of the time", 100.0 * (1.0 - d / separate));
        r.information(JOINING, "joined between the speed minima, s", "", format!("{joined:.3}")).note(saves(joined));
        r.information(JOINING, "jerk-limited under all limits at once, s", "", format!("{least:.3}"))
            .note(saves(least));
    }
}
