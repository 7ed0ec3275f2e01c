//! Joint motion as polynomials of the time.

use arcfeed_feedrate::Quantity;
use arcfeed_kinematics::{JointRange, Joints};

use super::certificate::{Certificate, QUANTITIES, certify, rounding, unexplained_jump};
use super::error::JointTrajectoryError;
use super::piece::{Coefficients, State, evaluate, reversed, state};
use crate::verify::JointRates;

/// Positions at which one motion ends and the next one starts may differ by this, rad: the next one is moved by the difference.
const SAME_PLACE: f64 = 1e-9;
/// Buckets of the table that finds the piece of a time, for each piece: most of them lie in one piece.
const BUCKETS: usize = 8;
/// Buckets in all, at most.
const MOST_BUCKETS: usize = 1 << 20;

/// How the pieces of a joint trajectory join.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Interpolation {
    /// Polynomials of degree 5 from position, velocity and acceleration at both ends. All three are continuous.
    #[default]
    Quintic,
    /// Polynomials of degree 3 from position and velocity at both ends, as controllers interpolate setpoints. Position and velocity
    /// are continuous. Acceleration jumps from piece to piece, so that jerk is not limited.
    Cubic,
}

impl Interpolation {
    /// The number of derivatives that are continuous, position included.
    pub const fn continuous(self) -> usize {
        match self {
            Self::Quintic => 3,
            Self::Cubic => 2,
        }
    }
}

/// The difference between a compiled motion and the plan it was made from, the largest over all joints, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// The difference that is not exceeded at any time, under the assumption that `docs/certificate.md` states.
    pub bound: f64,
    /// The largest difference at a sample.
    pub measured: f64,
}

/// The motion of the joints at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointSetpoint<const N: usize = 6> {
    /// Time since the start, s.
    pub t: f64,
    /// Positions, rad.
    pub q: Joints<N>,
    /// Velocities, rad/s.
    pub qd: Joints<N>,
    /// Accelerations, rad/s^2.
    pub qdd: Joints<N>,
    /// Jerks, rad/s^3; at a border of two pieces that of the second one.
    pub jerk: Joints<N>,
}

/// A motion of `N` joints as polynomials of degree 5 at most, without path and arm.
///
/// [`Trajectory::compile`](crate::Trajectory::compile) makes it. It is plain data: it can be stored, sent to another thread, sampled at
/// any time without an arm, reversed, and joined with another one at rest. Values of this type are valid: times increase from 0,
/// numbers are finite, and position and velocity do not jump, nor does acceleration with [`Interpolation::Quintic`].
///
/// ```
/// use arcfeed_interp::{Interpolation, JointTrajectory};
/// use arcfeed_kinematics::Joints;
///
/// // One joint from 0 to 1 rad within 2 s, from rest to rest: q = 10 x^3 - 15 x^4 + 6 x^5 with x = t / 2.
/// let piece = [0.0, 0.0, 0.0, 10.0 / 8.0, -15.0 / 16.0, 6.0 / 32.0].map(|c| Joints::from([c]));
/// let there = JointTrajectory::from_pieces(vec![0.0, 2.0], vec![piece], Interpolation::Quintic)?;
/// assert_eq!(there.at(1.0).q[0], 0.5);
/// let there_and_back = there.clone().then(&there.reversed())?;
/// assert_eq!(there_and_back.duration(), 4.0);
/// assert!((there_and_back.at(3.5).q[0] - there.at(0.5).q[0]).abs() < 1e-14);
/// # Ok::<(), arcfeed_interp::JointTrajectoryError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct JointTrajectory<const N: usize = 6> {
    times: Vec<f64>,
    pieces: Vec<Coefficients<N>>,
    interpolation: Interpolation,
    deviation: Option<Deviation>,
    /// For each of equal parts of the duration the piece in which it starts.
    buckets: Vec<u32>,
    buckets_per_second: f64,
}

/// Piece, joint and quantity that could leave the numbers on the way: the sizes of all terms at the end of a piece, and so at any
/// time of it, have no finite sum.
fn overflow<const N: usize>(times: &[f64], pieces: &[Coefficients<N>]) -> Option<(usize, usize, Quantity)> {
    pieces.iter().zip(times.windows(2)).enumerate().find_map(|(piece, (coefficients, ends))| {
        let most = evaluate(&coefficients.map(|c| c.abs()), ends[1] - ends[0]);
        QUANTITIES.iter().zip(&most).find_map(|(quantity, most)| {
            (0..N).find(|joint| !most[*joint].is_finite()).map(|joint| (piece, joint, *quantity))
        })
    })
}

impl<const N: usize> JointTrajectory<N> {
    /// The motion `q(t) = sum c[k] (t - times[i])^k` for `t` between `times[i]` and `times[i + 1]`, with `c` the coefficients of piece
    /// `i` in rad/s^k.
    ///
    /// # Errors
    /// [`JointTrajectoryError::Count`], [`JointTrajectoryError::Time`], [`JointTrajectoryError::NotFinite`],
    /// [`JointTrajectoryError::Overflow`], and [`JointTrajectoryError::Jump`] where a quantity that has to be continuous jumps by more than rounding explains.
    pub fn from_pieces(
        times: Vec<f64>,
        pieces: Vec<[Joints<N>; 6]>,
        interpolation: Interpolation,
    ) -> Result<Self, JointTrajectoryError> {
        if pieces.is_empty() || times.len() != pieces.len() + 1 || u32::try_from(pieces.len()).is_err() {
            return Err(JointTrajectoryError::Count { times: times.len(), pieces: pieces.len() });
        }
        for (index, &t) in times.iter().enumerate() {
            let previous = if index == 0 { 0.0 } else { times[index - 1] };
            let follows = if index == 0 { t == 0.0 } else { t > previous };
            if !(follows && t.is_finite()) {
                return Err(JointTrajectoryError::Time { index, t, previous });
            }
        }
        for (piece, coefficients) in pieces.iter().enumerate() {
            for (power, values) in coefficients.iter().enumerate() {
                if let Some(joint) = (0..N).find(|&j| !values[j].is_finite()) {
                    return Err(JointTrajectoryError::NotFinite { piece, joint, power, value: values[joint] });
                }
            }
        }
        if let Some((piece, joint, quantity)) = overflow(&times, &pieces) {
            let seconds = times[piece + 1] - times[piece];
            return Err(JointTrajectoryError::Overflow { piece, joint, quantity, seconds });
        }
        if let Some(jump) = unexplained_jump(&times, &pieces, interpolation.continuous()) {
            return Err(JointTrajectoryError::Jump {
                quantity: jump.id.quantity,
                joint: jump.id.joint.map_or(0, usize::from),
                t: jump.t,
                jump: jump.jump,
                rounding: jump.rounding,
            });
        }
        Ok(Self::assemble(times, pieces, interpolation))
    }

    /// Joints that rest for some time, s; the plan is followed exactly.
    ///
    /// # Errors
    /// [`JointTrajectoryError::Time`] for a time that is not above 0, [`JointTrajectoryError::NotFinite`].
    pub fn resting(q: &Joints<N>, seconds: f64) -> Result<Self, JointTrajectoryError> {
        let mut piece = [Joints::zeros(); 6];
        piece[0] = *q;
        let rest = Self::from_pieces(vec![0.0, seconds], vec![piece], Interpolation::Quintic)?;
        Ok(rest.with_deviation(Some(Deviation { bound: 0.0, measured: 0.0 })))
    }

    /// With the table of pieces, for times and pieces that fit.
    fn assemble(times: Vec<f64>, pieces: Vec<Coefficients<N>>, interpolation: Interpolation) -> Self {
        let duration = times[times.len() - 1];
        let count = (BUCKETS * pieces.len()).clamp(1, MOST_BUCKETS);
        let per_second = count as f64 / duration;
        // A duration near the smallest numbers has one bucket.
        let (count, buckets_per_second) = if per_second.is_finite() { (count, per_second) } else { (1, 0.0) };
        let starts = |i: usize| times.partition_point(|t| *t <= i as f64 / count as f64 * duration).saturating_sub(1);
        let buckets = (0..=count).map(|i| starts(i).min(pieces.len() - 1) as u32).collect();
        Self { times, pieces, interpolation, deviation: None, buckets, buckets_per_second }
    }

    pub(super) fn with_deviation(self, deviation: Option<Deviation>) -> Self {
        Self { deviation, ..self }
    }

    /// Duration, s.
    pub fn duration(&self) -> f64 {
        self.times[self.times.len() - 1]
    }

    /// How the pieces join.
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// Number of pieces.
    pub fn len(&self) -> usize {
        self.pieces.len()
    }

    /// False: there is one piece at least.
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    /// Times at which pieces start and end, s: one more than there are pieces, the first is 0.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Coefficients of the pieces by powers of the time since the start of the piece, rad/s^k.
    pub fn coefficients(&self) -> &[[Joints<N>; 6]] {
        &self.pieces
    }

    /// The difference to the plan; `None` where there is no plan.
    pub fn deviation(&self) -> Option<Deviation> {
        self.deviation
    }

    /// The motion at time `t`, s (taken to the nearest end; a NaN to the start). It does not allocate.
    #[inline]
    pub fn at(&self, t: f64) -> JointSetpoint<N> {
        self.in_piece(self.find(t), t)
    }

    /// Bounds of position, velocity, acceleration and jerk at all times, against the limits `range` and `rates`.
    ///
    /// A jerk limit does not suit [`Interpolation::Cubic`]: make the jerk infinite in `rates`.
    pub fn certify(&self, range: &JointRange<N>, rates: &JointRates<N>) -> Certificate {
        certify(&self.times, &self.pieces, range, rates)
    }

    /// The motion backwards in time.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let duration = self.duration();
        let mut times: Vec<f64> = self.times.iter().rev().map(|t| duration - t).collect();
        let mut pieces: Vec<_> = (0..self.len()).rev().map(|i| reversed(&self.pieces[i], self.span(i))).collect();
        // A piece too short for the clock near the other end goes.
        let mut kept = 0;
        for i in 0..pieces.len() {
            if times[i + 1] > times[kept] {
                pieces[kept] = pieces[i];
                times[kept + 1] = times[i + 1];
                kept += 1;
            }
        }
        times.truncate(kept + 1);
        pieces.truncate(kept);
        // What was continuous stays so.
        Self::assemble(times, pieces, self.interpolation).with_deviation(self.deviation)
    }

    /// This motion, and `next` after it. Both have to rest where they join. Positions there may differ by 1e-9 rad: `next` is moved
    /// by the difference, which counts as deviation.
    ///
    /// # Errors
    /// [`JointTrajectoryError::NotAtRest`] and [`JointTrajectoryError::Elsewhere`] name the joint;
    /// [`JointTrajectoryError::Time`] where the sum of the durations is too large for short pieces.
    pub fn then(mut self, next: &Self) -> Result<Self, JointTrajectoryError> {
        let last = self.len() - 1;
        let (end, start) = (state(&self.pieces[last], self.span(last)), state(&next.pieces[0], 0.0));
        for joint in 0..N {
            let (before, after) = (end.q[joint], start.q[joint]);
            // Not `>`: a NaN has to show.
            let same = (before - after).abs() <= SAME_PLACE;
            if !same {
                return Err(JointTrajectoryError::Elsewhere { joint, end: before, start: after });
            }
        }
        let continuous = self.interpolation.continuous().min(next.interpolation.continuous());
        self.rests("the first motion:", &end, last, continuous)?;
        next.rests("the next motion:", &start, 0, continuous)?;
        let offset = end.q - start.q;
        let begin = self.duration();
        self.times.extend(next.times[1..].iter().map(|t| begin + t));
        self.pieces.extend(next.pieces.iter().map(|c| {
            let mut moved = *c;
            moved[0] += offset;
            moved
        }));
        // A state of rest to rounding on both sides is one state of rest.
        let interpolation = if continuous == 3 { Interpolation::Quintic } else { Interpolation::Cubic };
        let deviation = self.deviation.zip(next.deviation).map(|(a, b)| Deviation {
            bound: a.bound.max(b.bound + offset.amax()),
            measured: a.measured.max(b.measured + offset.amax()),
        });
        Ok(Self::from_pieces(self.times, self.pieces, interpolation)?.with_deviation(deviation))
    }

    /// Checks that `state` at an end of a piece is one of rest to rounding.
    fn rests(
        &self,
        which: &'static str,
        state: &State<N>,
        piece: usize,
        continuous: usize,
    ) -> Result<(), JointTrajectoryError> {
        let rates = [(Quantity::JointVelocity, &state.qd, 1), (Quantity::JointAcceleration, &state.qdd, 2)];
        for (quantity, values, order) in rates.into_iter().take(continuous - 1) {
            for joint in 0..N {
                let value = values[joint];
                let rests = value.abs() <= rounding(&self.times, &self.pieces, (piece, joint, order));
                if !rests {
                    return Err(JointTrajectoryError::NotAtRest { which, quantity, joint, value });
                }
            }
        }
        Ok(())
    }

    /// Duration of a piece.
    fn span(&self, piece: usize) -> f64 {
        self.times[piece + 1] - self.times[piece]
    }

    /// The piece of a time.
    #[inline]
    pub(super) fn find(&self, t: f64) -> usize {
        // A NaN and negative times become bucket 0.
        let bucket = ((t * self.buckets_per_second) as u32 as usize).min(self.buckets.len() - 2);
        // Rounding may put a time into the bucket beside its own.
        let mut piece = self.buckets[bucket] as usize;
        let until = self.buckets[bucket + 1] as usize;
        if until - piece > 4 {
            piece += self.times[piece + 1..=until].partition_point(|end| *end <= t);
        }
        self.walk(piece, t)
    }

    /// The piece of a time, from one that is near.
    #[inline]
    pub(super) fn walk(&self, mut piece: usize, t: f64) -> usize {
        while piece + 1 < self.pieces.len() && self.times[piece + 1] <= t {
            piece += 1;
        }
        while piece > 0 && self.times[piece] > t {
            piece -= 1;
        }
        piece
    }

    #[inline]
    pub(super) fn in_piece(&self, piece: usize, t: f64) -> JointSetpoint<N> {
        let t = t.max(0.0).min(self.times[self.pieces.len()]);
        let [q, qd, qdd, jerk] = evaluate(&self.pieces[piece], t - self.times[piece]);
        JointSetpoint { t, q, qd, qdd, jerk }
    }
}
