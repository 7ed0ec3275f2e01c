//! The search for the largest sizes of quantities of the tool: samples, and bounds on what lies between two of them.

use arcfeed_feedrate::Quantity;
use arcfeed_kinematics::Joints;

use super::certificate::Motion;
use super::piece::evaluate;

/// Bound and largest value attained agree to this part where [`MOST_DIVISIONS`] suffice.
const AGREEMENT: f64 = 1e-3;
/// Or to this part of what the joints could do to the tool if all pulled in one direction: a tool that does not turn has an angular
/// speed of rounding.
const NEGLIGIBLE: f64 = 1e-4;
/// Divisions of one piece, at most.
const MOST_DIVISIONS: usize = 20_000;
/// Part by which bounds are raised for the rounding of forward kinematics.
const ROUNDING: f64 = 1e-9;
/// The longest interval at the start of the search, s.
const LONGEST: f64 = 2e-3;

/// The largest size of one quantity of the tool over a whole motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolBound {
    /// Feed (m/s), angular speed (rad/s), tangential, normal or whole acceleration (m/s^2), or jerk (m/s^3).
    pub quantity: Quantity,
    /// The largest size found.
    pub attained: f64,
    /// The time at which it is attained, s.
    pub t: f64,
    /// The size that is not exceeded at any time.
    pub bound: f64,
}

/// The tool at one time: the sizes of `K` quantities, and what bounds between two moments need besides.
#[derive(Clone, Copy)]
pub(super) struct Moment<D, const K: usize> {
    /// Time since the start of the piece, s.
    pub tau: f64,
    pub sizes: [f64; K],
    pub data: D,
}

/// Looks for the largest sizes of `K` quantities. `sample` gives them, and what bounds need, from position, velocity, acceleration and
/// jerk of the joints.
pub(super) struct ToolSearch<'m, F, const N: usize, const K: usize> {
    motion: Motion<'m, N>,
    sample: F,
    /// Largest sizes at samples, and their times.
    largest: [(f64, f64); K],
    /// Sizes below which a bound is not made closer.
    least: [f64; K],
    /// Sizes that are not exceeded on the intervals that are done.
    bounds: [f64; K],
}

impl<'m, F, D: Copy, const N: usize, const K: usize> ToolSearch<'m, F, N, K>
where
    F: Fn([Joints<N>; 4]) -> ([f64; K], D),
{
    pub fn new(motion: Motion<'m, N>, sample: F) -> Self {
        Self { motion, sample, largest: [(0.0, 0.0); K], least: [0.0; K], bounds: [0.0; K] }
    }

    fn moment(&mut self, piece: usize, tau: f64) -> Moment<D, K> {
        let (sizes, data) = (self.sample)(evaluate(&self.motion.pieces[piece], tau));
        for (largest, size) in self.largest.iter_mut().zip(sizes) {
            if size > largest.0 {
                *largest = (size, self.motion.times[piece] + tau);
            }
        }
        Moment { tau, sizes, data }
    }

    /// Samples a piece on which the joints could bring the quantities to these sizes.
    pub fn look(&mut self, piece: usize, possible: [f64; K]) {
        self.look_within(piece, [0.0, self.motion.duration(piece)], possible);
    }

    /// The same between two times since the start of the piece, s.
    pub fn look_within(&mut self, piece: usize, [from, to]: [f64; 2], possible: [f64; K]) {
        for (least, size) in self.least.iter_mut().zip(possible) {
            *least = least.max(NEGLIGIBLE * size);
        }
        let n = intervals(to - from);
        for i in 0..=n {
            self.moment(piece, from + (to - from) * i as f64 / n as f64);
        }
    }

    /// Divides a piece until its bounds are near the largest sizes found anywhere; `between` gives the sizes that are not exceeded between
    /// two moments of it.
    pub fn enclose(&mut self, piece: usize, between: impl Fn(&Moment<D, K>, &Moment<D, K>) -> [f64; K]) {
        self.enclose_within(piece, [0.0, self.motion.duration(piece)], between);
    }

    /// The same between two times since the start of the piece, s.
    pub fn enclose_within(
        &mut self,
        piece: usize,
        [from, to]: [f64; 2],
        between: impl Fn(&Moment<D, K>, &Moment<D, K>) -> [f64; K],
    ) {
        let n = intervals(to - from);
        let mut open = Vec::with_capacity(n + 32);
        let mut begin = self.moment(piece, from);
        for i in 1..=n {
            let end = self.moment(piece, from + (to - from) * i as f64 / n as f64);
            open.push((begin, end));
            begin = end;
        }
        let mut divisions = 0;
        while let Some((a, b)) = open.pop() {
            let bounds = between(&a, &b);
            let near = |k: usize| bounds[k] <= (self.largest[k].0 * (1.0 + AGREEMENT)).max(self.least[k]);
            let middle = 0.5 * (a.tau + b.tau);
            if (0..K).all(near) || divisions == MOST_DIVISIONS || !(a.tau < middle && middle < b.tau) {
                for (bound, of) in self.bounds.iter_mut().zip(bounds) {
                    // Not `max`: a NaN bounds nothing.
                    if of > *bound || of.is_nan() {
                        *bound = if of.is_nan() { f64::INFINITY } else { of };
                    }
                }
                continue;
            }
            divisions += 1;
            let middle = self.moment(piece, middle);
            open.push((a, middle));
            open.push((middle, b));
        }
    }

    /// What was found of these quantities.
    pub fn finish(self, quantities: [Quantity; K]) -> [ToolBound; K] {
        std::array::from_fn(|k| ToolBound {
            quantity: quantities[k],
            attained: self.largest[k].0,
            t: self.largest[k].1,
            bound: self.bounds[k] * (1.0 + ROUNDING),
        })
    }
}

/// Intervals at the start of the search over some time, s.
fn intervals(time: f64) -> usize {
    (time / LONGEST).ceil().max(1.0).min(MOST_DIVISIONS as f64) as usize
}
