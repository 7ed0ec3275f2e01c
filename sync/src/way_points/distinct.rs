//! Points that are given twice: passed at once.

use arcfeed_feedrate::{AxisLimits, AxisState};

use super::route::{Route, Section, WayPoint};
use super::trajectory::{SectionKind, WayPointTrajectory};
use super::{MOST_WAY_POINTS, NODES};

/// The route without points that are in the place before them and can be passed together with it.
pub(super) struct Distinct<const N: usize> {
    points: [WayPoint<N>; MOST_WAY_POINTS],
    count: usize,
    last: Section<N>,
    /// The node of this route for each node of the whole one.
    nodes: [usize; NODES],
}

impl<const N: usize> Distinct<N> {
    /// `None` if every point is in a place of its own.
    pub fn new(start: &[AxisState; N], route: &Route<'_, N>) -> Option<Self> {
        let n = route.sections();
        let mut all = Self {
            points: [WayPoint::new([0.0; N]); MOST_WAY_POINTS],
            count: 0,
            last: *route.section(n),
            nodes: [0; NODES],
        };
        let (mut place, mut velocity) = (start.map(|s| s.p), start.map(|s| Some(s.v)));
        for (i, point) in route.points.iter().enumerate() {
            let both = together(&velocity, &point.velocity());
            let here = point.position() == place && point.section == Section::FREE;
            // The section before the place remains, and the one after it.
            let before = all.count.checked_sub(1).map(|last| route.limits_of(&all.points[last].section));
            let after = all.count.checked_sub(1).map(|_| route.limits(i + 1));
            let kept = |both: &_| before.is_none_or(|l| inside(both, l)) && after.is_none_or(|l| inside(both, l));
            match both.filter(|both| here && kept(both)) {
                Some(both) => velocity = both,
                None => {
                    all.points[all.count] = *point;
                    all.count += 1;
                    (place, velocity) = (point.position(), point.velocity());
                }
            }
            if let Some(last) = all.count.checked_sub(1) {
                all.points[last].take_velocity(velocity);
            }
            all.nodes[i + 1] = all.count;
        }
        all.nodes[n] = all.count + 1;
        let target = route.target;
        let ends = target.map(|s| s.p) == place && all.last == Section::FREE;
        if let Some(last) = all.count.checked_sub(1).filter(|_| ends) {
            let section = all.points[last].section;
            let fits = target.iter().zip(route.limits_of(&section)).all(|(s, l)| l.contain(s));
            if fits && together(&velocity, &target.map(|s| Some(s.v))).is_some() {
                // The target takes the place of the last point.
                (all.count, all.last) = (last, section);
                all.nodes[n] = all.count + 1;
            }
        }
        (all.count < route.points.len()).then_some(all)
    }

    /// The shorter route.
    pub fn route<'a>(&'a self, whole: &Route<'a, N>) -> Route<'a, N> {
        whole.through(&self.points[..self.count], self.last)
    }

    /// Makes the motion along the shorter route one along the whole: sections between equal points take no time.
    pub fn expand(&self, motion: &mut WayPointTrajectory<N>, sections: usize) {
        motion.sections = sections;
        // Backward: what is read is not written yet.
        for i in (0..sections).rev() {
            let (from, to) = (self.nodes[i], self.nodes[i + 1]);
            let section = to.saturating_sub(1);
            motion.states[i + 1] = motion.states[to];
            motion.limits[i] = motion.limits[section];
            (motion.durations[i], motion.kinds[i]) =
                if from == to { (0.0, SectionKind::Again) } else { (motion.durations[section], motion.kinds[section]) };
        }
    }
}

/// Returns true if the velocities that are given are inside the limits.
fn inside<const N: usize>(velocity: &[Option<f64>; N], limits: &[AxisLimits; N]) -> bool {
    velocity.iter().zip(limits).all(|(v, l)| v.is_none_or(|v| l.contain(&AxisState::new(0.0, v, 0.0))))
}

/// The velocities that both ask for; `None` if they differ.
fn together<const N: usize>(x: &[Option<f64>; N], y: &[Option<f64>; N]) -> Option<[Option<f64>; N]> {
    let differ = x.iter().zip(y).any(|(x, y)| x.zip(*y).is_some_and(|(x, y)| x != y));
    (!differ).then(|| std::array::from_fn(|k| x[k].or(y[k])))
}
