//! Motion generated cycle by cycle, towards targets and within limits that change on the way.

use arcfeed_feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{OnlineGenerator as Inner, SyncError};
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::array::Table;
use crate::axes::{self, for_axes};
use crate::error::{input, undone};
use crate::online_step::{OnlineStep, values};

/// A generator without its number of axes. Lists have a value an axis.
trait Generator: Send + Sync {
    fn axes(&self) -> usize;
    fn set(&mut self, target: Option<&[AxisState]>, limits: Option<&[AxisLimits]>) -> Result<(), SyncError>;
    fn set_axis_target(&mut self, axis: usize, target: AxisState) -> Result<(), SyncError>;
    fn set_axis_limits(&mut self, axis: usize, limits: AxisLimits) -> Result<(), SyncError>;
    fn step(&mut self) -> OnlineStep;
    fn stop(&mut self) -> Result<(), SyncError>;
    fn stop_on_path(&mut self);
    fn jog(&mut self, velocity: &[f64], timeout: f64) -> Result<(), SyncError>;
    fn set_scale(&mut self, scale: f64) -> Result<(), SyncError>;
    fn hold(&mut self);
    fn resume(&mut self);
    fn state(&self) -> &[AxisState];
    fn target(&self) -> &[AxisState];
    fn is_underway(&self) -> bool;
    fn time_left(&self) -> f64;
    fn scale(&self) -> f64;
    fn is_held(&self) -> bool;
}

impl<const N: usize> Generator for Inner<N> {
    fn axes(&self) -> usize {
        N
    }

    fn set(&mut self, target: Option<&[AxisState]>, limits: Option<&[AxisLimits]>) -> Result<(), SyncError> {
        match (target, limits) {
            (Some(target), Some(limits)) => Self::set(self, axes::of(target), axes::of(limits)),
            (Some(target), None) => self.set_target(axes::of(target)),
            (None, Some(limits)) => self.set_limits(axes::of(limits)),
            (None, None) => Ok(()),
        }
    }

    fn set_axis_target(&mut self, axis: usize, target: AxisState) -> Result<(), SyncError> {
        Self::set_axis_target(self, axis, target)
    }

    fn set_axis_limits(&mut self, axis: usize, limits: AxisLimits) -> Result<(), SyncError> {
        Self::set_axis_limits(self, axis, limits)
    }

    fn step(&mut self) -> OnlineStep {
        let step = Self::step(self);
        let events = step.events;
        OnlineStep {
            values: values(&step.state),
            reached: events.reached,
            replanned: events.replanned,
            outside_limits: events.outside_limits,
            arrived: events.arrived.to_vec(),
            range_ends: events.range_ends.to_vec(),
        }
    }

    fn stop(&mut self) -> Result<(), SyncError> {
        Self::stop(self)
    }

    fn stop_on_path(&mut self) {
        Self::stop_on_path(self);
    }

    fn jog(&mut self, velocity: &[f64], timeout: f64) -> Result<(), SyncError> {
        Self::jog(self, axes::of(velocity), timeout)
    }

    fn set_scale(&mut self, scale: f64) -> Result<(), SyncError> {
        Self::set_scale(self, scale)
    }

    fn hold(&mut self) {
        Self::hold(self);
    }

    fn resume(&mut self) {
        Self::resume(self);
    }

    fn state(&self) -> &[AxisState] {
        Self::state(self)
    }

    fn target(&self) -> &[AxisState] {
        Self::target(self)
    }

    fn is_underway(&self) -> bool {
        Self::is_underway(self)
    }

    fn time_left(&self) -> f64 {
        Self::time_left(self)
    }

    fn scale(&self) -> f64 {
        Self::scale(self)
    }

    fn is_held(&self) -> bool {
        Self::is_held(self)
    }
}

/// Generates the motion of 1 to 10 axes one control cycle at a time, towards targets and within limits that may change at any cycle.
///
/// start: list of rows, position alone or with velocity and acceleration, a number an axis; it is the target until one is set.
/// velocity, acceleration, jerk: greatest magnitudes, a number an axis. cycle: control cycle, s. synchronisation: "time" (all axes
/// arrive together), "none", "straight" (on the line where that is possible) or "forced-straight". ranges: lower and upper end of each axis,
/// which no position leaves.
///
/// A plan starts in the state of the last step, so that position, velocity and acceleration never jump. An argument that cannot be used (a
/// wrong count, an axis that there is not, a limit that is not above 0) raises InputError, what cannot be done within limits and ranges PlanError;
/// both change nothing. Arguments count axes from 0, the texts of errors from 1.
#[pyclass(module = "arcfeed")]
pub struct OnlineGenerator {
    inner: Box<dyn Generator>,
    /// A jog or a stop whose end is still to come.
    ending: bool,
    /// The scale that was set is 0.
    paused: bool,
}

/// Most cycles of one run: 32 MB an axis.
const MOST_CYCLES: i64 = 1_000_000;

/// Cycles between two looks at the signals.
const CYCLES_A_LOOK: i64 = 4096;

impl OnlineGenerator {
    fn states(&self, rows: &[Vec<f64>]) -> PyResult<Vec<AxisState>> {
        axes::states("target", rows, self.inner.axes(), "the generator has")
    }

    fn limits(&self, velocity: &[f64], acceleration: &[f64], jerk: &[f64]) -> PyResult<Vec<AxisLimits>> {
        self.one_an_axis("velocity", velocity)?;
        axes::limits(velocity, acceleration, jerk)
    }

    fn axis(&self, axis: i64) -> PyResult<usize> {
        let axes = self.inner.axes();
        usize::try_from(axis)
            .ok()
            .filter(|&axis| axis < axes)
            .ok_or_else(|| input(format!("axis is {axis}: there are {axes}, counted from 0; give 0 to {}", axes - 1)))
    }

    /// One cycle, with the note of what has ended in it.
    fn advance(&mut self) -> OnlineStep {
        let step = self.inner.step();
        self.ending &= !step.reached;
        step
    }

    /// Returns true if cycles alone bring nothing nearer its end.
    fn has_nothing_to_do(&self) -> bool {
        let stands = || self.inner.state().iter().all(|s| s.v == 0.0 && s.a == 0.0);
        let is_held = (self.inner.is_held() || self.paused) && self.inner.scale() == 0.0 && stands();
        !self.ending && (is_held || !self.inner.is_underway())
    }

    fn one_an_axis(&self, what: &str, values: &[f64]) -> PyResult<()> {
        match (values.len(), self.inner.axes()) {
            (given, axes) if given == axes => Ok(()),
            (given, axes) => Err(input(format!("{what} lists {given} numbers: give one for each of the {axes} axes"))),
        }
    }
}

/// A refused command.
pub fn refused(error: SyncError) -> PyErr {
    undone("other", error)
}

#[pymethods]
impl OnlineGenerator {
    #[new]
    #[pyo3(signature = (start, velocity, acceleration, jerk, cycle, *, synchronisation="time", ranges=None))]
    fn new(
        start: Vec<Vec<f64>>,
        velocity: Vec<f64>,
        acceleration: Vec<f64>,
        jerk: Vec<f64>,
        cycle: f64,
        synchronisation: &str,
        ranges: Option<Vec<(f64, f64)>>,
    ) -> PyResult<Self> {
        let axes = velocity.len();
        let start = axes::states("start", &start, axes, "velocity has")?;
        let limits = axes::limits(&velocity, &acceleration, &jerk)?;
        let synchronisation = axes::synchronisation(synchronisation)?;
        if let Some(ranges) = ranges.as_ref().filter(|ranges| ranges.len() != axes) {
            return Err(input(format!("ranges lists {}, and velocity {axes}: give one an axis", ranges.len())));
        }
        for_axes!(axes, N => {
            let made = Inner::<N>::new(axes::of(&start), axes::of(&limits), cycle, synchronisation).map_err(input)?;
            let made = match &ranges {
                Some(ranges) => made.with_ranges(axes::of(ranges)).map_err(input)?,
                None => made,
            };
            Ok(Self { inner: Box::new(made), ending: false, paused: false })
        })
    }

    /// Sets the state to reach: rows as of start.
    fn set_target(&mut self, target: Vec<Vec<f64>>) -> PyResult<()> {
        let target = self.states(&target)?;
        self.inner.set(Some(&target), None).map_err(refused)?;
        self.ending = false;
        Ok(())
    }

    /// Sets the limits: greatest magnitudes, a number an axis. A state outside is brought back inside.
    fn set_limits(&mut self, velocity: Vec<f64>, acceleration: Vec<f64>, jerk: Vec<f64>) -> PyResult<()> {
        let limits = self.limits(&velocity, &acceleration, &jerk)?;
        self.inner.set(None, Some(&limits)).map_err(refused)
    }

    /// Sets target and limits at once, for a target that the limits so far do not permit.
    fn set(
        &mut self,
        target: Vec<Vec<f64>>,
        velocity: Vec<f64>,
        acceleration: Vec<f64>,
        jerk: Vec<f64>,
    ) -> PyResult<()> {
        let target = self.states(&target)?;
        let limits = self.limits(&velocity, &acceleration, &jerk)?;
        self.inner.set(Some(&target), Some(&limits)).map_err(refused)?;
        self.ending = false;
        Ok(())
    }

    /// Sets the target of one axis, counted from 0.
    #[pyo3(signature = (axis, position, velocity=0.0, acceleration=0.0))]
    fn set_axis_target(&mut self, axis: i64, position: f64, velocity: f64, acceleration: f64) -> PyResult<()> {
        let target = AxisState::new(position, velocity, acceleration);
        self.inner.set_axis_target(self.axis(axis)?, target).map_err(refused)?;
        self.ending = false;
        Ok(())
    }

    /// Sets the limits of one axis, counted from 0.
    fn set_axis_limits(&mut self, axis: i64, velocity: f64, acceleration: f64, jerk: f64) -> PyResult<()> {
        let axis = self.axis(axis)?;
        let limits = axes::axis_limits(axis, velocity, acceleration, jerk)?;
        self.inner.set_axis_limits(axis, limits).map_err(refused)
    }

    /// Moves on by one cycle.
    fn step(&mut self) -> OnlineStep {
        self.advance()
    }

    /// Moves on until the target is reached or a stop or jog has ended, by at most so many cycles (up to 1 000 000): positions, velocities,
    /// accelerations and jerks, four arrays (cycles, axes). One call in place of many, where nothing changes on the way.
    ///
    /// It ends, too, once the axes rest because of hold() or scale 0. Where nothing is underway the arrays have no rows: axes that go on with the
    /// velocity of a target that was reached, or of the start, move by step() alone. A signal (Ctrl-C) ends it with its
    /// exception; state is where the axes are then.
    fn run<'py>(&mut self, py: Python<'py>, most_cycles: i64) -> PyResult<[Bound<'py, PyArray2<f64>>; 4]> {
        if !(0..=MOST_CYCLES).contains(&most_cycles) {
            return Err(input(format!(
                "most_cycles is {most_cycles}: give 0 to {MOST_CYCLES}, and call run again for what is left"
            )));
        }
        let axes = self.inner.axes();
        let tables = py.detach(|| {
            let mut tables: [Table; 4] = std::array::from_fn(|_| Table::new(axes, 0));
            for cycle in 1..=most_cycles {
                if self.has_nothing_to_do() {
                    break;
                }
                let step = self.advance();
                for (table, values) in tables.iter_mut().zip(&step.values) {
                    table.push(values);
                }
                if step.reached {
                    break;
                }
                if cycle % CYCLES_A_LOOK == 0 {
                    Python::attach(|py| py.check_signals())?;
                }
            }
            Ok::<_, PyErr>(tables)
        })?;
        let [q, qd, qdd, jerk] = &tables;
        Ok([q.to_array(py)?, qd.to_array(py)?, qdd.to_array(py)?, jerk.to_array(py)?])
    }

    /// Brings every axis to rest in the shortest way of its own, and gives up the targets.
    fn stop(&mut self) -> PyResult<()> {
        self.inner.stop().map_err(refused)?;
        self.ending = true;
        Ok(())
    }

    /// Brings all axes to rest on the curve of their plan, and gives up the targets.
    fn stop_on_path(&mut self) {
        self.inner.stop_on_path();
        self.ending = true;
    }

    /// Moves the axes at velocities, a number an axis, until timeout (s) is over; then they stop. Another call renews the time.
    fn jog(&mut self, velocity: Vec<f64>, timeout: f64) -> PyResult<()> {
        self.one_an_axis("velocity", &velocity)?;
        self.inner.jog(&velocity, timeout).map_err(refused)?;
        self.ending = true;
        Ok(())
    }

    /// Brings the scale of time to 0: the axes rest on their curve until resume.
    fn hold(&mut self) {
        self.inner.hold();
    }

    /// Ends a hold.
    fn resume(&mut self) {
        self.inner.resume();
    }

    /// The scale of time, from 0 to 1.5; what is set is reached within the limits.
    #[getter]
    fn scale(&self) -> f64 {
        self.inner.scale()
    }

    #[setter]
    fn set_scale(&mut self, scale: f64) -> PyResult<()> {
        self.inner.set_scale(scale).map_err(refused)?;
        self.paused = scale == 0.0;
        Ok(())
    }

    /// True from hold until resume.
    #[getter]
    fn is_held(&self) -> bool {
        self.inner.is_held()
    }

    /// The state of the last step: position, velocity, acceleration (3, axes).
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        axes::state_array(py, self.inner.state())
    }

    /// The state to reach (3, axes).
    #[getter]
    fn target<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        axes::state_array(py, self.inner.target())
    }

    /// True if an axis has still to reach its target.
    #[getter]
    fn is_underway(&self) -> bool {
        self.inner.is_underway()
    }

    /// Time until the last axis has reached its target at scale 1, s.
    #[getter]
    fn time_left(&self) -> f64 {
        self.inner.time_left()
    }

    fn __repr__(&self) -> String {
        format!("OnlineGenerator({} axes, {:.4} s left)", self.inner.axes(), self.inner.time_left())
    }
}
