//! Samples of the motion of a program, on one grid of control periods.

use arcfeed_interp::{LimitError, PlanError, Setpoints};
use arcfeed_kinematics::{ForwardKinematics, Joints};

use super::program_motion::ProgramMotion;
use super::program_part::{PartMotion, ProgramPart};
use super::samples::sample_times;
use super::trajectory_row::TrajectoryRow;

/// One sample of the motion of a program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProgramSample<const N: usize = 6> {
    /// Joints and tool.
    pub row: TrajectoryRow<N>,
    /// Index of the part.
    pub part: usize,
    /// The way of the tool so far, m.
    pub s: f64,
    /// Speed of the tool, m/s.
    pub feed: f64,
}

/// Yields the samples of a program, one for each control period and one exactly at the end.
///
/// Parts take as long as they take: the first sample of a part is where the grid of the whole motion meets it.
#[derive(Debug)]
pub struct ProgramSamples<'m, 't, const N: usize = 6> {
    motion: &'m ProgramMotion<'t, N>,
    /// Number of samples in all, and of the next one.
    count: usize,
    next: usize,
    part: usize,
    /// Setpoints of the present part, where it moves.
    setpoints: Option<Setpoints<'m, 't, N>>,
}

impl<'t, const N: usize> ProgramMotion<'t, N> {
    /// Samples at the job's control period, start and end included.
    ///
    /// # Errors
    /// Never for a motion that was planned; the signature is that of
    /// [`Trajectory::setpoints`](arcfeed_interp::Trajectory::setpoints).
    pub fn samples(&self) -> Result<ProgramSamples<'_, 't, N>, LimitError> {
        let count = sample_times(self.duration(), self.period()).len();
        let mut samples = ProgramSamples { motion: self, count, next: 0, part: 0, setpoints: None };
        samples.begin_part()?;
        Ok(samples)
    }
}

impl<'t, const N: usize> ProgramSamples<'_, 't, N> {
    fn begin_part(&mut self) -> Result<(), LimitError> {
        let trajectory = self.motion.parts().get(self.part).and_then(ProgramPart::trajectory);
        self.setpoints = trajectory.map(|trajectory| trajectory.setpoints(self.motion.period())).transpose()?;
        Ok(())
    }

    fn at(&mut self, t: f64) -> Result<Option<ProgramSample<N>>, PlanError> {
        while self.motion.parts().get(self.part).is_some_and(|part| part.end() < t)
            && self.part + 1 < self.motion.parts().len()
        {
            self.part += 1;
            self.begin_part()?;
        }
        let Some(part) = self.motion.parts().get(self.part) else { return Ok(None) };
        let arm = self.motion.arm();
        // At its end the difference may be a rounding less than the duration, where some laws still brake.
        let own = if t >= part.end() { part.duration() } else { t - part.begin() };
        let (row, s, feed) = match (part.motion(), &mut self.setpoints) {
            (PartMotion::Path(_), Some(setpoints)) => {
                let at = setpoints.at(own)?;
                (TrajectoryRow { t, ..TrajectoryRow::from(&at) }, at.s, at.feed)
            }
            (PartMotion::Joints(motion), Some(setpoints)) => {
                let at = setpoints.at(own)?;
                let velocity = arm.jacobian(&at.q) * at.qd;
                let speed = velocity.fixed_rows::<3>(0).norm();
                (TrajectoryRow { t, ..TrajectoryRow::from(&at) }, motion.way_at(at.s), speed)
            }
            _ => (resting(t, part, arm), 0.0, 0.0),
        };
        Ok(Some(ProgramSample { row, part: self.part, s: part.from() + s, feed }))
    }
}

/// A row at rest.
fn resting<const N: usize>(t: f64, part: &ProgramPart<'_, N>, arm: &dyn ForwardKinematics<N>) -> TrajectoryRow<N> {
    let (q, zero) = (ProgramMotion::rest(part).unwrap_or_else(Joints::zeros), Joints::zeros());
    TrajectoryRow::new(t, [&q, &zero, &zero, &zero], &arm.forward(&q))
}

impl<const N: usize> Iterator for ProgramSamples<'_, '_, N> {
    type Item = Result<ProgramSample<N>, PlanError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.next == self.count {
            return None;
        }
        self.next += 1;
        let last = self.next == self.count;
        let t = if last { self.motion.duration() } else { (self.next - 1) as f64 * self.motion.period() };
        self.at(t).transpose()
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let rest = self.count - self.next;
        (rest, Some(rest))
    }
}

impl<const N: usize> ExactSizeIterator for ProgramSamples<'_, '_, N> {}
