//! Turns of 2 pi: the one inside the joint limits that is nearest to a seed.

use crate::joint::{JointRange, Joints};
use crate::trig::{floor, round};
use std::f64::consts::TAU;

/// Joint values this little outside a limit are put onto it, rad: rounding, not an excess.
const LIMIT_ROUNDING: f64 = 1e-10;

/// A joint that no turn of 2 pi brings inside its limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitExcess {
    /// Which joint, from 0.
    pub joint: usize,
    /// Its value on the turn that misses the limits least, rad.
    pub value: f64,
    /// Its lower limit, rad.
    pub lower: f64,
    /// Its upper limit, rad.
    pub upper: f64,
    /// By how much it misses, rad.
    pub excess: f64,
}

/// `q` with each joint on the turn of 2 pi that is nearest to `seed` among all turns inside `range`.
///
/// # Errors
/// The joint that misses its limits most, if one has no turn inside them.
pub fn nearest_turns<const N: usize>(
    q: &Joints<N>,
    seed: &Joints<N>,
    range: &JointRange<N>,
) -> Result<Joints<N>, LimitExcess> {
    let mut nearest = *q;
    let mut worst: Option<LimitExcess> = None;
    for joint in 0..N {
        match nearest_turn(q[joint], seed[joint], joint, range) {
            Ok(value) => nearest[joint] = value,
            Err(miss) if worst.is_none_or(|known| miss.excess > known.excess) => worst = Some(miss),
            Err(_) => {}
        }
    }
    worst.map_or(Ok(nearest), Err)
}

/// The turn of the value `q` of one joint that is nearest to `seed` among those inside `range`.
///
/// # Errors
/// The turn that misses the limits least.
#[inline]
pub(crate) fn nearest_turn<const N: usize>(
    q: f64,
    seed: f64,
    joint: usize,
    range: &JointRange<N>,
) -> Result<f64, LimitExcess> {
    let (lower, upper) = (range.lower()[joint], range.upper()[joint]);
    let nearest_turn = round((seed - q) * (1.0 / TAU));
    let value = q + TAU * nearest_turn;
    if lower <= value && value <= upper {
        return Ok(value);
    }
    let first = -floor((q - (lower - LIMIT_ROUNDING)) / TAU);
    let last = floor((upper + LIMIT_ROUNDING - q) / TAU);
    if first <= last {
        let turns = nearest_turn.clamp(first, last);
        return Ok((q + TAU * turns).clamp(lower, upper));
    }
    // No turn fits: the last one below the range and the first one above it miss it least.
    let (below, above) = (q + TAU * last, q + TAU * first);
    let (value, excess) = if lower - below <= above - upper { (below, lower - below) } else { (above, above - upper) };
    Err(LimitExcess { joint, value, lower, upper, excess })
}
