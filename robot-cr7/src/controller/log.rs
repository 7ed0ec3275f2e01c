//! What was asked of an arm, and what came back.

use std::io::{self, Write};

use arcfeed_kinematics::Joints;

use super::arm_state::{ArmMode, ArmState};
use super::feedback::FEEDBACK_PERIOD;

/// Time before and after the motion for which there is room, s.
const MARGIN: f64 = 20.0;
/// Time for which there is room besides where somebody may hold the motion, s.
const HOLDS: f64 = 600.0;

/// One state of the arm beside the setpoint in force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SendRow<const N: usize = 6> {
    /// The time at which the state came, s.
    pub t: f64,
    /// The setpoint that was sent last, rad.
    pub sent: Joints<N>,
    /// Actual positions, rad.
    pub actual: Joints<N>,
    /// Actual velocities, rad/s.
    pub velocity: Joints<N>,
    /// Positions that the controller asked of its drives, rad.
    pub target: Joints<N>,
    /// What the arm did.
    pub mode: ArmMode,
}

/// The rows of one session. They are held in memory that is taken before the motion begins.
#[derive(Debug, Clone)]
pub struct SendLog<const N: usize = 6> {
    rows: Vec<SendRow<N>>,
    most: usize,
    begin: Option<f64>,
    missed: usize,
}

impl<const N: usize> SendLog<N> {
    /// Room for the states of a motion of `seconds`.
    pub fn new(seconds: f64) -> Self {
        let most = ((seconds + MARGIN) / FEEDBACK_PERIOD) as usize;
        Self { rows: Vec::with_capacity(most), most, begin: None, missed: 0 }
    }

    /// Room for the states of a motion of `seconds` that is held for up to ten minutes on the way.
    pub fn with_holds(seconds: f64) -> Self {
        Self::new(seconds + HOLDS)
    }

    /// Says that there was no room for some states, and how long those last that are there; `None` if all are there.
    pub fn bound(&self) -> Option<String> {
        let last = self.rows.last().filter(|_| self.missed > 0)?;
        let (missed, t) = (self.missed, last.t);
        Some(format!(
            "the log ends after {t:.1} s, as its memory is taken beforehand: {missed} states that came later are not in it"
        ))
    }

    /// Adds a state that came at time `now`, s, beside the setpoint in force. It does not allocate: where the room ends, it counts.
    pub fn see(&mut self, now: f64, sent: &Joints<N>, state: &ArmState<N>) {
        if self.rows.len() >= self.most {
            self.missed += 1;
            return;
        }
        let t = now - *self.begin.get_or_insert(now);
        let (actual, velocity, target) = (state.q, state.qd, state.q_target);
        self.rows.push(SendRow { t, sent: *sent, actual, velocity, target, mode: state.mode });
    }

    /// The rows.
    pub fn rows(&self) -> &[SendRow<N>] {
        &self.rows
    }

    /// The number of states for which there was no room.
    pub fn missed(&self) -> usize {
        self.missed
    }

    /// Writes the rows as CSV: `t_s`, then for each joint `sent1_rad`, `actual1_rad`, `actual1_rad_s`, `target1_rad` and so on, and
    /// `mode`.
    ///
    /// # Errors
    /// Those of the file.
    pub fn write_csv(&self, file: impl Write) -> io::Result<()> {
        let mut out = io::BufWriter::new(file);
        write!(out, "t_s")?;
        for (name, unit) in [("sent", "rad"), ("actual", "rad"), ("actual", "rad_s"), ("target", "rad")] {
            (1..=N).try_for_each(|k| write!(out, ",{name}{k}_{unit}"))?;
        }
        writeln!(out, ",mode")?;
        for row in &self.rows {
            write!(out, "{:.6}", row.t)?;
            for q in [&row.sent, &row.actual, &row.velocity, &row.target].into_iter().flatten() {
                write!(out, ",{q:.9}")?;
            }
            writeln!(out, ",{}", row.mode)?;
        }
        out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_that_is_full_says_so() {
        let q = Joints::<1>::zeros();
        let state =
            ArmState { mode: ArmMode::Idle, enabled: true, alarm: false, clock_ms: 0, model: 7, q, qd: q, q_target: q };
        let mut log = SendLog::new(1.0);
        let states = (21.0 / FEEDBACK_PERIOD) as usize;
        for i in 0..states {
            log.see(i as f64 * FEEDBACK_PERIOD, &q, &state);
        }
        assert_eq!(log.bound(), None);
        (0..5).for_each(|i| log.see(21.0 + f64::from(i), &q, &state));
        let words = log.bound().expect("it is full");
        assert!(words.contains("after 21.0 s") && words.contains("5 states"), "{words}");
        // A hold of half a minute is in the log of a scenario.
        let mut log = SendLog::with_holds(1.0);
        (0..states + 3750).for_each(|i| log.see(i as f64 * FEEDBACK_PERIOD, &q, &state));
        assert_eq!((log.bound(), log.missed()), (None, 0));
    }
}
