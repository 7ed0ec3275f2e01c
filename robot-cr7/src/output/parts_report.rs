//! The report of a program in parts: totals, and the worst place of each limit over all of them.

use std::time::Duration;

use arcfeed_interp::{PathParameter, Trajectory, Verification};

use super::binding_line::BindingLine;
use super::compiled_report::CompiledReport;
use super::part_report::PartReport;
use super::program_report::{LineTime, ProgramReport, lines_from};
use super::report::{Report, SegmentCount};
use crate::run::joint_move::JointMove;
use crate::run::limit_line::{LimitLine, worst};
use crate::run::limit_lines::limit_lines;
use crate::run::program_motion::ProgramMotion;
use crate::run::program_part::{PartMotion, ProgramPart};
use crate::run::program_plan::CompiledProgram;
use crate::run::side_effects::VibrationLine;

impl<const N: usize> ProgramMotion<'_, N> {
    /// The report of the motion: `samples` of them were computed in `sampling`, and `check` is what a check of these says.
    pub fn report(&self, check: &Verification, samples: usize, sampling: Duration) -> Report {
        let motions = || self.parts().iter().filter_map(ProgramPart::trajectory);
        let planning_time_s = motions().map(|motion| motion.timings().planning().as_secs_f64()).sum();
        let verification_time_s = motions().map(|motion| motion.timings().verification.as_secs_f64()).sum();
        let sampling_time_s = sampling.as_secs_f64();
        let paths = || self.paths().map(|(_, path)| path.trajectory());
        let deviation = paths().filter_map(|path| Some(path.segmentation()?.max_deviation())).fold(0.0, f64::max);
        let outlines = self.paths().filter_map(|(_, path)| path.outline());
        Report {
            name: self.name().to_owned(),
            length_m: self.length(),
            duration_s: self.duration(),
            planner: self.planners(),
            fallback: None,
            planning_rounds: motions().map(|motion| motion.info().rounds).max().unwrap_or(1),
            planning_windows: motions().filter_map(|motion| Some(motion.info().windows.as_ref()?.count)).sum(),
            samples,
            period_s: self.period(),
            segments: self.segment_counts(),
            chord_tolerance_m: paths().map(|path| path.chord_tolerance()).fold(0.0, f64::max),
            max_deviation_m: deviation,
            planning_time_s,
            verification_time_s,
            sampling_time_s,
            motion_per_computing: self.duration() / (planning_time_s + verification_time_s + sampling_time_s),
            limits: self.limits(check),
            binding: self.bindings(),
            vibration: VibrationLine::most_of(self.paths().map(|(_, path)| path.vibration())),
            thermal: Vec::new(),
            bound: None,
            fit: None,
            program: Some(ProgramReport::joined(outlines, self.markers().cloned().collect())),
            parts: self.parts().iter().map(PartReport::new).collect(),
            compiled: None,
            stream: None,
            warnings: self.warnings().iter().cloned().chain(self.rests_between_windows()).collect(),
            files: Vec::new(),
        }
    }

    /// The lines of the file with their times, in order. A dwell is not among them.
    pub fn line_times(&self) -> Vec<LineTime> {
        let lines = self.parts().iter().flat_map(|part| {
            let from = [part.from(), part.begin()];
            match part.motion() {
                PartMotion::Path(motion) => motion.outline().map_or_else(Vec::new, |outline| {
                    let law = motion.trajectory().law();
                    lines_from(outline, from, |s| law.time_at_position(s))
                }),
                PartMotion::Joints(motion) => rapid_lines(motion, from),
                PartMotion::Dwell(_) => part.still().iter().map(|&(line, n)| still_line(line, n, from)).collect(),
            }
        });
        lines.collect()
    }

    /// The report of the compiled motion, made for `tolerance` (rad).
    pub fn compiled_report(&self, tolerance: f64, compiled: &CompiledProgram<N>) -> CompiledReport {
        let parts = compiled.moving.iter().filter_map(|(index, pieces, certificate)| {
            let part = self.parts().get(*index)?;
            Some((part.begin(), CompiledReport::new(tolerance, pieces, certificate)))
        });
        CompiledReport::of_parts(tolerance, &compiled.joints, self.joint_limits(), parts)
    }

    /// Where limits bind, by the way along the program.
    fn bindings(&self) -> Vec<BindingLine> {
        let mut all = Vec::new();
        for (part, path) in self.parts().iter().filter_map(|part| Some((part, part.trajectory()?))) {
            // The place on a path of the joints is no length.
            if path.path().parameter() == PathParameter::ArcLength {
                BindingLine::append(&mut all, BindingLine::of(path.verification().bindings(), part.from()));
            }
        }
        all
    }

    /// Every limit with its worst place over all parts and over the samples.
    fn limits(&self, check: &Verification) -> Vec<LimitLine> {
        let mut all = Vec::new();
        for part in self.parts() {
            let lines = match part.motion() {
                PartMotion::Path(motion) => motion.limits(),
                PartMotion::Joints(motion) => {
                    limit_lines(motion.trajectory().verification(), PathParameter::JointDistance)
                }
                PartMotion::Dwell(_) => continue,
            };
            for line in lines {
                merge(&mut all, placed(part, line));
            }
        }
        for mut line in limit_lines(check, PathParameter::JointDistance) {
            line.lines = self.part_at(line.at_t_s).map(|part| part.lines_at(line.at_t_s));
            merge(&mut all, line);
        }
        all
    }

    /// Words on the motions that rest on the way because of the windows in which they were planned.
    fn rests_between_windows(&self) -> impl Iterator<Item = String> + '_ {
        self.parts().iter().filter_map(|part| {
            let windows = part.trajectory()?.info().windows.as_ref().filter(|windows| !windows.stops.is_empty())?;
            Some(format!("the motion from {:.3} s on was planned in {windows}", part.begin()))
        })
    }

    /// The planners whose laws these are: that of the job, and those that took its place.
    fn planners(&self) -> String {
        let motions = || self.parts().iter().filter_map(ProgramPart::trajectory);
        let replaced = |motion: &&Trajectory<'_, N>| motion.info().method != Some(self.method());
        match (motions().find(replaced).and_then(|motion| motion.info().method), motions().filter(replaced).count()) {
            (Some(other), count) => format!("{}; {other} for {count} of {} motions", self.method(), motions().count()),
            (None, _) => self.method().to_string(),
        }
    }

    /// Segments of all paths by each method.
    fn segment_counts(&self) -> Vec<SegmentCount> {
        let mut all: Vec<SegmentCount> = Vec::new();
        for count in self.paths().flat_map(|(_, path)| path.segment_counts()) {
            match all.iter_mut().find(|other| other.method == count.method) {
                Some(other) => {
                    other.segments += count.segments;
                    other.max_deviation_m = other.max_deviation_m.max(count.max_deviation_m);
                }
                None => all.push(count),
            }
        }
        all
    }
}

/// A line of one part, at its time and place in the whole.
fn placed<const N: usize>(part: &ProgramPart<'_, N>, line: LimitLine) -> LimitLine {
    let lines = line.lines.or_else(|| Some(part.lines_at(part.begin() + line.at_t_s)));
    let (at_t_s, at_s_m) = (part.begin() + line.at_t_s, line.at_s_m.map(|s| part.from() + s));
    LimitLine { at_t_s, at_s_m, lines, ..line }
}

/// Keeps the worse one of two lines on the same limit.
fn merge(all: &mut Vec<LimitLine>, line: LimitLine) {
    let same = |other: &&mut LimitLine| (&other.name, other.joint, other.unit) == (&line.name, line.joint, line.unit);
    match all.iter_mut().find(same) {
        Some(other) => {
            // By place: a line whose ratio is not a number equals nothing, and is the worst.
            if worst([&*other, &line]).is_some_and(|worse| std::ptr::eq(worse, &line)) {
                *other = line;
            }
        }
        None => all.push(line),
    }
}

/// A rapid move in which nothing moves.
fn still_line(line: usize, n: Option<u32>, [s, t]: [f64; 2]) -> LineTime {
    let (s_from_m, s_to_m, t_from_s, t_to_s) = (s, s, t, t);
    LineTime { line: line.to_string(), n, s_from_m, s_to_m, t_from_s, t_to_s, feed_m_s: None, deviation_m: None }
}

/// The lines of rapid moves of the joints, with their times.
fn rapid_lines<const N: usize>(motion: &JointMove<'_, N>, [from_s, from_t]: [f64; 2]) -> Vec<LineTime> {
    let (mut s_from_m, mut t_from_s) = (from_s, from_t);
    let law = motion.trajectory().law();
    let line = |end: &crate::run::joint_move::Passed| {
        let line = LineTime {
            line: end.line.to_string(),
            n: end.number,
            s_from_m,
            s_to_m: from_s + motion.way_at(end.parameter),
            t_from_s,
            t_to_s: from_t + law.time_at_position(end.parameter),
            feed_m_s: None,
            deviation_m: Some(end.distance_m),
        };
        (s_from_m, t_from_s) = (line.s_to_m, line.t_to_s);
        line
    };
    motion.passed().iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::limit_line::LimitUnit;

    #[test]
    fn a_ratio_that_is_not_a_number_stays_the_worst() {
        let line = |ratio: f64| LimitLine {
            name: "joint jerk".to_owned(),
            joint: Some(1),
            unit: LimitUnit::RadianPerSecond3,
            value: ratio,
            limit: 1.0,
            ratio,
            at_s_m: None,
            at_t_s: 0.0,
            lines: None,
        };
        for order in [[0.5, f64::NAN, 0.9], [f64::NAN, 0.5, 0.9], [0.5, 0.9, f64::NAN]] {
            let mut all = Vec::new();
            order.into_iter().for_each(|ratio| merge(&mut all, line(ratio)));
            assert!(all.len() == 1 && !all[0].holds(), "{order:?}: {all:?}");
        }
    }
}
