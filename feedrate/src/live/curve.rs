//! The limit curve of a path for motion that is changed while it runs, and the fastest law under
//! it.

use crate::constraint::{Feed, PathConstraint, Stop, TangentialAcceleration, TangentialJerk};
use crate::error::{FeedError, positive};
use crate::jerk_limited::JerkLimited;
use crate::limits::AxisLimits;
use crate::problem::{FeedPlanner, FeedProblem};
use crate::scan::Segment;
use crate::scan::continuous_acceleration::plan_continuous;
use crate::speed_law::SpeedLaw;
use crate::state::MotionState;

/// Part of speed, and of acceleration and jerk, that the fastest law uses: the rest is the margin
/// in which it is followed.
const LAW_FRACTIONS: (f64, f64) = (0.997, 0.99);
/// The law may be exceeded by this factor in speed: run so much faster it still keeps speed,
/// acceleration and jerk.
pub(super) const SPEED_TOLERANCE: f64 = 1.002;

/// The limit curve `V(s)`: the highest speed at which every limit holds whatever the motion does
/// within `|a| <= A`, `|j| <= J`.
///
/// The builder of the curve puts the worst case of both into `V`. From it the fastest law `n(s)` is
/// planned once. Then, from any state with `v <= n(s)` and `a <= n'(s)`, braking as hard as `A` and
/// `J` allow stays under `n` until it stands.
///
/// *Proof.* With `y = v^2 / 2`: `dy/ds = a` and `da/ds = j / v`. While braking builds up,
/// `da/ds = -J / v <= -J / v_n <= da_n/ds`, as `v <= v_n`; so `a <= a_n` stays true, and with it
/// `v <= v_n`. At `a = -A <= a_n` the same. While it is released, `v = a^2 / (2 J)`; if `n` came
/// down to that state with less acceleration it could not stand still without running backwards,
/// which it does not. ∎
///
/// ```
/// use arcfeed_feedrate::VelocityLimitCurve;
/// // 0.3 m with a bend in the middle.
/// let grid: Vec<f64> = (0..=30).map(|i| 0.01 * f64::from(i)).collect();
/// let caps: Vec<f64> = (0..30).map(|i| if (14..16).contains(&i) { 0.02 } else { 0.1 }).collect();
/// let curve = VelocityLimitCurve::new(&grid, &caps, &[], 1.0, 20.0)?;
/// assert!(curve.fastest(0.15).v <= 0.02 && curve.fastest(0.07).v > 0.09);
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone)]
pub struct VelocityLimitCurve {
    grid: Vec<f64>,
    /// `lowest[k][i]` is the least cap of the intervals `i .. i + 2^k`.
    lowest: Vec<Vec<f64>>,
    /// Positions at which the motion has to stand, the end of the path last.
    stops: Vec<f64>,
    acceleration: f64,
    jerk: f64,
    law: SpeedLaw,
}

impl VelocityLimitCurve {
    /// Highest speeds `caps` (m/s) on the intervals of `grid` (m), standstills at the inner grid
    /// points `stops`, and the tangential `acceleration` (m/s²) and `jerk` (m/s³) for which the
    /// caps were made.
    ///
    /// # Errors
    /// [`FeedError::Empty`], [`FeedError::LengthMismatch`], [`FeedError::NotFinite`],
    /// [`FeedError::BadGrid`], [`FeedError::BadSegment`] for a cap, [`FeedError::NotPositive`],
    /// [`FeedError::OutOfRange`] for a stop that is not an inner grid point.
    pub fn new(grid: &[f64], caps: &[f64], stops: &[usize], acceleration: f64, jerk: f64) -> Result<Self, FeedError> {
        positive("tangential acceleration", acceleration)?;
        positive("tangential jerk", jerk)?;
        if caps.is_empty() {
            return Err(FeedError::Empty { what: "caps" });
        }
        if grid.len() != caps.len() + 1 {
            return Err(FeedError::LengthMismatch { what: "the grid", got: grid.len(), expected: caps.len() + 1 });
        }
        if let Some((index, &value)) = caps.iter().enumerate().find(|(_, v)| !(v.is_finite() && **v > 0.0)) {
            return Err(FeedError::BadSegment { index, what: "cap", value });
        }
        if stops.iter().any(|&i| i == 0 || i >= caps.len()) || stops.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err(FeedError::OutOfRange { what: "a stop: it must be an inner grid point, in increasing order" });
        }
        let law = fastest(grid, caps, stops, LAW_FRACTIONS.1 * acceleration, LAW_FRACTIONS.1 * jerk)?;
        let places = stops.iter().map(|&i| grid[i]).chain(grid.last().copied()).collect();
        Ok(Self { grid: grid.to_vec(), lowest: lowest(caps), stops: places, acceleration, jerk, law })
    }

    /// Start of the path (m).
    pub fn start(&self) -> f64 {
        self.grid[0]
    }

    /// Position of the end (m).
    pub fn end(&self) -> f64 {
        self.grid[self.grid.len() - 1]
    }

    /// Positions at which the motion has to stand, the end of the path last (m).
    pub fn stops(&self) -> &[f64] {
        &self.stops
    }

    /// The grid (m).
    pub fn grid(&self) -> &[f64] {
        &self.grid
    }

    /// The caps on its intervals (m/s).
    pub fn caps(&self) -> &[f64] {
        &self.lowest[0]
    }

    /// Bound on the tangential acceleration, either sign (m/s²).
    pub fn acceleration(&self) -> f64 {
        self.acceleration
    }

    /// Bound on the tangential jerk, either sign (m/s³).
    pub fn jerk(&self) -> f64 {
        self.jerk
    }

    /// Tangential acceleration and jerk as limits of a forward motion; the speed is limited by the
    /// curve alone.
    pub(super) fn limits(&self) -> AxisLimits {
        AxisLimits::symmetric_unchecked(f64::INFINITY, self.acceleration, self.jerk)
    }

    /// Duration of the whole path at full speed (s).
    pub fn duration(&self) -> f64 {
        self.law.duration()
    }

    /// The fastest law at `s`, clamped to the path.
    #[inline]
    pub fn fastest(&self, s: f64) -> MotionState {
        self.law.at_position(s)
    }

    /// The least cap between two places in increasing order (m/s).
    pub fn lowest_cap(&self, from: f64, to: f64) -> f64 {
        let n = self.lowest[0].len();
        let interval = |s: f64| self.grid.partition_point(|&g| g <= s).saturating_sub(1).min(n - 1);
        let (i, j) = (interval(from), interval(to));
        let j = j.max(i);
        let k = (j - i + 1).ilog2() as usize;
        self.lowest[k][i].min(self.lowest[k][j + 1 - (1 << k)])
    }
}

/// The least cap of every run of `2^k` intervals.
fn lowest(caps: &[f64]) -> Vec<Vec<f64>> {
    let mut table = vec![caps.to_vec()];
    let mut width = 1;
    while 2 * width <= caps.len() {
        let last = &table[table.len() - 1];
        let next = (0..=caps.len() - 2 * width).map(|i| last[i].min(last[i + width])).collect();
        table.push(next);
        width *= 2;
    }
    table
}

/// The faster of what the jerk-limited planner and the joined scan find.
fn fastest(grid: &[f64], caps: &[f64], stops: &[usize], acceleration: f64, jerk: f64) -> Result<SpeedLaw, FeedError> {
    let caps: Vec<f64> = caps.iter().map(|v| LAW_FRACTIONS.0 * v).collect();
    let segments = grid
        .windows(2)
        .zip(&caps)
        .map(|(pair, &v)| Segment::new(pair[1] - pair[0], v, acceleration, jerk))
        .collect::<Result<Vec<_>, _>>()?;
    let starts = std::iter::once(0).chain(stops.iter().copied());
    let ends = stops.iter().copied().chain(std::iter::once(caps.len()));
    let parts: Vec<SpeedLaw> =
        starts.zip(ends).map(|(from, to)| plan_continuous(&segments[from..to], 0.0, 0.0)).collect::<Result<_, _>>()?;
    let joined = SpeedLaw::chain(grid[0], parts);

    let feed = Feed::new(&caps)?;
    let (tangential, change) = (TangentialAcceleration::new(acceleration)?, TangentialJerk::new(jerk)?);
    let stops: Vec<Stop> = stops.iter().map(|&at| Stop { at }).collect();
    let mut constraints: Vec<&dyn PathConstraint> = vec![&feed, &tangential, &change];
    constraints.extend(stops.iter().map(|stop| stop as &dyn PathConstraint));
    // It may not do (a stretch too short for its grid, a method that does not converge): the scan
    // always does.
    match FeedProblem::between_points(grid, &constraints).and_then(|problem| JerkLimited::default().plan(&problem)) {
        Ok(plan) if plan.duration() < joined.duration() => Ok(plan),
        _ => Ok(joined),
    }
}
