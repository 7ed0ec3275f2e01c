//! What a joint trajectory does between its samples: bounds on every piece, not values at some times.

use std::fmt;

use arcfeed_feedrate::{LimitId, Quantity};
use arcfeed_kinematics::{JointRange, Joints};

use super::bernstein::{Bernstein, SIZE};
use crate::verify::JointRates;

/// Bound and largest value attained agree to this part.
const AGREEMENT: f64 = 1e-9;
/// Divisions of one piece for one quantity, at most. Where they do not suffice the bound is wider, and still a bound.
const MOST_DIVISIONS: usize = 4096;
/// Roundings that explain a jump at the border of two pieces, in parts of the sizes that were added up.
const JUMP_ROUNDINGS: f64 = 256.0;
/// Roundings of the duration of a piece, in parts of the whole motion's.
const CLOCK_ROUNDINGS: f64 = 4.0;

/// The quantities, by the order of the derivative.
pub(super) const QUANTITIES: [Quantity; 4] =
    [Quantity::JointPosition, Quantity::JointVelocity, Quantity::JointAcceleration, Quantity::JointJerk];

/// The largest size of one quantity of one joint over a whole motion.
///
/// Positions are measured from the middle of the joint's range, against half the range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CertifiedBound {
    /// Which quantity of which joint.
    pub id: LimitId,
    /// The largest value found, with its sign; rad, rad/s, rad/s^2 or rad/s^3.
    pub attained: f64,
    /// The time at which it is attained, s.
    pub t: f64,
    /// The size that is certainly not exceeded at any time. It is `attained` to 1e-9 and rounding.
    pub bound: f64,
    /// The limit; infinite where there is none.
    pub limit: f64,
}

impl CertifiedBound {
    /// The bound divided by the limit.
    pub fn ratio(&self) -> f64 {
        self.bound / self.limit
    }
}

/// The largest jump of one quantity of one joint at a border of two pieces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CertifiedJump {
    /// Which quantity of which joint.
    pub id: LimitId,
    /// The size of the jump; rad, rad/s or rad/s^2.
    pub jump: f64,
    /// The time of the border, s.
    pub t: f64,
    /// The largest jump that rounding explains there.
    pub rounding: f64,
    /// True if the quantity must not jump, because its derivative is limited.
    pub limited: bool,
}

impl CertifiedJump {
    /// The jump divided by what rounding explains.
    pub fn ratio(&self) -> f64 {
        if self.jump == 0.0 { 0.0 } else { self.jump / self.rounding }
    }
}

/// Proof that a joint trajectory keeps the limits of its joints at all times, or of which it does not keep.
///
/// A piece is a polynomial. Its Bernstein coefficients enclose its values, and so do those of its derivatives. Each interval is
/// divided until the enclosure is within 1e-9 of a value that is attained. All roundings are bounded and added. The certificate
/// reads times and coefficients. It knows nothing of the way in which they were made.
///
/// ```
/// use arcfeed_interp::{JointRates, certify};
/// use arcfeed_kinematics::{JointRange, Joints};
///
/// // One joint for 2 s: q = t^2 / 2 - t^3 / 6, whose velocity is largest at 1 s.
/// let piece = [0.0, 0.0, 0.5, -1.0 / 6.0, 0.0, 0.0].map(|c| Joints::from([c]));
/// let range = JointRange::new(Joints::from([-1.0]), Joints::from([1.0]))?;
/// let rates = JointRates { velocity: [0.5].into(), acceleration: [2.0].into(), jerk: [1.0].into() };
/// let certificate = certify(&[0.0, 2.0], &[piece], &range, &rates);
/// let velocity = certificate.bounds()[1];
/// assert!((velocity.bound - 0.5).abs() < 1e-9 && (velocity.t - 1.0).abs() < 1e-4);
/// assert!(certificate.holds(1e-6));
/// # Ok::<(), arcfeed_kinematics::KinematicsError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Certificate {
    bounds: Vec<CertifiedBound>,
    jumps: Vec<CertifiedJump>,
}

impl Certificate {
    /// Position, velocity, acceleration and jerk of each joint, joint by joint.
    pub fn bounds(&self) -> &[CertifiedBound] {
        &self.bounds
    }

    /// Jumps of position, velocity and acceleration of each joint, joint by joint.
    pub fn jumps(&self) -> &[CertifiedJump] {
        &self.jumps
    }

    /// The bound of one quantity of one joint.
    pub fn of(&self, id: LimitId) -> Option<&CertifiedBound> {
        self.bounds.iter().find(|bound| bound.id == id)
    }

    /// The limited bound with the largest ratio; `None` where nothing is limited.
    pub fn worst(&self) -> Option<CertifiedBound> {
        let limited = self.bounds.iter().copied().filter(|b| b.limit != f64::INFINITY || b.bound.is_nan());
        limited.reduce(|m, b| if b.ratio() > m.ratio() || b.ratio().is_nan() { b } else { m })
    }

    /// The jump that must not be, with the largest ratio; `None` where there is none.
    pub fn worst_jump(&self) -> Option<CertifiedJump> {
        let limited = self.jumps.iter().copied().filter(|jump| jump.limited);
        limited.reduce(|m, j| if j.ratio() > m.ratio() || j.ratio().is_nan() { j } else { m })
    }

    /// True where no bound exceeds its limit by more than `tolerance`, relative, and where rounding explains every jump of a
    /// quantity whose derivative is limited.
    pub fn holds(&self, tolerance: f64) -> bool {
        // Not `> 1.0`: a NaN does not hold, and neither does nothing.
        !self.bounds.is_empty()
            && self
                .bounds
                .iter()
                .all(|b| b.limit == f64::INFINITY && b.bound < f64::INFINITY || b.ratio() <= 1.0 + tolerance)
            && self.jumps.iter().all(|jump| !jump.limited || jump.ratio() <= 1.0)
    }
}

impl fmt::Display for Certificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.worst() {
            Some(worst) => {
                write!(f, "{} at most {:.4} % of its limit, at t = {:.4} s", worst.id, 100.0 * worst.ratio(), worst.t)
            }
            None => f.write_str("nothing is limited"),
        }
    }
}

/// Certifies the pieces `q(t) = sum c[k] (t - times[i])^k` between the times `times` (s), one more than there are pieces.
///
/// A rate without a limit is infinite in `rates`. A jump of a quantity breaks the limit of its derivative: the acceleration may
/// jump where the jerk is not limited. With times that do not fit the pieces, or do not increase, nothing is certified and
/// [`Certificate::holds`] is false.
pub fn certify<const N: usize>(
    times: &[f64],
    pieces: &[[Joints<N>; 6]],
    range: &JointRange<N>,
    rates: &JointRates<N>,
) -> Certificate {
    let fits = times.len() == pieces.len() + 1 && !pieces.is_empty() && times.windows(2).all(|t| t[0] < t[1]);
    if !fits {
        return Certificate { bounds: Vec::new(), jumps: Vec::new() };
    }
    let motion = Motion { times, pieces };
    let mut certificate = Certificate { bounds: Vec::with_capacity(4 * N), jumps: Vec::with_capacity(3 * N) };
    for joint in 0..N {
        let (lower, upper) = (range.lower()[joint], range.upper()[joint]);
        let rates = [rates.velocity[joint], rates.acceleration[joint], rates.jerk[joint]];
        let limits = [0.5 * (upper - lower), rates[0], rates[1], rates[2]];
        for (order, (quantity, limit)) in QUANTITIES.into_iter().zip(limits).enumerate() {
            let middle = if order == 0 { 0.5 * (lower + upper) } else { 0.0 };
            let (attained, t, bound) = motion.extreme(joint, order, middle);
            let id = LimitId::joint(quantity, joint);
            certificate.bounds.push(CertifiedBound { id, attained, t, bound, limit });
        }
        for (order, limit) in rates.into_iter().enumerate() {
            let (jump, t, rounding) = motion.jump(joint, order);
            let id = LimitId::joint(QUANTITIES[order], joint);
            let limited = limit != f64::INFINITY;
            certificate.jumps.push(CertifiedJump { id, jump, t, rounding, limited });
        }
    }
    certificate
}

/// The first jump at a border that rounding does not explain, of the first `orders` of position, velocity and acceleration.
pub(super) fn unexplained_jump<const N: usize>(
    times: &[f64],
    pieces: &[[Joints<N>; 6]],
    orders: usize,
) -> Option<CertifiedJump> {
    let motion = Motion { times, pieces };
    let all = (0..N).flat_map(|joint| (0..orders).map(move |order| (joint, order)));
    all.map(|(joint, order)| {
        let (jump, t, rounding) = motion.jump(joint, order);
        CertifiedJump { id: LimitId::joint(QUANTITIES[order], joint), jump, t, rounding, limited: true }
    })
    .find(|jump| {
        // Not `> 1.0`: a NaN is not explained.
        let explained = jump.ratio() <= 1.0;
        !explained
    })
}

/// What rounding explains of a velocity (`order` 1) or an acceleration (2) at an end of a piece.
pub(super) fn rounding<const N: usize>(
    times: &[f64],
    pieces: &[[Joints<N>; 6]],
    (piece, joint, order): (usize, usize, usize),
) -> f64 {
    Motion { times, pieces }.rounding(piece, joint, order)
}

/// Pieces and the times between them.
#[derive(Clone, Copy)]
pub(super) struct Motion<'a, const N: usize> {
    pub times: &'a [f64],
    pub pieces: &'a [[Joints<N>; SIZE]],
}

impl<const N: usize> Motion<'_, N> {
    pub fn duration(&self, piece: usize) -> f64 {
        self.times[piece + 1] - self.times[piece]
    }

    /// Powers of the derivative `order` of a piece, for the time in parts of its duration, less `middle`.
    fn powers(&self, piece: usize, joint: usize, order: usize, middle: f64) -> [f64; SIZE] {
        let h = self.duration(piece);
        let c = &self.pieces[piece];
        let mut powers = [0.0; SIZE];
        let mut scale = 1.0;
        for k in order..SIZE {
            powers[k - order] = c[k][joint] * factor(k, order) * scale;
            scale *= h;
        }
        powers[0] -= middle;
        powers
    }

    /// The derivative `order` of one joint on a piece, less `middle`.
    pub fn bernstein(&self, piece: usize, joint: usize, order: usize, middle: f64) -> Bernstein {
        Bernstein::from_powers(&self.powers(piece, joint, order, middle), SIZE - 1 - order)
    }

    /// The value of largest size that is attained, its time, and the size that is not exceeded.
    fn extreme(&self, joint: usize, order: usize, middle: f64) -> (f64, f64, f64) {
        let mut search = Search { attained: 0.0, t: self.times[0], bound: 0.0 };
        for piece in 0..self.pieces.len() {
            let ends = self.bernstein(piece, joint, order, middle).ends();
            search.see(ends, self.times[piece], self.times[piece + 1]);
        }
        for piece in 0..self.pieces.len() {
            let whole = self.bernstein(piece, joint, order, middle);
            search.enclose(&whole, self.times[piece], self.duration(piece));
        }
        (search.attained, search.t, search.bound)
    }

    /// The largest jump beside what rounding explains, its time, and what rounding explains.
    fn jump(&self, joint: usize, order: usize) -> (f64, f64, f64) {
        let mut worst = (0.0, self.times[0], f64::MIN_POSITIVE);
        for piece in 1..self.pieces.len() {
            let before = self.powers(piece - 1, joint, order, 0.0);
            let end: f64 = before.iter().rev().sum();
            let start = self.pieces[piece][order][joint] * factor(order, order);
            let rounding = self.rounding(piece - 1, joint, order) + self.rounding(piece, joint, order);
            let jump = (start - end).abs();
            // Not `max`: a NaN has to show.
            if jump.is_nan() || jump * worst.2 > worst.0 * rounding {
                worst = (jump, self.times[piece], rounding);
            }
        }
        worst
    }

    /// What rounding explains of a derivative at a border of a piece: coefficients come from differences of positions over powers
    /// of the duration, and the clock has a resolution.
    pub fn rounding(&self, piece: usize, joint: usize, order: usize) -> f64 {
        let powers = self.powers(piece, joint, 0, 0.0);
        let moved: f64 = powers[1..].iter().map(|a| a.abs()).sum();
        let stands = if order == 0 { powers[0].abs() } else { 0.0 };
        let rate: f64 = self.powers(piece, joint, order + 1, 0.0).iter().map(|a| a.abs()).sum();
        let (h, clock) = (self.duration(piece), CLOCK_ROUNDINGS * f64::EPSILON * self.times[self.pieces.len()]);
        JUMP_ROUNDINGS * f64::EPSILON * (moved + stands) / h.powi(order as i32) + rate * clock + f64::MIN_POSITIVE
    }
}

/// `k (k - 1) .. (k - order + 1)`.
fn factor(k: usize, order: usize) -> f64 {
    (0..order).map(|i| (k - i) as f64).product()
}

/// The search for a largest size: what is attained so far, and what is not exceeded on the intervals that are done.
struct Search {
    attained: f64,
    t: f64,
    bound: f64,
}

impl Search {
    fn see(&mut self, [begin, end]: [f64; 2], from: f64, to: f64) {
        for (value, t) in [(begin, from), (end, to)] {
            if value.abs() > self.attained.abs() {
                (self.attained, self.t) = (value, t);
            }
        }
    }

    /// Divides a piece until its coefficients are within [`AGREEMENT`] of the largest value that is attained anywhere.
    fn enclose(&mut self, whole: &Bernstein, start: f64, duration: f64) {
        let mut open = vec![(*whole, 0.0, 1.0)];
        let mut divisions = 0;
        while let Some((part, from, width)) = open.pop() {
            let close = part.largest() <= self.attained.abs() * (1.0 + AGREEMENT);
            let bound = part.bound();
            if close || divisions == MOST_DIVISIONS || !bound.is_finite() {
                // Not `max`: a NaN has to show.
                if bound > self.bound || bound.is_nan() {
                    self.bound = if bound.is_nan() { f64::INFINITY } else { bound };
                }
                continue;
            }
            divisions += 1;
            let half = 0.5 * width;
            for (part, from) in part.halves().into_iter().zip([from, from + half]) {
                self.see(part.ends(), start + from * duration, start + (from + half) * duration);
                open.push((part, from, half));
            }
        }
    }
}
