//! A rapid move of the joints in a program.

use arcfeed_interp::Trajectory;

/// The motion of the joints along consecutive rapid moves (G0) of a program, from rest to rest.
#[derive(Debug, Clone)]
pub struct JointMove<'t, const N: usize = 6> {
    pub(crate) trajectory: Trajectory<'t, N>,
    pub(crate) passed: Vec<Passed>,
    pub(crate) leaves: Leaves,
    pub(crate) lift_m: f64,
    pub(crate) reconfigured: bool,
    /// Parameter of the path, and the way of the tool up to it, m; increasing.
    pub(crate) way: Vec<(f64, f64)>,
}

/// The end of a rapid move on the way of the joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passed {
    /// The line of the file.
    pub line: usize,
    /// The N word, where there is one.
    pub number: Option<u32>,
    /// The distance at which the tool passes it, m.
    pub distance_m: f64,
    /// The place on the path of the joints.
    pub(crate) parameter: f64,
}

/// How far the tool is from the straight lines of the program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leaves {
    /// The largest distance, on dense samples, m.
    pub distance_m: f64,
    /// The line of the file on whose move that is.
    pub line: usize,
}

impl<'t, const N: usize> JointMove<'t, N> {
    /// The trajectory: lines of the joints with blends, their speed, verification.
    pub fn trajectory(&self) -> &Trajectory<'t, N> {
        &self.trajectory
    }

    /// The end of each move, and how near it is passed.
    pub fn passed(&self) -> &[Passed] {
        &self.passed
    }

    /// How far the tool is from the straight lines of the program.
    pub fn leaves(&self) -> Leaves {
        self.leaves
    }

    /// How high the moves are above both of their ends along the z axis of the workpiece, or above their start where no path follows, m.
    pub fn lift_m(&self) -> f64 {
        self.lift_m
    }

    /// True if the arm changes its configuration, because the next path cannot be followed in the one that the moves lead to.
    pub fn reconfigured(&self) -> bool {
        self.reconfigured
    }

    /// True if the tool may leave the lines by more than the lift.
    pub fn exceeds_lift(&self) -> bool {
        // Not `>`: a NaN has to show.
        let inside = self.leaves.distance_m <= self.lift_m;
        !inside
    }

    /// The way of the tool up to a value of the parameter, m.
    pub(crate) fn way_at(&self, s: f64) -> f64 {
        let i = self.way.partition_point(|(at, _)| *at <= s);
        match (i.checked_sub(1).and_then(|i| self.way.get(i)), self.way.get(i)) {
            (Some(&(s0, w0)), Some(&(s1, w1))) if s1 > s0 => w0 + (w1 - w0) * ((s - s0) / (s1 - s0)),
            (Some(&(_, way)), _) => way,
            (None, _) => 0.0,
        }
    }
}
