//! Straight lines and blends, written as sections.

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};

use super::NODES;
use super::lines::Lines;
use super::route::Route;
use super::trajectory::{SectionKind, WayPointTrajectory, unfree};
use crate::error::SyncError;
use crate::state_to_state::Trajectory;

/// Part of the size of positions that counts as round-off.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

/// Times that the lines are written anew, each with rests beside one that was refused; at last with
/// rests in all points.
const RETRIES: usize = 8;

impl<const N: usize> WayPointTrajectory<N> {
    /// Appends the sections of another motion, which begins where this one ends.
    pub(super) fn append(&mut self, other: &Self) {
        let (n, more) = (self.sections, other.sections);
        self.states[n..=n + more].copy_from_slice(&other.states[..=more]);
        self.durations[n..n + more].copy_from_slice(&other.durations[..more]);
        self.limits[n..n + more].copy_from_slice(&other.limits[..more]);
        self.kinds[n..n + more].copy_from_slice(&other.kinds[..more]);
        self.sections = n + more;
    }

    /// Appends a route of straight lines.
    ///
    /// A start that moves on the first line goes on from there; any other one comes to rest before.
    pub(super) fn add_lines(&mut self, route: &Route<'_, N>) -> Result<(), SyncError> {
        let start = self.states[self.sections];
        if start.iter().any(|s| s.v != 0.0 || s.a != 0.0) {
            if self.write(&start, route).is_ok() {
                return Ok(());
            }
            let rest = self.add_stop(&start, route.limits(0))?;
            return self.write(&rest, route);
        }
        self.write(&start, route)
    }

    fn add_stop(&mut self, start: &[AxisState; N], limits: &[AxisLimits; N]) -> Result<[AxisState; N], SyncError> {
        let mut rest = *start;
        for (axis, s) in rest.iter_mut().enumerate() {
            let stop = StateToState::stop(s, &limits[axis]).map_err(|source| SyncError::State { axis, source })?;
            *s = AxisState::rest(stop.at(stop.duration()).p);
        }
        self.push(SectionKind::Stop, &rest, limits, 0.0)?;
        Ok(rest)
    }

    /// Writes the lines from `start`, with blends, or with rests beside a line that is refused. Nothing
    /// changes if that is refused, too.
    fn write(&mut self, start: &[AxisState; N], route: &Route<'_, N>) -> Result<(), SyncError> {
        let count = route.sections();
        let mut points = [start.map(|s| s.p); NODES];
        for (place, point) in points[1..].iter_mut().zip(route.points) {
            *place = point.position();
        }
        points[count] = route.target.map(|s| s.p);
        let deviation = |i: usize| route.points[i - 1].blend().unwrap_or(0.0);
        let ends = [start.map(|s| s.v), route.target.map(|s| s.v)];
        let lines = Lines::new(&points[..=count], &ends, |i| (route.limits(i), route.least_duration(i)), deviation);
        let mut lines = lines.ok_or(SyncError::OutOfRange)?;
        let was = self.sections;
        for _ in 0..RETRIES {
            let Err((line, error)) = self.write_lines(&lines, &points, route) else { return Ok(()) };
            self.sections = was;
            if !lines.rest_beside(line) {
                return Err(error);
            }
        }
        lines.rest();
        self.write_lines(&lines, &points, route).map_err(|(_, error)| error).inspect_err(|_| self.sections = was)
    }

    /// Writes the lines; an error is that of the line with this index.
    fn write_lines(
        &mut self,
        lines: &Lines<N>,
        points: &[[f64; N]; NODES],
        route: &Route<'_, N>,
    ) -> Result<(), (usize, SyncError)> {
        let count = route.sections();
        for i in 0..count {
            let (limits, least) = (route.limits(i), route.least_duration(i));
            if i + 1 == count {
                self.push(SectionKind::Line, route.target(), limits, least).map_err(|e| (i, e))?;
                break;
            }
            let corner = lines.corner(i + 1, &points[i + 1]);
            self.push(SectionKind::Line, &corner.states[0], limits, least).map_err(|e| (i, e))?;
            if corner.duration > 0.0 {
                let (kind, [_, end]) = (SectionKind::Blend, &corner.states);
                self.push(kind, end, &corner.limits, corner.duration).map_err(|e| (i, e))?;
            }
        }
        Ok(())
    }

    /// Appends a section from the end to a state. A line may not leave the way between its ends.
    fn push(
        &mut self,
        kind: SectionKind,
        to: &[AxisState; N],
        limits: &[AxisLimits; N],
        duration: f64,
    ) -> Result<(), SyncError> {
        let n = self.sections;
        let from = self.states[n];
        let motion = unfree(kind, (&from, to), limits, duration)?;
        if let (SectionKind::Line, Some(axis)) = (kind, turns(&motion, &from, to)) {
            return Err(SyncError::NotStraight { axis });
        }
        (self.states[n + 1], self.limits[n], self.kinds[n]) = (*to, *limits, kind);
        self.durations[n] = if kind == SectionKind::Blend { duration } else { motion.duration() };
        self.sections = n + 1;
        Ok(())
    }
}

/// The first axis that leaves the way between its ends, but for the round-off of all axes: each has that
/// of the one that moves farthest.
fn turns<const N: usize>(motion: &Trajectory<N>, from: &[AxisState; N], to: &[AxisState; N]) -> Option<usize> {
    let size = from.iter().chain(to).fold(0.0, |m: f64, s| m.max(s.p.abs()));
    (0..N).find(|&k| {
        let (way, x, y) = (motion.axes()[k].position_range(), from[k].p, to[k].p);
        let slack = ROUND_OFF * size;
        way.min < x.min(y) - slack || way.max > x.max(y) + slack
    })
}
