//! What a schedule knows of its path on the grid, and the limits that need more than derivatives as rows.

use arcfeed_feedrate::constraint::{PathConstraint, Place, RowSink};
use arcfeed_feedrate::{Quantity, Row, RowSource};
use arcfeed_kinematics::{Dynamics, ForwardKinematics, Joints, PathTorque};

use super::SchedulePath;
use super::arm_motion::same_branch;
use crate::error::PlanError;
use crate::joint_path::JointJet;

/// A prediction by Taylor's series may be off by this much of the step, and by this much in any case (rad), before the
/// joints count as having jumped to another branch.
const SAME_BRANCH: (f64, f64) = (1.0, 0.05);

/// Speeds of the tool by the parameter: of its point (m) and angular (rad).
#[derive(Debug, Clone, Copy)]
pub(super) struct ToolRates {
    pub linear: f64,
    pub angular: f64,
}

impl ToolRates {
    pub fn of<const N: usize>(arm: &dyn ForwardKinematics<N>, q: &Joints<N>, d1: &Joints<N>) -> Self {
        let twist = arm.jacobian(q) * d1;
        Self { linear: twist.fixed_rows::<3>(0).norm(), angular: twist.fixed_rows::<3>(3).norm() }
    }
}

/// The path at the grid points, and in the middle between two where that is asked for.
#[derive(Debug, Clone, Default)]
pub(super) struct PathSamples<const N: usize> {
    pub s: Vec<f64>,
    pub points: Vec<JointJet<N>>,
    /// First to third derivatives, joint by joint, point by point; then the third ones just before the points.
    pub after: [Vec<f64>; 3],
    pub third_before: Vec<f64>,
    /// First and second derivatives in the middle of the intervals.
    pub middle: [Vec<f64>; 2],
    /// Torque terms at the points (just after them) and in the middles.
    pub torques: [Vec<PathTorque<N>>; 2],
    /// Torque terms just before those points at which a joint turns back, so that its Coulomb friction jumps.
    pub torques_before: Vec<(usize, PathTorque<N>)>,
    pub tool: [Vec<ToolRates>; 2],
}

/// What is to be known of the path.
#[derive(Clone, Copy)]
pub(super) struct Wanted<'a, const N: usize> {
    pub dynamics: Option<&'a dyn Dynamics<N>>,
    pub tool: Option<&'a dyn ForwardKinematics<N>>,
    pub middles: bool,
}

impl<const N: usize> PathSamples<N> {
    /// Follows `path` over about `intervals` equal steps. Knots of the path are grid points, and so are, where torques are
    /// wanted, the places at which a joint turns back: inside the intervals friction then has one direction.
    pub fn follow<P>(path: &P, intervals: usize, wanted: Wanted<'_, N>) -> Result<Self, PlanError>
    where
        P: SchedulePath<N> + ?Sized,
    {
        let mut points = walk(path, &grid(path.end(), path.knots(), intervals))?;
        let turns = match wanted.dynamics {
            Some(_) => insert_turns(path, &mut points)?,
            None => Vec::new(),
        };
        let n = points.len();
        let mut this = Self { s: points.iter().map(|jet| jet.s).collect(), ..Self::default() };
        for list in this.after.iter_mut().chain([&mut this.third_before]) {
            list.reserve_exact(n * N);
        }
        this.torques[0].reserve_exact(if wanted.dynamics.is_some() { n } else { 0 });
        let mut turns = turns.into_iter().peekable();
        for (i, jet) in points.iter().enumerate() {
            for (list, values) in this.after.iter_mut().zip([&jet.d1, &jet.d2, &jet.d3]) {
                list.extend_from_slice(values.as_slice());
            }
            this.third_before.extend_from_slice(path.third_before(jet).as_slice());
            let (mut rates, mut rates_before) = (jet.d1, jet.d1);
            while let Some((_, joint)) = turns.next_if(|turn| turn.0 == jet.s) {
                // Nothing but a direction: the joint stands still here.
                rates[joint] = f64::MIN_POSITIVE.copysign(jet.d2[joint]);
                rates_before[joint] = -rates[joint];
            }
            if let Some(dynamics) = wanted.dynamics {
                let torque = |rates: &Joints<N>| {
                    let torque = dynamics.along_path(&jet.q, rates, &jet.d2);
                    // A direction is no speed.
                    PathTorque {
                        viscous: torque.viscous.zip_map(&jet.d1, |c, d| if d == 0.0 { 0.0 } else { c }),
                        ..torque
                    }
                };
                this.torques[0].push(torque(&rates));
                if rates != rates_before {
                    this.torques_before.push((i, torque(&rates_before)));
                }
            }
            if let Some(arm) = wanted.tool {
                this.tool[0].push(ToolRates::of(arm, &jet.q, &jet.d1));
            }
            if let Some(next) = points.get(i + 1).filter(|_| wanted.middles) {
                let h = next.s - jet.s;
                let middle = path.jet(jet.s + 0.5 * h, &jet.ahead(0.5 * h))?;
                this.middle[0].extend_from_slice(middle.d1.as_slice());
                this.middle[1].extend_from_slice(middle.d2.as_slice());
                this.torques[1].extend(wanted.dynamics.map(|d| d.along_path(&middle.q, &middle.d1, &middle.d2)));
                this.tool[1].extend(wanted.tool.map(|arm| ToolRates::of(arm, &middle.q, &middle.d1)));
            }
        }
        this.points = points;
        Ok(this)
    }

    /// Torque terms just before grid point `i`, if they differ from those after it.
    fn torque_before(&self, i: usize) -> Option<&PathTorque<N>> {
        let at = self.torques_before.binary_search_by_key(&i, |turn| turn.0).ok()?;
        Some(&self.torques_before[at].1)
    }
}

/// The joints at every grid point, by continuity from the start.
fn walk<P, const N: usize>(path: &P, grid: &[f64]) -> Result<Vec<JointJet<N>>, PlanError>
where
    P: SchedulePath<N> + ?Sized,
{
    let mut points = Vec::<JointJet<N>>::with_capacity(grid.len() + N);
    for &s in grid {
        let Some(last) = points.last() else {
            points.push(path.jet(s, &path.start())?);
            continue;
        };
        // The Taylor series from the grid point before tells where to look, and how far off a jump would be.
        let near = last.ahead(s - last.s);
        let jet = path.jet(s, &near)?;
        let allowed = SAME_BRANCH.1 + SAME_BRANCH.0 * (near - last.q).amax();
        same_branch(path.parameter(), s, &jet.q, &near, allowed)?;
        points.push(jet);
    }
    Ok(points)
}

/// A turning point this near to a grid point (in parts of the interval) takes its place.
const NEAR: f64 = 0.25;

/// Puts a grid point at every place where a joint turns back; returns these places with the joints, in order.
fn insert_turns<P, const N: usize>(path: &P, points: &mut Vec<JointJet<N>>) -> Result<Vec<(f64, usize)>, PlanError>
where
    P: SchedulePath<N> + ?Sized,
{
    let mut turns = Vec::new();
    for pair in points.windows(2) {
        for joint in (0..N).filter(|&j| pair[0].d1[j] * pair[1].d1[j] < 0.0) {
            turns.push((turn(path, &pair[0], &pair[1], joint)?, joint));
        }
    }
    turns.sort_by(|a, b| a.0.s.total_cmp(&b.0.s));
    let mut done = Vec::with_capacity(turns.len());
    for (mut at, joint) in turns {
        let after = points.partition_point(|jet| jet.s <= at.s).clamp(1, points.len() - 1);
        let (s0, s1) = (points[after - 1].s, points[after].s);
        let near = NEAR * (s1 - s0);
        let movable = |i: usize| i > 0 && i + 1 < points.len() && !path.knots().contains(&points[i].s);
        let taken = |s: f64| done.iter().any(|turn: &(f64, usize)| turn.0 == s);
        let closest = if at.s - s0 <= s1 - at.s { after - 1 } else { after };
        if points[closest].s == at.s || (at.s - points[closest].s).abs() < 1e-9 * (s1 - s0) {
            at.s = points[closest].s;
        } else if (at.s - points[closest].s).abs() < near && movable(closest) && !taken(points[closest].s) {
            points[closest] = at;
        } else {
            points.insert(after, at);
        }
        done.push((at.s, joint));
    }
    done.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(done)
}

/// Where `joint` turns back between two places, by Newton's method kept inside a shrinking bracket.
fn turn<P, const N: usize>(
    path: &P,
    from: &JointJet<N>,
    to: &JointJet<N>,
    joint: usize,
) -> Result<JointJet<N>, PlanError>
where
    P: SchedulePath<N> + ?Sized,
{
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

/// Equal steps between the knots, about `intervals` in all.
fn grid(end: f64, knots: &[f64], intervals: usize) -> Vec<f64> {
    let mut grid = Vec::with_capacity(intervals + 2 * knots.len() + 2);
    let mut from = 0.0;
    for &to in knots.iter().chain([&end]) {
        let pieces = ((to - from) / end * intervals as f64).round().max(2.0) as usize;
        grid.extend((0..pieces).map(|i| from + (to - from) * (i as f64 / pieces as f64)));
        from = to;
    }
    grid.push(end);
    grid
}

/// Torques of the drives, with exact rows in the middle of the intervals too.
#[derive(Debug)]
pub(super) struct TorqueRows<'a, const N: usize> {
    pub samples: &'a PathSamples<N>,
    pub limits: Joints<N>,
}

impl<const N: usize> TorqueRows<'_, N> {
    fn push(&self, torque: &PathTorque<N>, out: &mut RowSink<'_>) {
        for j in 0..N {
            let (a, b, c, d) = (torque.inertia[j], torque.velocity[j], torque.viscous[j], torque.constant[j]);
            let (limit, source) = (self.limits[j], RowSource::joint(Quantity::JointTorque, j));
            out.row(Row { a, b, c, d, lo: -limit, hi: limit, source });
        }
    }
}

impl<const N: usize> PathConstraint for TorqueRows<'_, N> {
    fn points(&self) -> Option<usize> {
        Some(self.samples.s.len())
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        match place {
            Place::Point(i) => {
                self.push(&self.samples.torques[0][i], out);
                if let Some(before) = self.samples.torque_before(i) {
                    self.push(before, out);
                }
            }
            Place::Middle { k, .. } => self.push(&self.samples.torques[1][k], out),
        }
    }
}

/// The speed of the tool's point, or its angular speed.
#[derive(Debug)]
pub(super) struct ToolSpeed<'a, const N: usize> {
    pub samples: &'a PathSamples<N>,
    pub limit: f64,
    pub quantity: Quantity,
}

impl<const N: usize> ToolSpeed<'_, N> {
    fn rate(&self, rates: &ToolRates) -> f64 {
        if self.quantity == Quantity::LinearSpeed { rates.linear } else { rates.angular }
    }
}

impl<const N: usize> PathConstraint for ToolSpeed<'_, N> {
    fn points(&self) -> Option<usize> {
        Some(self.samples.s.len())
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        let rates = match place {
            Place::Point(i) => &self.samples.tool[0][i],
            Place::Middle { k, .. } => &self.samples.tool[1][k],
        };
        let speed = self.limit / self.rate(rates);
        if speed.is_finite() {
            out.cap(speed * speed, RowSource::path(self.quantity));
        }
    }

    fn axis_speeds(&self, k: usize, _h: f64, out: &mut dyn FnMut([f64; 3], f64, RowSource)) {
        let [p, m, q] = [&self.samples.tool[0][k], &self.samples.tool[1][k], &self.samples.tool[0][k + 1]]
            .map(|rates| self.rate(rates));
        out([p, 2.0 * m - 0.5 * (p + q), q], self.limit, RowSource::path(self.quantity));
    }
}
