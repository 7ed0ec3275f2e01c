//! A planned and verified motion.

use std::time::Instant;

use arcfeed_feedrate::SpeedLaw;
use arcfeed_interp::{JointTrajectory as Pieces, LimitPoint, MotionCertificate, Setpoint};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_cr7::{
    BoundReport, CompiledProgram, CompiledReport, LimitsHold, PartMotion, ProgramMotion, ProgramReport, Report,
    ReportHead, TrajectoryRow,
};

use crate::array::Table;
use crate::compiled::JointTrajectory;
use crate::error::undone;

/// The samples of a motion, a row each.
struct Samples {
    t: Vec<f64>,
    s: Vec<f64>,
    feed: Vec<f64>,
    joints: [Table; 4],
    position: Table,
    quaternion: Table,
}

impl Samples {
    fn new(joints: usize, rows: usize) -> Self {
        let vector = || Vec::with_capacity(rows);
        Self {
            t: vector(),
            s: vector(),
            feed: vector(),
            joints: std::array::from_fn(|_| Table::new(joints, rows)),
            position: Table::new(3, rows),
            quaternion: Table::new(4, rows),
        }
    }

    fn push<const N: usize>(&mut self, row: &TrajectoryRow<N>, s: f64, feed: f64) {
        self.t.push(row.t);
        self.s.push(s);
        self.feed.push(feed);
        for (table, values) in self.joints.iter_mut().zip([row.q, row.qd, row.qdd, row.jerk]) {
            table.push(&values);
        }
        self.position.push(&row.position);
        self.quaternion.push(&row.quaternion);
    }
}

/// All that is kept of a motion: plain data, without path and arm.
pub struct PlanData {
    joint_names: Vec<String>,
    duration: f64,
    period: f64,
    samples: Samples,
    report: Report,
    law: Table,
    limit_curve: Table,
    compiled: Option<JointTrajectory>,
}

/// Refuses a motion that exceeds a limit.
fn held(report: &Report) -> PyResult<()> {
    LimitsHold::of(&report.limits).map(drop).map_err(|error| undone("unverified", error))
}

fn failed(error: impl std::fmt::Display) -> PyErr {
    undone("other", error)
}

/// Time, place, speed and acceleration at the knots of a law, its end included; times and places count from `from`.
fn knots(law: &SpeedLaw, from: [f64; 2], table: &mut Table) {
    for (t, state) in law.knots().chain([(law.duration(), law.end())]) {
        table.push(&[from[0] + t, from[1] + state.p, state.v, state.a]);
    }
}

fn curve(points: &[LimitPoint], from: f64, table: &mut Table) {
    points.iter().for_each(|point| table.push(&[from + point.s, point.speed]));
}

impl PlanData {
    /// Of the motion along one path.
    ///
    /// # Errors
    /// Where the lower bound is asked for and there is none.
    pub fn of_motion<const N: usize>(
        motion: &robot_cr7::Motion<'_, N>,
        compiled: Option<(f64, Pieces<N>, MotionCertificate)>,
        names: &[String],
        bound: bool,
    ) -> PyResult<Self> {
        let plan = motion.trajectory();
        let bound = match bound {
            true => Some(BoundReport::new(plan.duration(), &plan.lower_bound().map_err(failed)?)),
            false => None,
        };
        let begin = Instant::now();
        let setpoints = motion.setpoints().map_err(failed)?;
        let mut samples = Samples::new(N, setpoints.samples());
        for setpoint in setpoints {
            let at: Setpoint<N> = setpoint.map_err(failed)?;
            samples.push(&TrajectoryRow::from(&at), at.s, at.feed);
        }
        let mut report = motion.report(samples.t.len(), begin.elapsed());
        held(&report)?;
        let (mut law, mut limit_curve) = (Table::new(4, 0), Table::new(2, 0));
        knots(plan.law(), [0.0, 0.0], &mut law);
        curve(&plan.limit_curve().map_err(failed)?, 0.0, &mut limit_curve);
        report.bound = bound;
        report.program = motion.outline().map(|outline| ProgramReport::new(outline, &samples.t, &samples.s));
        let compiled = compiled.map(|(tolerance, pieces, certificate)| {
            report.compiled = Some(CompiledReport::new(tolerance, &pieces, &certificate));
            JointTrajectory::of(pieces, names)
        });
        let (duration, period) = (plan.duration(), plan.period());
        Ok(Self { joint_names: names.to_vec(), duration, period, samples, report, law, limit_curve, compiled })
    }

    /// Of the motion of a program.
    ///
    /// # Errors
    /// Where a part cannot be sampled.
    pub fn of_program<const N: usize>(
        motion: &ProgramMotion<'_, N>,
        compiled: Option<(f64, CompiledProgram<N>)>,
        names: &[String],
        at_rest: bool,
    ) -> PyResult<Self> {
        let begin = Instant::now();
        let sampler = motion.samples().map_err(failed)?;
        let mut samples = Samples::new(N, sampler.len());
        let mut check = motion.check();
        for sample in sampler {
            let sample = sample.map_err(failed)?;
            check.see(&sample.row);
            samples.push(&sample.row, sample.s, sample.feed);
        }
        let check = check.finish(at_rest);
        let mut report = motion.report(&check, samples.t.len(), begin.elapsed());
        held(&report)?;
        let (mut law, mut limit_curve) = (Table::new(4, 0), Table::new(2, 0));
        for part in motion.parts() {
            if let PartMotion::Path(path) = part.motion() {
                let plan = path.trajectory();
                knots(plan.law(), [part.begin(), part.from()], &mut law);
                curve(&plan.limit_curve().map_err(failed)?, part.from(), &mut limit_curve);
            }
        }
        let compiled = compiled.map(|(tolerance, compiled)| {
            report.compiled = Some(motion.compiled_report(tolerance, &compiled));
            JointTrajectory::of(compiled.joints, names)
        });
        let (duration, period) = (motion.duration(), motion.period());
        Ok(Self { joint_names: names.to_vec(), duration, period, samples, report, law, limit_curve, compiled })
    }
}

/// A planned and verified motion: samples at the control period, the speed law, the report.
///
/// n is the number of samples, N that of the joints. The last sample is exactly at the end.
#[pyclass(module = "arcfeed", frozen)]
pub struct Motion {
    head: ReportHead,
    data: PlanData,
}

impl Motion {
    pub(crate) fn new(head: ReportHead, data: PlanData) -> Self {
        Self { head, data }
    }
}

#[pymethods]
impl Motion {
    /// Duration, s.
    #[getter]
    fn duration(&self) -> f64 {
        self.data.duration
    }

    /// Control period, s.
    #[getter]
    fn period(&self) -> f64 {
        self.data.period
    }

    /// Names of the joints.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.data.joint_names.clone()
    }

    /// Times, s (n,).
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.data.samples.t)
    }

    /// Way of the tool, m (n,).
    #[getter]
    fn s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.data.samples.s)
    }

    /// Speed of the tool, m/s (n,).
    #[getter]
    fn feed<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.data.samples.feed)
    }

    /// Joint positions, rad (n, N).
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.data.samples.joints[0].to_array(py)
    }

    /// Joint velocities, rad/s (n, N).
    #[getter]
    fn qd<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.data.samples.joints[1].to_array(py)
    }

    /// Joint accelerations, rad/s^2 (n, N).
    #[getter]
    fn qdd<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.data.samples.joints[2].to_array(py)
    }

    /// Joint jerks, rad/s^3 (n, N).
    #[getter]
    fn jerk<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.data.samples.joints[3].to_array(py)
    }

    /// Tool tip in the base frame, m (n, 3).
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.data.samples.position.to_array(py)
    }

    /// Tool orientation in the base frame, quaternions x, y, z, w (n, 4).
    #[getter]
    fn quaternion<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.data.samples.quaternion.to_array(py)
    }

    /// Knots of the speed law: time (s), place (m), speed (m/s), acceleration (m/s^2), a row each.
    #[getter]
    fn law<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.data.law.to_array(py)
    }

    /// Greatest speed at constant speed over the path: place (m) and speed (m/s), a row each.
    #[getter]
    fn limit_curve<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.data.limit_curve.to_array(py)
    }

    /// The report as a dict: durations, limits with their worst places, warnings. SI units.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        Ok(py.import("json")?.call_method1("loads", (self.head.json(&self.data.report),))?.cast_into()?)
    }

    /// The report as text.
    #[getter]
    fn summary(&self) -> String {
        self.data.report.to_string()
    }

    /// What a person should know, such as an assumption about the arm.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.data.report.warnings.clone()
    }

    /// The joints as polynomials of the time, if compile_rad was given.
    #[getter]
    fn compiled(&self) -> Option<JointTrajectory> {
        self.data.compiled.clone()
    }

    /// Draws feed, joint velocities and the path with matplotlib; the figure.
    #[pyo3(signature = (file=None))]
    fn plot<'py>(slf: Bound<'py, Self>, file: Option<std::path::PathBuf>) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        py.import("arcfeed.plotting")?.call_method1("plot", (slf, file))
    }

    fn __repr__(&self) -> String {
        let report = &self.data.report;
        format!("Motion({:?}, {:.4} s, {} samples)", report.name, self.data.duration, self.data.samples.t.len())
    }
}
