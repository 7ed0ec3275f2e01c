//! The joint path: joint values and their derivatives by arc length, on a grid that knows the path's own knots.

use arcfeed_geometry::{PoseJet, PosePath};
use arcfeed_kinematics::{AnalyticInverse, Joints, ToolDerivatives, largest_step};

use crate::arm::PathArm;
use crate::error::PlanError;

/// Joint values and three derivatives by arc length at one place of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointJet<const N: usize = 6> {
    /// Arc length, m.
    pub s: f64,
    /// Joint values, rad.
    pub q: Joints<N>,
    /// dq/ds, rad/m.
    pub d1: Joints<N>,
    /// d2q/ds2, rad/m^2.
    pub d2: Joints<N>,
    /// d3q/ds3, rad/m^3.
    pub d3: Joints<N>,
}

impl<const N: usize> JointJet<N> {
    /// Joint values a distance `h` (m) further on, by the Taylor series to third order.
    #[inline]
    pub fn ahead(&self, h: f64) -> Joints<N> {
        self.q + (self.d1 + (self.d2 / 2.0 + self.d3 * (h / 6.0)) * h) * h
    }
}

/// Joint values and derivatives at `s`, by the closed-form inverse nearest to `seed` and the Jacobian.
///
/// # Errors
/// [`PlanError::Arm`] with the place.
#[inline]
pub fn joint_jet<A, const N: usize>(arm: &A, s: f64, tool: &PoseJet, seed: &Joints<N>) -> Result<JointJet<N>, PlanError>
where
    A: PathArm<N> + ?Sized,
{
    let fail = |source| PlanError::Arm { s, position: tool.pose.translation.vector.into(), source };
    let q = arm.inverse(&tool.pose, seed).map_err(fail)?;
    joint_jet_at(arm, s, tool, q)
}

/// Derivatives by arc length at `s`, where the joints are known to be `q`.
fn joint_jet_at<A, const N: usize>(arm: &A, s: f64, tool: &PoseJet, q: Joints<N>) -> Result<JointJet<N>, PlanError>
where
    A: PathArm<N> + ?Sized,
{
    let derivatives = ToolDerivatives { first: tool.d1, second: tool.d2, third: tool.d3 };
    let d = arm.derivatives(&q, &derivatives).map_err(|source| PlanError::Arm {
        s,
        position: tool.pose.translation.vector.into(),
        source,
    })?;
    Ok(JointJet { s, q, d1: d.first, d2: d.second, d3: d.third })
}

/// Joint values and derivatives along a whole path, on a grid of arc lengths.
#[derive(Debug, Clone)]
pub struct JointPath<const N: usize = 6> {
    /// Values from the right at each grid point.
    right: Vec<JointJet<N>>,
    /// Values from the left: they differ at the path's knots, where higher derivatives jump.
    left: Vec<JointJet<N>>,
}

impl<const N: usize> JointPath<N> {
    /// Follows `path` from `start` over the increasing arc lengths `grid`, staying on one branch of the inverse.
    ///
    /// `start` is refined to the exact solution nearest to it. `knots` are the arc lengths where derivatives may jump;
    /// there they are taken from both sides.
    ///
    /// # Errors
    /// [`PlanError::Arm`] or [`PlanError::BranchChange`] with the place.
    pub fn new<A>(arm: &A, path: &PosePath, start: &Joints<N>, grid: &[f64], knots: &[f64]) -> Result<Self, PlanError>
    where
        A: PathArm<N> + ?Sized,
    {
        let (mut right, mut left) = (Vec::with_capacity(grid.len()), Vec::<JointJet<N>>::with_capacity(grid.len()));
        let mut last: Option<JointJet<N>> = None;
        let mut knot = 0;
        for &s in grid {
            // The Taylor series from the grid point before tells where to look, and how far off a jump would be.
            let seed = last.map_or(*start, |jet: JointJet<N>| jet.ahead(s - jet.s));
            let tool = path.jet(s);
            let jet = joint_jet(arm, s, &tool, &seed)?;
            if let Some(before) = last {
                check_step(&jet, &seed, 0.05 + (seed - before.q).amax())?;
            }
            while knot < knots.len() && knots[knot] < s {
                knot += 1;
            }
            let on_knot = knots.get(knot) == Some(&s) && s > 0.0;
            left.push(if on_knot { joint_jet_at(arm, s, &path.jet_left(s), jet.q)? } else { jet });
            right.push(jet);
            last = Some(jet);
        }
        Ok(Self { right, left })
    }

    /// Grid points, with the derivatives from the right.
    pub fn nodes(&self) -> &[JointJet<N>] {
        &self.right
    }

    /// Number of intervals between grid points.
    pub fn intervals(&self) -> usize {
        self.right.len().saturating_sub(1)
    }

    /// The two ends of interval `i`, each with the derivatives inside the interval.
    pub fn interval(&self, i: usize) -> (&JointJet<N>, &JointJet<N>) {
        (&self.right[i], &self.left[i + 1])
    }

    /// Both one-sided values at grid point `i`: from the left, from the right.
    pub fn sides(&self, i: usize) -> (&JointJet<N>, &JointJet<N>) {
        (&self.left[i], &self.right[i])
    }

    /// Joint values and derivatives near `s`, by the Taylor series from the grid point before.
    pub(crate) fn near_jet(&self, s: f64) -> JointJet<N> {
        let i = self.right.partition_point(|jet| jet.s <= s).saturating_sub(1);
        let (jet, h) = (self.right[i], s - self.right[i].s);
        let d1 = jet.d1 + (jet.d2 + jet.d3 * (0.5 * h)) * h;
        JointJet { s, q: jet.ahead(h), d1, d2: jet.d2 + jet.d3 * h, d3: jet.d3 }
    }

    /// Joint values near `s`, good enough as a seed: Taylor series from the grid point before.
    pub fn near(&self, s: f64) -> Joints<N> {
        let i = self.right.partition_point(|jet| jet.s <= s).saturating_sub(1);
        self.right[i].ahead(s - self.right[i].s)
    }
}

/// A step that misses the prediction by more than `allowed` (rad) is a change of branch.
fn check_step<const N: usize>(jet: &JointJet<N>, predicted: &Joints<N>, allowed: f64) -> Result<(), PlanError> {
    let (joint, jump) = largest_step(&jet.q, predicted);
    if jump > allowed {
        return Err(PlanError::BranchChange { s: jet.s, joint, jump, predicted: predicted.iter().copied().collect() });
    }
    Ok(())
}

/// The configuration from which the path can be followed best: among all that reach its start, the one that stays
/// farthest from singular poses and joint limits on a coarse walk along the path.
///
/// # Errors
/// [`PlanError::Arm`] when the start is out of reach, [`PlanError::NoConfiguration`] when no branch gets to the end.
pub fn best_start<A, const N: usize>(
    arm: &A,
    path: &PosePath,
    lower: &Joints<N>,
    upper: &Joints<N>,
) -> Result<Joints<N>, PlanError>
where
    A: PathArm<N> + AnalyticInverse<N> + ?Sized,
{
    best_start_of(arm, path, lower, upper).map(|(_, start)| start)
}

/// [`best_start`] with its quality: the more, the better.
pub(crate) fn best_start_of<A, const N: usize>(
    arm: &A,
    path: &PosePath,
    lower: &Joints<N>,
    upper: &Joints<N>,
) -> Result<(f64, Joints<N>), PlanError>
where
    A: PathArm<N> + AnalyticInverse<N> + ?Sized,
{
    const WALK: usize = 64;
    let start = path.jet(0.0);
    let fail = |source| PlanError::Arm { s: 0.0, position: start.pose.translation.vector.into(), source };
    let candidates = arm.inverse_all(&start.pose).map_err(fail)?;
    let length = path.length();
    let grid: Vec<f64> = (0..=WALK).map(|i| length * i as f64 / WALK as f64).collect();
    let middle = (lower + upper) / 2.0;
    let mut best: Option<(f64, Joints<N>)> = None;
    let mut farthest: Option<(f64, PlanError)> = None;
    for candidate in candidates.iter() {
        // The representative nearest to the middle of the joint ranges leaves most room for turning on.
        let seed =
            candidate.zip_map(&middle, |q, m| q + ((m - q) / std::f64::consts::TAU).round() * std::f64::consts::TAU);
        match walk_from_any_turn(arm, path, seed, &grid, lower, upper) {
            Ok((quality, start)) => {
                if best.as_ref().is_none_or(|b| quality > b.0) {
                    best = Some((quality, start));
                }
            }
            Err((s, error)) => {
                if farthest.as_ref().is_none_or(|f| s > f.0) {
                    farthest = Some((s, error));
                }
            }
        }
    }
    match (best, farthest) {
        (Some(best), _) => Ok(best),
        (None, Some((_, error))) => {
            Err(PlanError::NoConfiguration { candidates: candidates.len(), best: Box::new(error) })
        }
        // `inverse_all` is never empty, so one of the two is there.
        (None, None) => Ok((0.0, middle)),
    }
}

/// [`walk`], and where a joint uses up its range on the way, again with that joint a turn further from that end of it.
/// Returns the quality and the start that was used.
fn walk_from_any_turn<A, const N: usize>(
    arm: &A,
    path: &PosePath,
    mut start: Joints<N>,
    grid: &[f64],
    lower: &Joints<N>,
    upper: &Joints<N>,
) -> Result<(f64, Joints<N>), (f64, PlanError)>
where
    A: PathArm<N> + ?Sized,
{
    for _ in 0..N {
        match walk(arm, path, &start, grid, lower, upper) {
            Err((s, PlanError::JointRange { joint, value, lower: low, upper: high, s: place })) => {
                let turn = if value < low { std::f64::consts::TAU } else { -std::f64::consts::TAU };
                if !(low..=high).contains(&(start[joint] + turn)) {
                    return Err((s, PlanError::JointRange { joint, value, lower: low, upper: high, s: place }));
                }
                start[joint] += turn;
            }
            other => return other.map(|quality| (quality, start)),
        }
    }
    walk(arm, path, &start, grid, lower, upper).map(|quality| (quality, start))
}

/// A walk takes steps down to this part of the path before a jump counts as one.
const SHORTEST_STEP: f64 = 1e-8;

/// Least of (smallest singular value, distance to a joint limit / 10) on a coarse walk; or how far it got and why it
/// stopped. Where a step is not what the one before foretold it is halved: a winding path bends a lot between two
/// places of the walk.
fn walk<A, const N: usize>(
    arm: &A,
    path: &PosePath,
    seed: &Joints<N>,
    grid: &[f64],
    lower: &Joints<N>,
    upper: &Joints<N>,
) -> Result<f64, (f64, PlanError)>
where
    A: PathArm<N> + ?Sized,
{
    let shortest = SHORTEST_STEP * path.length();
    let mut last: Option<JointJet<N>> = None;
    let mut quality = f64::INFINITY;
    let mut ahead: Vec<f64> = grid.iter().rev().copied().collect();
    while let Some(&s) = ahead.last() {
        let near = last.map_or(*seed, |jet: JointJet<N>| jet.q);
        let jet = joint_jet(arm, s, &path.jet(s), &near).map_err(|e| (s, e))?;
        if let Some(before) = last
            && let Err(jump) = check_step(&jet, &before.ahead(s - before.s), 1.0)
        {
            if s - before.s > shortest {
                ahead.push(before.s + 0.5 * (s - before.s));
                continue;
            }
            return Err((s, jump.within(lower, upper)));
        }
        ahead.pop();
        let room = (jet.q - lower).zip_map(&(upper - jet.q), f64::min).min();
        let sigma = arcfeed_kinematics::smallest_singular_value(&arm.jacobian(&jet.q));
        quality = quality.min(sigma).min(0.1 * room);
        last = Some(jet);
    }
    Ok(quality)
}
