//! The joints along a whole path, on a grid of its parameter.

use arcfeed_kinematics::{JointRange, Joints, largest_step};

use super::jet::JointJet;
use super::known_joints::KnownJoints;
use super::motion_path::MotionPath;
use crate::error::PathError;

/// A prediction by Taylor's series may be off by its own step, and by this much in any case (rad), before the joints count as
/// having jumped to another branch.
const SAME_BRANCH: f64 = 0.05;
/// Rounding of a joint value, relative to the range of the joint.
const ROUNDING: f64 = 1e-12;
/// A turning point this near to a grid point (in parts of the interval) takes its place.
const NEAR: f64 = 0.25;
/// Ratio of neighbouring intervals that are inserted.
const GROWTH: f64 = 2.0;
/// A point is not inserted where a grid point is nearer to it than this part of the way to the inserted point before it.
const SAME: f64 = 0.1;
/// No point is inserted nearer to its jump than this part of the path, so that the interval between them can be divided.
const SHORTEST: f64 = 1e-11;

/// Joint values and derivatives at every point of a grid, on one branch of the inverse.
#[derive(Debug, Clone)]
pub struct JointPath<const N: usize = 6> {
    /// Values after each grid point.
    after: Vec<JointJet<N>>,
    /// Values before it: they differ at the path's knots, where derivatives jump.
    before: Vec<JointJet<N>>,
}

impl<const N: usize> JointPath<N> {
    /// Follows `path` over the increasing values `grid` of its parameter. At its knots and at the end derivatives are taken from
    /// both sides.
    ///
    /// # Errors
    /// [`PathError::Arm`] or [`PathError::BranchChange`] with the place.
    pub fn follow(path: &dyn MotionPath<N>, grid: &[f64]) -> Result<Self, PathError> {
        Self::follow_from(path, &path.start(), grid)
    }

    /// The same from the joint values nearest to `start` at the first grid point, which may lie inside the path.
    pub(crate) fn follow_from(path: &dyn MotionPath<N>, start: &Joints<N>, grid: &[f64]) -> Result<Self, PathError> {
        Self::follow_knowing(path, start, grid, &mut KnownJoints::none())
    }

    /// The same where the joints are known at some places.
    pub(crate) fn follow_knowing(
        path: &dyn MotionPath<N>,
        start: &Joints<N>,
        grid: &[f64],
        known: &mut KnownJoints<'_, N>,
    ) -> Result<Self, PathError> {
        let (mut after, mut before) = (Vec::with_capacity(grid.len()), Vec::with_capacity(grid.len()));
        let mut last: Option<JointJet<N>> = None;
        let (knots, end) = (path.knots(), path.length());
        let mut knot = 0;
        for &s in grid {
            // The Taylor series from the grid point before tells where to look, and how far off a jump would be.
            let near = last.map_or(*start, |jet: JointJet<N>| jet.ahead(s - jet.s));
            // What is known may be of another branch, where it was looked for from afar.
            let follows = |jet: &JointJet<N>| match last {
                Some(last) => check_step(path, jet, &near, SAME_BRANCH + (near - last.q).amax()).is_ok(),
                None => true,
            };
            let there = known.at(s).filter(|[_, after]| follows(after));
            let jet = match &there {
                Some([_, after]) => *after,
                None => path.jet(s, &near)?,
            };
            if let Some(last) = last {
                check_step(path, &jet, &near, SAME_BRANCH + (near - last.q).amax())?;
            }
            while knot < knots.len() && knots[knot] < s {
                knot += 1;
            }
            let jumps = knots.get(knot) == Some(&s) || s == end;
            before.push(match there {
                Some([before, _]) => before,
                None if jumps => path.jet_before(&jet)?,
                None => jet,
            });
            after.push(jet);
            last = Some(jet);
        }
        Ok(Self { after, before })
    }

    /// What is known for another grid over the same path, with the joints in the middles of the intervals where they are known.
    pub(crate) fn known<'k>(&'k self, middles: &'k [Option<JointJet<N>>]) -> KnownJoints<'k, N> {
        KnownJoints::of([&self.before, &self.after], middles)
    }

    /// Joint values and derivatives in the middle of every interval where the arm can stand there.
    pub(crate) fn middles(&self, path: &dyn MotionPath<N>, known: &mut KnownJoints<'_, N>) -> Vec<Option<JointJet<N>>> {
        let one = |k: usize| {
            let (a, b) = self.interval(k);
            let h = 0.5 * (b.s - a.s);
            let s = a.s + h;
            known.at(s).map(|[_, jet]| jet).or_else(|| path.jet(s, &((a.ahead(h) + b.ahead(-h)) / 2.0)).ok())
        };
        (0..self.intervals()).map(one).collect()
    }

    /// What both ends of an interval foretell of its middle: the arm stands at both, and where the solution in between is lost, this
    /// will do.
    pub(crate) fn foretold(&self, k: usize) -> JointJet<N> {
        let (a, b) = self.interval(k);
        let h = 0.5 * (b.s - a.s);
        let first = |jet: &JointJet<N>, h: f64| jet.d1 + (jet.d2 + jet.d3 * (h / 2.0)) * h;
        JointJet {
            s: a.s + h,
            q: (a.ahead(h) + b.ahead(-h)) / 2.0,
            d1: (first(a, h) + first(b, -h)) / 2.0,
            d2: (a.d2 + a.d3 * h + b.d2 - b.d3 * h) / 2.0,
            d3: (a.d3 + b.d3) / 2.0,
        }
    }

    /// Checks that every joint is inside `range` at all grid points; a way-point at the very end of a range counts as inside.
    pub(crate) fn check_range(&self, path: &dyn MotionPath<N>, range: &JointRange<N>) -> Result<(), PathError> {
        for jet in &self.after {
            for joint in 0..N {
                let (value, lower, upper) = (jet.q[joint], range.lower()[joint], range.upper()[joint]);
                let rounding = ROUNDING * (upper - lower);
                if !(lower - rounding..=upper + rounding).contains(&value) {
                    return Err(PathError::JointRange { place: path.place(jet.s), joint, value, lower, upper });
                }
            }
        }
        Ok(())
    }

    /// Grid points, with the derivatives after each.
    pub fn nodes(&self) -> &[JointJet<N>] {
        &self.after
    }

    /// Values of the parameter at the grid points.
    pub fn grid(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.after.iter().map(|jet| jet.s)
    }

    /// Number of intervals between grid points.
    pub fn intervals(&self) -> usize {
        self.after.len().saturating_sub(1)
    }

    /// The two ends of interval `i`, each with the derivatives inside the interval.
    pub fn interval(&self, i: usize) -> (&JointJet<N>, &JointJet<N>) {
        (&self.after[i], &self.before[i + 1])
    }

    /// Both one-sided values at grid point `i`: before it, after it.
    pub fn sides(&self, i: usize) -> (&JointJet<N>, &JointJet<N>) {
        (&self.before[i], &self.after[i])
    }

    /// Joint values and derivatives near `s`, by the Taylor series from the grid point before.
    pub fn near(&self, s: f64) -> JointJet<N> {
        let i = self.after.partition_point(|jet| jet.s <= s).saturating_sub(1);
        self.after[i].shifted(s - self.after[i].s)
    }

    /// Puts a grid point at every place where a joint turns back, so that inside the intervals the friction of each joint has one
    /// direction. A grid point that is no knot and near enough gives way.
    pub(crate) fn insert_turning_points(&mut self, path: &dyn MotionPath<N>) -> Result<(), PathError> {
        let mut turns = Vec::new();
        for i in 0..self.intervals() {
            let (from, to) = self.interval(i);
            for joint in (0..N).filter(|&j| from.d1[j] * to.d1[j] < 0.0) {
                turns.push(turning_point(path, from, to, joint)?);
            }
        }
        turns.sort_by(|a, b| a.s.total_cmp(&b.s));
        let mut taken: Vec<f64> = Vec::with_capacity(turns.len());
        for at in turns {
            let i = self.after.partition_point(|jet| jet.s <= at.s).clamp(1, self.after.len() - 1);
            let (s0, s1) = (self.after[i - 1].s, self.after[i].s);
            let closest = if at.s - s0 <= s1 - at.s { i - 1 } else { i };
            let distance = (at.s - self.after[closest].s).abs();
            let movable = closest > 0
                && closest + 1 < self.after.len()
                && !path.knots().contains(&self.after[closest].s)
                && !path.corners().contains(&self.after[closest].s)
                && !taken.contains(&self.after[closest].s);
            if distance < 1e-9 * (s1 - s0) {
                // It stands on the point already.
                self.rest_at(closest, &at);
            } else if distance < NEAR * (s1 - s0) && movable {
                (self.after[closest], self.before[closest]) = (at, at);
            } else {
                self.after.insert(i, at);
                self.before.insert(i, at);
            }
            taken.push(at.s);
        }
        Ok(())
    }

    /// Puts grid points beside some of them. `beside` has grid points and distances, in units of the parameter. A point is put at that
    /// distance before and after the grid point, and more at growing distances up to the next grid point beyond. None is put where a
    /// grid point is about as near.
    pub(crate) fn insert_beside(&mut self, path: &dyn MotionPath<N>, beside: &[(usize, f64)]) -> Result<(), PathError> {
        let mut new = Vec::new();
        let least = SHORTEST * self.after.last().map_or(0.0, |end| end.s);
        for &(i, distance) in beside {
            let (s, distance) = (self.after[i].s, distance.max(least));
            let is_beyond = |jet: &&JointJet<N>| (jet.s - s).abs() > distance;
            let before = self.after[..i].iter().rev().find(is_beyond);
            let after = self.after[i + 1..].iter().find(is_beyond);
            for (next, sign) in [(before, -1.0), (after, 1.0)] {
                let Some(next) = next else { continue };
                let (mut away, mut step) = (distance, distance);
                while away + 0.5 * step < (next.s - s).abs() {
                    new.push((s + sign * away, step));
                    step *= GROWTH;
                    away += step;
                }
            }
        }
        new.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (s, step) in new {
            let i = self.after.partition_point(|jet| jet.s <= s).max(1);
            let last = &self.after[i - 1];
            // Of knots that nearly coincide each asks for much the same points.
            if s - last.s < SAME * step || self.after.get(i).is_some_and(|next| next.s - s < SAME * step) {
                continue;
            }
            let jet = path.jet(s, &last.ahead(s - last.s))?;
            self.after.insert(i, jet);
            self.before.insert(i, jet);
        }
        Ok(())
    }

    /// The joints that turn back at `at` stand still at grid point `i`.
    fn rest_at(&mut self, i: usize, at: &JointJet<N>) {
        for joint in (0..N).filter(|&j| at.d1[j] == 0.0) {
            (self.after[i].d1[joint], self.before[i].d1[joint]) = (0.0, 0.0);
        }
    }
}

/// The place between two others where `joint` turns back, by Newton's method inside a shrinking bracket.
fn turning_point<const N: usize>(
    path: &dyn MotionPath<N>,
    from: &JointJet<N>,
    to: &JointJet<N>,
    joint: usize,
) -> Result<JointJet<N>, PathError> {
    let (mut low, mut high) = (from.s, to.s);
    let share = from.d1[joint] / (from.d1[joint] - to.d1[joint]);
    let mut s = low + share * (high - low);
    let mut jet = *from;
    for _ in 0..60 {
        jet = path.jet(s, &jet.ahead(s - jet.s))?;
        let rate = jet.d1[joint];
        if rate == 0.0 || high - low <= 1e-14 * high {
            break;
        }
        if (rate > 0.0) == (from.d1[joint] > 0.0) {
            low = s
        } else {
            high = s
        }
        let newton = s - rate / jet.d2[joint];
        let next = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
        if (next - s).abs() <= 1e-15 * s.abs() {
            break;
        }
        s = next;
    }
    jet.d1[joint] = 0.0;
    Ok(jet)
}

/// A step that misses the prediction by more than `allowed` (rad) is a change of branch.
pub(crate) fn check_step<const N: usize>(
    path: &dyn MotionPath<N>,
    jet: &JointJet<N>,
    predicted: &Joints<N>,
    allowed: f64,
) -> Result<(), PathError> {
    let (joint, jump) = largest_step(&jet.q, predicted);
    // Not `jump > allowed`: a NaN has to show.
    if jump <= allowed {
        return Ok(());
    }
    let predicted = predicted.iter().copied().collect();
    Err(PathError::BranchChange { place: path.place(jet.s), joint, jump, predicted })
}
