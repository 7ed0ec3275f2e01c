//! What a motion through way-points has to do: points, target and limits.

use arcfeed_feedrate::{AxisLimits, AxisState, FeedError};

use super::MOST_WAY_POINTS;

use crate::error::SyncError;

/// A position that all axes pass at the same time, without stopping unless its velocity says so.
///
/// ```
/// use arcfeed_sync::WayPoint;
/// use arcfeed_sync::feedrate::AxisLimits;
/// let slow = [AxisLimits::symmetric(0.2, 2.0, 20.0)?; 2];
/// let point = WayPoint::new([0.5, -0.2])
///     .with_velocity(0, 0.1) // The first axis passes at 0.1; the second one as is best.
///     .with_limits(slow) // On the section that ends here.
///     .with_least_duration(1.5); // Of that section, in seconds.
/// assert_eq!(point.velocity(), [Some(0.1), None]);
/// # Ok::<(), arcfeed_sync::feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WayPoint<const N: usize> {
    position: [f64; N],
    velocity: [Option<f64>; N],
    blend: Option<f64>,
    pub(super) section: Section<N>,
}

/// What holds on a section besides the limits of the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Section<const N: usize> {
    pub limits: Option<[AxisLimits; N]>,
    pub least_duration: f64,
    pub straight: bool,
}

impl<const N: usize> Section<N> {
    pub const FREE: Self = Self { limits: None, least_duration: 0.0, straight: false };

    fn check(&self) -> Result<(), SyncError> {
        let value = self.least_duration;
        if value.is_finite() && value >= 0.0 { Ok(()) } else { Err(SyncError::Duration { value }) }
    }
}

impl<const N: usize> WayPoint<N> {
    /// A point with free velocities; the section that ends there has the limits of the axes.
    pub const fn new(position: [f64; N]) -> Self {
        Self { position, velocity: [None; N], blend: None, section: Section::FREE }
    }

    /// The velocity of one axis in the point. An axis that there is not is left out.
    #[must_use]
    pub const fn with_velocity(mut self, axis: usize, velocity: f64) -> Self {
        if axis < N {
            self.velocity[axis] = Some(velocity);
        }
        self
    }

    /// Other limits on the section that ends in the point.
    #[must_use]
    pub const fn with_limits(mut self, limits: [AxisLimits; N]) -> Self {
        self.section.limits = Some(limits);
        self
    }

    /// The least duration of the section that ends in the point (s).
    #[must_use]
    pub const fn with_least_duration(mut self, duration: f64) -> Self {
        self.section.least_duration = duration;
        self
    }

    /// All axes move on the straight line to the point, from the one before. Without a blend they rest
    /// in the point, and so they do between a straight section and one that is not.
    ///
    /// Axes that move when the route is set, and not towards the point, come to rest first, each in the
    /// shortest way; the line begins there.
    #[must_use]
    pub const fn with_straight_section(mut self) -> Self {
        self.section.straight = true;
        self
    }

    /// Between two straight sections the corner is passed without a stop within `deviation` (rad or m)
    /// of the point: the blend is nowhere farther from the lines, and the point is no farther from the
    /// blend, by the Euclidean distance of all axes. It begins and ends at most half way to the
    /// neighbouring points. A smaller deviation makes the axes slower at the corner; they rest
    /// where that is faster than the blend.
    #[must_use]
    pub const fn with_blend(mut self, deviation: f64) -> Self {
        self.blend = Some(deviation);
        self
    }

    /// The position (rad or m).
    pub const fn position(&self) -> [f64; N] {
        self.position
    }

    pub(super) const fn take_velocity(&mut self, velocity: [Option<f64>; N]) {
        self.velocity = velocity;
    }

    /// The deviation of the blend (rad or m); `None` where there is none.
    pub const fn blend(&self) -> Option<f64> {
        self.blend
    }

    /// The velocities that are given (1/s).
    pub const fn velocity(&self) -> [Option<f64>; N] {
        self.velocity
    }
}

/// Way-points, the target after them, and the limits of the axes.
///
/// ```
/// use arcfeed_sync::feedrate::{AxisLimits, AxisState};
/// use arcfeed_sync::{Route, WayPoint};
/// let points = [WayPoint::new([0.4, 0.1]), WayPoint::new([0.8, 0.5])];
/// let limits = [AxisLimits::symmetric(1.0, 5.0, 50.0)?; 2];
/// let route = Route::new(&points, [1.0, 0.6].map(AxisState::rest), limits).with_least_duration(0.5);
/// assert_eq!(route.sections(), 3);
/// # Ok::<(), arcfeed_sync::feedrate::FeedError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Route<'a, const N: usize> {
    pub(super) points: &'a [WayPoint<N>],
    pub(super) target: [AxisState; N],
    limits: [AxisLimits; N],
    last: Section<N>,
}

impl<'a, const N: usize> Route<'a, N> {
    /// Through `points` to `target`. Points and blends together are at most [`MOST_WAY_POINTS`].
    pub const fn new(points: &'a [WayPoint<N>], target: [AxisState; N], limits: [AxisLimits; N]) -> Self {
        Self { points, target, limits, last: Section::FREE }
    }

    /// Other limits on the last section.
    #[must_use]
    pub const fn with_limits(mut self, limits: [AxisLimits; N]) -> Self {
        self.last.limits = Some(limits);
        self
    }

    /// The least duration of the last section (s).
    #[must_use]
    pub const fn with_least_duration(mut self, duration: f64) -> Self {
        self.last.least_duration = duration;
        self
    }

    /// The last section is straight, as by [`WayPoint::with_straight_section`].
    #[must_use]
    pub const fn with_straight_section(mut self) -> Self {
        self.last.straight = true;
        self
    }

    /// Number of sections, one more than points.
    pub const fn sections(&self) -> usize {
        self.points.len() + 1
    }

    /// The way-points.
    pub const fn points(&self) -> &[WayPoint<N>] {
        self.points
    }

    /// The state at the end.
    pub const fn target(&self) -> &[AxisState; N] {
        &self.target
    }

    /// Through other points.
    pub(super) const fn through(&self, points: &'a [WayPoint<N>], last: Section<N>) -> Self {
        Self { points, target: self.target, limits: self.limits, last }
    }

    pub(super) fn section(&self, i: usize) -> &Section<N> {
        self.points.get(i).map_or(&self.last, |point| &point.section)
    }

    /// The limits of a section; the last one counts after the last.
    pub fn limits(&self, section: usize) -> &[AxisLimits; N] {
        self.limits_of(self.section(section))
    }

    /// The limits of a section, its own or those of the axes.
    pub(super) fn limits_of<'b>(&'b self, section: &'b Section<N>) -> &'b [AxisLimits; N] {
        section.limits.as_ref().unwrap_or(&self.limits)
    }

    /// The least duration of a section (s); the last one counts after the last.
    pub fn least_duration(&self, section: usize) -> f64 {
        self.section(section).least_duration
    }

    /// Returns true if a section has to be straight; the last one counts after the last.
    pub fn is_straight(&self, section: usize) -> bool {
        self.section(section).straight
    }

    /// The sections from `first` to `last`, which end at rest before the target.
    pub(super) fn part(&self, first: usize, last: usize) -> Self {
        let target = match self.points.get(last) {
            Some(point) => point.position.map(AxisState::rest),
            None => self.target,
        };
        Self { points: &self.points[first..last], target, limits: self.limits, last: *self.section(last) }
    }

    fn check_lines(&self) -> Result<(), SyncError> {
        for (index, point) in self.points.iter().enumerate() {
            let (before, after) = (self.is_straight(index), self.is_straight(index + 1));
            if let Some(value) = point.blend {
                let refuse = |rule| Err(SyncError::Blend { index, value, rule });
                if !(value.is_finite() && value >= 0.0) {
                    return refuse("a finite deviation that is not negative");
                }
                if !(before && after) {
                    return refuse("between two straight sections");
                }
            }
            for (axis, given) in point.velocity.iter().enumerate() {
                if let (Some(value), true) = (*given, before || after) {
                    let (what, rule) = ("velocity", "free where a straight section begins or ends");
                    return Err(SyncError::WayPoint { index, axis, what, value, rule });
                }
            }
        }
        Ok(())
    }

    /// Returns an error that names what is no motion.
    pub(super) fn check(&self, start: &[AxisState; N]) -> Result<(), SyncError> {
        let count = self.points.len()
            + self.points.iter().filter(|point| point.blend.is_some_and(|deviation| deviation > 0.0)).count();
        if count > MOST_WAY_POINTS {
            return Err(SyncError::TooManyWayPoints { count, most: MOST_WAY_POINTS });
        }
        for (name, state) in
            [(["start.p", "start.v", "start.a"], start), (["target.p", "target.v", "target.a"], &self.target)]
        {
            for (axis, s) in state.iter().enumerate() {
                for (what, value) in name.into_iter().zip([s.p, s.v, s.a]) {
                    if !value.is_finite() {
                        return Err(SyncError::State { axis, source: FeedError::NotFinite { what, value } });
                    }
                }
            }
        }
        for i in 0..self.sections() {
            self.section(i).check()?;
        }
        for (index, point) in self.points.iter().enumerate() {
            let refuse = |axis, what, value, rule| Err(SyncError::WayPoint { index, axis, what, value, rule });
            for axis in 0..N {
                if !point.position[axis].is_finite() {
                    return refuse(axis, "position", point.position[axis], "finite");
                }
                let Some(v) = point.velocity[axis] else { continue };
                let passes = AxisState::new(0.0, v, 0.0);
                let inside = |i: usize| self.limits(i)[axis].contain(&passes);
                if !(v.is_finite() && inside(index) && inside(index + 1)) {
                    return refuse(axis, "velocity", v, "inside the limits of both sections");
                }
            }
        }
        self.check_lines()
    }
}
