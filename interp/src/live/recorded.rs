//! The check of a motion along a path that was changed, left or resumed while it ran.

use super::live_path::LivePath;
use crate::setpoint::Setpoint;
use crate::verify::{Requirement, Sample, Tally, Verification};

/// On the path the tool is nearer to it than this, m: what is left to rounding.
const ON_PATH: f64 = 1e-9;

impl<const N: usize> LivePath<'_, N> {
    /// Holds the recorded setpoints of a motion, one a control period, against every limit: those of
    /// the joints all the time, those of the tool while it is on the path.
    ///
    /// `start` is the setpoint before the first cycle; the motion is at rest there and after the
    /// last. Each cycle comes with whether the tool is on the path at its end. Times that are not one
    /// control period apart count as a setpoint that does not agree with itself.
    pub fn verify<'s>(
        &self,
        start: &Setpoint<N>,
        cycles: impl IntoIterator<Item = (&'s Setpoint<N>, bool)>,
    ) -> Verification {
        let requirement = Requirement {
            arm: self.path().arm(),
            path: self.path(),
            limits: self.problem().limits(),
            jerk_limited: true,
            chord_tolerance: self.chord_tolerance(),
            path_tolerance: ON_PATH,
            period: self.period(),
            sections: &[],
            end_speeds: [0.0; 2],
        };
        let mut tally = Tally::new(&requirement);
        let mut before = Sample::new(&requirement, *start);
        let (mut was_on_path, mut samples) = (true, 1);
        tally.look(&before);
        tally.end(&before, start.s, 0.0);
        for (setpoint, on_path) in cycles {
            let sample = Sample::new(&requirement, *setpoint);
            samples += 1;
            tally.look_at_clock((sample.at.t - before.at.t) / self.period() - 1.0, &sample);
            if on_path {
                tally.look(&sample);
            } else {
                tally.look_at_joints(&sample);
            }
            if on_path && was_on_path {
                tally.compare([&before, &before, &sample], self.period());
                let middle = self.path().pose_path().curve().point(0.5 * (before.at.s + sample.at.s));
                tally.chord_at(middle, [&before, &sample]);
            } else {
                tally.compare_joints([&before, &before, &sample], self.period(), false);
            }
            (before, was_on_path) = (sample, on_path);
        }
        tally.end(&before, before.at.s, 0.0);
        tally.finish(samples)
    }
}
