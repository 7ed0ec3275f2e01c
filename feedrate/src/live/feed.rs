//! The motion along a live curve: its state, and what may be asked of it.

use super::curve::VelocityLimitCurve;
use super::final_stop::FinalStop;
use super::sections::{Feeds, LiveSection};
use crate::error::{FeedError, finite, not_negative, positive};
use crate::state::MotionState;

/// The request of the operator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Intent {
    Run,
    Hold,
    Back(f64),
}

/// Status of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LiveStatus {
    /// On the way forward, or braking.
    Moving,
    /// At rest, and told to hold.
    Holding,
    /// On the way back.
    SteppingBack,
    /// At the end of the path, at rest.
    Finished,
}

/// State and status after a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveStep {
    /// Position, speed (negative on the way back), acceleration, and the mean jerk of the cycle.
    pub state: MotionState,
    /// Status of the motion.
    pub status: LiveStatus,
}

/// A motion along a [`VelocityLimitCurve`] whose feed may change in any cycle.
///
/// A cycle does what the operator asks if, from the state that it leads to, braking gets under the
/// fastest law; else it does a little less. Braking itself is always possible. Nothing is planned
/// anew while the motion runs.
///
/// **Guarantees**, whatever is asked for and whenever: `|a| <= A`, `|j| <= J`, the speed is under
/// the curve, and every end (corner, end of path, place to step back to) is reached exactly and at
/// rest. A lower feed is met as soon as `A` and `J` allow, that of a section ahead before it
/// begins, if it was asked for in time. No call allocates; a cycle takes a bounded number of
/// operations.
///
/// ```
/// use arcfeed_feedrate::{VelocityLimitCurve, FeedOverride, LiveStatus};
/// let grid: Vec<f64> = (0..=30).map(|i| 0.01 * f64::from(i)).collect();
/// let curve = VelocityLimitCurve::new(&grid, &[0.1; 30], &[], 1.0, 20.0)?;
/// let mut feed = FeedOverride::new(&curve, 1e-3, 0.08)?;
/// let mut cycle = 0;
/// let end = loop {
///     match cycle {
///         500 => feed.set_override(0.5)?,
///         900 => feed.hold(),
///         1200 => feed.step_back(0.02)?,
///         2500 => feed.resume(),
///         _ => {}
///     }
///     let step = feed.step();
///     if step.status == LiveStatus::Finished {
///         break step.state;
///     }
///     cycle += 1;
/// };
/// assert_eq!((end.p, end.v, end.a), (curve.end(), 0.0, 0.0));
/// # Ok::<(), arcfeed_feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone)]
pub struct FeedOverride<'a> {
    pub(super) curve: &'a VelocityLimitCurve,
    pub(super) period: f64,
    pub(super) feeds: Feeds,
    pub(super) factor: f64,
    pub(super) intent: Intent,
    pub(super) s: f64,
    pub(super) v: f64,
    pub(super) a: f64,
    /// Number of the next place to stand at.
    pub(super) next: usize,
    pub(super) final_stop: Option<FinalStop>,
    /// Start of the section ahead for which the motion brakes, and the feed on it.
    pub(super) braking_for: Option<(f64, f64)>,
}

impl<'a> FeedOverride<'a> {
    /// At rest at the start of the path, with a control `period` (s) and a programmed `feed` (m/s).
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::NotPositive`].
    pub fn new(curve: &'a VelocityLimitCurve, period: f64, feed: f64) -> Result<Self, FeedError> {
        Ok(Self {
            curve,
            period: positive("control period", period)?,
            feeds: Feeds::new(feed)?,
            factor: 1.0,
            intent: Intent::Run,
            s: curve.start(),
            v: 0.0,
            a: 0.0,
            next: 0,
            final_stop: None,
            braking_for: None,
        })
    }

    /// Sets the programmed feed (m/s).
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::NotPositive`].
    pub fn set_feed(&mut self, feed: f64) -> Result<(), FeedError> {
        self.feeds.set_base(feed)
    }

    /// Sets the feeds of up to [`MAX_SECTIONS`](crate::MAX_SECTIONS) stretches; where they overlap
    /// the lowest counts.
    ///
    /// # Errors
    /// [`FeedError::AboveLimit`] for too many, [`FeedError::NotFinite`],
    /// [`FeedError::NotPositive`], [`FeedError::BelowLimit`].
    pub fn set_sections(&mut self, sections: &[LiveSection]) -> Result<(), FeedError> {
        self.braking_for = None;
        self.feeds.set_sections(sections)
    }

    /// Multiplies every feed, from 0 (hold) to what the curve allows.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`], [`FeedError::Negative`].
    pub fn set_override(&mut self, factor: f64) -> Result<(), FeedError> {
        self.factor = not_negative("override", finite("override", factor)?)?;
        Ok(())
    }

    /// Brakes as hard as allowed and stays where that ends.
    pub fn hold(&mut self) {
        self.intent = Intent::Hold;
    }

    /// Goes on forward.
    pub fn resume(&mut self) {
        self.intent = Intent::Run;
    }

    /// Brakes, runs back to `place` (m), and holds there.
    ///
    /// # Errors
    /// [`FeedError::NotFinite`]; [`FeedError::AboveLimit`] or [`FeedError::BelowLimit`] for a place
    /// that does not lie between the start of the path and the present place.
    pub fn step_back(&mut self, place: f64) -> Result<(), FeedError> {
        finite("place to step back to", place)?;
        if place > self.s {
            return Err(FeedError::AboveLimit { what: "place to step back to", value: place, limit: self.s });
        }
        if place < self.curve.start() {
            let limit = self.curve.start();
            return Err(FeedError::BelowLimit { what: "place to step back to", value: place, limit });
        }
        self.intent = Intent::Back(place);
        Ok(())
    }

    /// Takes the motion as standing where it is: something else has taken it over, and brings it
    /// back here.
    pub fn stand(&mut self) {
        (self.v, self.a) = (0.0, 0.0);
        (self.final_stop, self.braking_for) = (None, None);
        self.intent = Intent::Hold;
        self.next = self.stops_passed();
    }

    /// The same feed, override and sections at the start of another curve.
    pub fn moved_to<'b>(&self, curve: &'b VelocityLimitCurve) -> FeedOverride<'b> {
        let (s, intent) = (curve.start(), self.intent);
        let (period, feeds, factor) = (self.period, self.feeds, self.factor);
        FeedOverride {
            curve,
            period,
            feeds,
            factor,
            intent,
            s,
            v: 0.0,
            a: 0.0,
            next: 0,
            final_stop: None,
            braking_for: None,
        }
    }

    /// The curve it runs under.
    pub fn curve(&self) -> &'a VelocityLimitCurve {
        self.curve
    }

    /// Present position (m).
    pub fn position(&self) -> f64 {
        self.s
    }

    /// Returns true if it stands.
    pub fn is_at_rest(&self) -> bool {
        self.v == 0.0 && self.a == 0.0
    }

    /// The programmed feed outside of sections, without the override (m/s).
    pub fn feed(&self) -> f64 {
        self.feeds.base()
    }

    /// The override.
    pub fn override_factor(&self) -> f64 {
        self.factor
    }

    /// The feed asked for here, 0 where the motion is to stand (m/s).
    pub(super) fn asked(&self) -> f64 {
        match self.intent {
            Intent::Run => self.feeds.at(self.s) * self.factor,
            Intent::Hold | Intent::Back(_) => 0.0,
        }
    }

    pub(super) fn stops_passed(&self) -> usize {
        self.curve.stops().partition_point(|&stop| stop <= self.s)
    }
}
