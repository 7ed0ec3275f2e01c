//! The planners of a task.

use arcfeed_interp::{JointTables, Limits, PathArm, PlanError, Planner, ToolLimits};

use super::error::Cr7Error;
use super::task::Task;
use super::task_limits::TaskLimits;

impl<A: PathArm<N>, const N: usize> Task<A, N> {
    /// The planner with all limits of the job.
    ///
    /// # Errors
    /// [`Cr7Error::Plan`] for a limit that cannot be used.
    pub fn planner(&self) -> Result<Planner<'_, N>, Cr7Error> {
        self.planner_beside(&self.limits, &self.limits.tables)
    }

    /// The limits of the job.
    pub(crate) fn own_limits(&self) -> &TaskLimits<N> {
        &self.limits
    }

    /// The planner with other limits, of motions that are compared by their durations: they are not slowed down to whole cycles.
    ///
    /// # Errors
    /// As [`Task::planner`].
    pub(crate) fn planner_within<'t>(&'t self, limits: &'t TaskLimits<N>) -> Result<Planner<'t, N>, Cr7Error> {
        self.planner_between(limits, &limits.tables)
    }

    /// What is said where [`Task::planner_within`] leaves out whole cycles that the job asks for.
    pub(crate) fn unrounded_words(&self) -> Option<String> {
        let words =
            "durations are compared as they are before sampling.whole_cycles rounds them up to whole control periods";
        self.whole_cycles.then(|| words.to_owned())
    }

    /// The planner with other limits, and with tables from elsewhere in place of its own.
    ///
    /// # Errors
    /// As [`Task::planner`].
    pub(crate) fn planner_beside<'t>(
        &'t self,
        limits: &TaskLimits<N>,
        tables: &'t JointTables<N>,
    ) -> Result<Planner<'t, N>, Cr7Error> {
        self.planner_between(limits, tables).map(|planner| self.in_cycles(planner))
    }

    fn planner_between<'t>(
        &'t self,
        limits: &TaskLimits<N>,
        tables: &'t JointTables<N>,
    ) -> Result<Planner<'t, N>, Cr7Error> {
        let [v_start, v_end] = self.end_speeds;
        let planner = self.planner_under(limits, tables).and_then(|planner| planner.with_end_speeds(v_start, v_end));
        Ok(planner.map_err(|source| self.error(source))?.with_sections(limits.sections.clone()))
    }

    /// The planner of joint moves from rest to rest: with the limits of the joints and of their torque, and with that of the angular
    /// speed of the tool.
    pub(crate) fn joint_planner(&self) -> Result<Planner<'_, N>, PlanError> {
        let tool = match self.limits.tool.angular_speed() {
            Some(speed) => ToolLimits::new().with_angular_speed(speed)?,
            None => ToolLimits::new(),
        };
        let planner = self.planner_under(&TaskLimits { tool, ..self.limits.clone() }, &self.limits.tables)?;
        Ok(self.in_cycles(planner))
    }

    /// The planner with whole cycles where the job asks for them.
    fn in_cycles<'t>(&self, planner: Planner<'t, N>) -> Planner<'t, N> {
        if self.whole_cycles { planner.with_whole_cycles() } else { planner }
    }

    fn planner_under<'t>(
        &'t self,
        within: &TaskLimits<N>,
        tables: &'t JointTables<N>,
    ) -> Result<Planner<'t, N>, PlanError> {
        let mut limits = Limits::new(within.joints).with_tool(within.tool).with_tables(tables);
        if let (Some(drives), Some(torque)) = (&self.drives, within.torque) {
            limits = limits.with_torque(&drives.dynamics, torque)?;
        }
        let planner = Planner::new(&self.arm, limits).with_chord_tolerance(self.chord_tolerance)?;
        Ok(planner.with_period(self.period)?.with_method(self.method))
    }
}
