//! The shortest motion with one or two touches of the ends of a range.
//!
//! At a touch the velocity is zero and the acceleration points inwards, so that one number is left
//! of the state there. Between start, touches and target the motion is the shortest one again
//! ([`AxisProblem`]). In nearly all shortest motions one of these legs is a direct change of
//! velocity and acceleration that covers exactly its way: with a weaker touch it would have to swing
//! back first. These touches are roots of a function of one variable. The others minimise the sum of
//! two durations, found by parabolas. The number of legs computed is bounded.

use super::leg::{Leg, backwards, backwards_limits, brakes};
use super::positions::{PositionLimits, hardest_turn, lowest_at_turn, mirrored, mirrored_limits};
use super::profile::StateToState;
use super::search::{MOST_ROOTS, Value, beyond, boundary, minimise, roots};
use crate::limits::AxisLimits;
use crate::state::AxisState;
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// The touches of one end that are tried.
const GRID: usize = 8;
const TOUCHES: usize = 2 * (1 + MOST_ROOTS) + GRID;

/// Relative distance of a place beside another one.
const BESIDE: f64 = 1e-9;

/// Durations computed to improve one touch, and places tried for a boundary.
const STEPS: usize = 12;
const BOUNDARY_STEPS: usize = 10;

/// Rounds that improve two touches in turn, and durations computed for each.
const ROUNDS: usize = 2;
const STEPS_OF_ROUND: usize = 8;

/// Touches are improved if their duration on the grid is not above this part of the shortest one:
/// two touches, and those of one end.
const PROMISING: f64 = 1.08;
const PROMISING_END: f64 = 2.0;

/// A problem, as given or mirrored.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub start: AxisState,
    pub target: AxisState,
    pub limits: AxisLimits,
    pub positions: PositionLimits,
    /// The lowest acceleration at a touch of the upper end that can be reached.
    lowest: f64,
}

/// A sequence of touches and the duration of its motion (s). A touch is given by the square root of
/// its acceleration, as a part of the strongest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touched {
    pub time: f64,
    /// The first touch is at the lower end.
    pub mirrored: bool,
    pub first: f64,
    /// A touch at the other end after it.
    pub second: Option<f64>,
}

impl Touched {
    const NONE: Self = Self { time: f64::INFINITY, mirrored: false, first: 0.0, second: None };

    fn shorter(self, other: Self) -> Self {
        if other.time < self.time { other } else { self }
    }
}

impl Frame {
    pub fn new(start: AxisState, target: AxisState, limits: AxisLimits, positions: PositionLimits) -> Self {
        let mut frame = Self { start, target, limits, positions, lowest: 0.0 };
        // From a state inside the limits the velocity keeps its limit before the touch. A start
        // that brakes already may be one whose past does not.
        let inside = lowest_at_turn(&frame.backwards().1);
        frame.lowest =
            if start.v > 0.0 && brakes(&start) { inside.min(hardest_turn(&start, &limits).a) } else { inside };
        frame
    }

    /// The same problem upside down.
    pub fn mirrored(&self) -> Self {
        let positions = PositionLimits::new(-self.positions.upper(), -self.positions.lower());
        let (start, target) = (mirrored(&self.start), mirrored(&self.target));
        Self::new(start, target, mirrored_limits(&self.limits), positions.unwrap_or(self.positions))
    }

    /// The target backwards in time, and the limits that hold then.
    pub const fn backwards(&self) -> (AxisState, AxisLimits) {
        (backwards(&self.target), backwards_limits(&self.limits))
    }

    /// The state at the upper end.
    fn touch(&self, root: f64) -> AxisState {
        AxisState::new(self.positions.upper(), 0.0, root * root * self.lowest)
    }

    /// A grid of touches, finer below the strongest with which jerk alone turns the axis at the other
    /// end. After those at the end the velocity would leave its limits if no target came before.
    fn grid(&self) -> [f64; GRID] {
        let width = self.positions.upper() - self.positions.lower();
        let jerk = self.limits.j_max().min(-self.limits.j_min());
        let lowest = self.lowest;
        let last = (lowest_at_turn(&self.limits) / lowest).sqrt().min(1.0);
        let middle = ((1.5 * width * jerk * jerk).cbrt() / -lowest).sqrt().min(0.5 * last);
        std::array::from_fn(|i| match i as f64 {
            i if i < 3.0 => middle * i / 3.0,
            i if i < 7.0 => middle + (last - middle) * (i - 3.0) / 3.0,
            _ => 1.0,
        })
    }

    /// The touches with the accelerations of the hardest and of the softest turn after the start, or
    /// before the target. Beyond them the direct change jumps to another one.
    fn turns(&self, start: bool) -> [f64; 2] {
        let (back, reversed) = self.backwards();
        let (s, l) = if start { (&self.start, &self.limits) } else { (&back, &reversed) };
        // One phase of rising acceleration.
        let softest = if s.a < 0.0 { -(s.a * s.a - 2.0 * l.j_max() * s.v).max(0.0).sqrt() } else { 0.0 };
        [hardest_turn(s, l).a, softest].map(|a| (a / self.lowest).max(0.0).min(1.0).sqrt())
    }

    /// The grid with two places beside the turns, in order.
    fn places(&self, turns: [f64; 2]) -> [f64; GRID + 2] {
        let (grid, beside) = (self.grid(), [turns[0] * (1.0 - BESIDE), (turns[1] * (1.0 + BESIDE)).min(1.0)]);
        let mut all = std::array::from_fn(|i| if i < GRID { grid[i] } else { beside[i - GRID] });
        all.sort_unstable_by(f64::total_cmp);
        all
    }

    /// The shortest motion between two states, if it stays inside.
    pub fn leg(&self, from: &AxisState, to: &AxisState) -> Option<StateToState> {
        let leg = Leg::new(from, to, &self.limits)?;
        let motion = leg.shortest();
        self.permits(&leg, &motion).then_some(motion)
    }

    /// Returns true if the motion of a leg stays inside, and inside the velocity limits unless it
    /// comes back into them after the start.
    pub(super) fn permits(&self, leg: &Leg, motion: &StateToState) -> bool {
        let free = *leg.start() == self.start && !leg.is_backwards();
        self.positions.contain_all_of(motion) && (free || leg.keeps_velocity(motion))
    }

    /// The duration of [`Frame::leg`], infinite if there is none below `most`.
    fn leg_time(&self, from: &AxisState, to: &AxisState, most: f64) -> f64 {
        let Some(leg) = Leg::new(from, to, &self.limits) else { return f64::INFINITY };
        let time = leg.shortest_duration();
        if time < most && self.permits(&leg, &leg.shortest()) { time } else { f64::INFINITY }
    }

    /// How far a leg leaves the range; infinite if there is none.
    fn overshoot(&self, from: &AxisState, to: &AxisState) -> f64 {
        Leg::new(from, to, &self.limits).map_or(f64::INFINITY, |leg| self.positions.overshoot(&leg.shortest()))
    }

    fn lead_overshoot(&self, root: f64) -> f64 {
        self.overshoot(&self.start, &self.touch(root))
    }
    fn go_overshoot(&self, root: f64) -> f64 {
        self.overshoot(&self.touch(root), &self.target)
    }

    /// The duration with one touch.
    fn time_with(&self, root: f64) -> f64 {
        let lead = self.lead_time(root);
        if lead < f64::INFINITY { lead + self.go_time(root) } else { lead }
    }

    fn lead_time(&self, first: f64) -> f64 {
        self.leg_time(&self.start, &self.touch(first), f64::INFINITY)
    }

    fn go_time(&self, last: f64) -> f64 {
        self.leg_time(&self.touch(last), &self.target, f64::INFINITY)
    }

    /// How much farther than its way the direct change between two states goes.
    fn excess(&self, from: &AxisState, to: &AxisState) -> f64 {
        Leg::direct_displacement(from, to, &self.limits).map_or(f64::NAN, |d| d - (to.p - from.p))
    }

    /// The touches to which the way from the start is a direct change, or those from which the way to
    /// the target is one.
    fn direct(&self, start: bool) -> [f64; MOST_ROOTS] {
        let (touch, places) = (|root: f64| self.touch(root), self.places(self.turns(start)));
        // Where the peak after a swing back is outside, a stronger touch lowers it.
        if start {
            let found = roots(|x| self.excess(&self.start, &touch(x)), |x| self.lead_time(x), &places);
            found.map(|x| beyond(|x| self.lead_overshoot(x), x))
        } else {
            let found = roots(|x| self.excess(&touch(x), &self.target), |x| self.go_time(x), &places);
            found.map(|x| beyond(|x| self.go_overshoot(x), x))
        }
    }

    /// The shortest motion with touches, as far as the search finds it.
    pub fn search(&self) -> Option<Touched> {
        let frames = [*self, self.mirrored()];
        let sides = [Side::new(&frames[0]), Side::new(&frames[1])];
        let most = PROMISING_END * sides[0].least().min(sides[1].least());
        let mut best = Touched::NONE;
        for i in 0..2 {
            let improved = sides[i].improved(&frames[i], most);
            best = best.shorter(Touched { mirrored: i == 1, ..improved });
        }
        for i in 0..2 {
            let pair = Pair { frame: &frames[i], other: &frames[1 - i] };
            best = best.shorter(Touched { mirrored: i == 1, ..pair.search((&sides[i], &sides[1 - i]), best.time) });
        }
        (best.time < f64::INFINITY).then_some(best)
    }

    /// Single touches of either end.
    pub fn single_touches(&self) -> impl Iterator<Item = Touched> {
        let (upper, lower) = (*self, self.mirrored());
        let ends = [(false, upper), (true, lower)].into_iter().filter(|(_, frame)| frame.positions.upper().is_finite());
        ends.flat_map(|(mirrored, frame)| frame.grid().map(|first| Touched { mirrored, first, ..Touched::NONE }))
    }

    /// The states at start, touches and target, and the number of legs between them.
    pub fn states(&self, touched: &Touched) -> ([AxisState; 4], usize) {
        let mirror = self.mirrored();
        let end = |lower: bool, root: f64| if lower { mirrored(&mirror.touch(root)) } else { self.touch(root) };
        let first = end(touched.mirrored, touched.first);
        match touched.second {
            None => ([self.start, first, self.target, self.target], 2),
            Some(root) => ([self.start, first, end(!touched.mirrored, root), self.target], 3),
        }
    }

    /// The motion with touches.
    pub fn motion(&self, touched: &Touched) -> Option<StateToState> {
        let (states, legs) = self.states(touched);
        let mut motion = self.leg(&states[0], &states[1])?;
        for i in 1..legs {
            motion = StateToState::joined(&motion, 0.0, &self.leg(&states[i], &states[i + 1])?)?;
        }
        Some(motion)
    }
}

/// The legs from the start to the touches of the upper end, and from there to the target.
struct Side {
    roots: [f64; TOUCHES],
    lead: [f64; TOUCHES],
    go: [f64; TOUCHES],
}

impl Side {
    fn new(frame: &Frame) -> Self {
        let none = [f64::INFINITY; TOUCHES];
        let mut side = Self { roots: [0.0; TOUCHES], lead: none, go: none };
        if !frame.positions.upper().is_finite() {
            return side;
        }
        let hardest = [frame.turns(true)[0], frame.turns(false)[0]];
        let (to, from) = (frame.direct(true), frame.direct(false));
        for (x, root) in side.roots.iter_mut().zip(frame.grid().into_iter().chain(hardest).chain(to).chain(from)) {
            *x = root;
        }
        for (i, root) in side.roots.into_iter().enumerate() {
            if !root.is_nan() {
                (side.lead[i], side.go[i]) = (frame.lead_time(root), frame.go_time(root));
            }
        }
        side
    }

    /// The nearest touches.
    fn around(&self, root: f64) -> (f64, f64) {
        let below = self.roots.iter().filter(|x| **x < root).fold(0.0, |x: f64, y| x.max(*y));
        let above = self.roots.iter().filter(|x| **x > root).fold(1.0, |x: f64, y| x.min(*y));
        (below, above)
    }

    /// The shortest duration with one of the touches.
    fn least(&self) -> f64 {
        self.lead.iter().zip(&self.go).fold(f64::INFINITY, |least, (lead, go)| least.min(lead + go))
    }

    /// The best touch alone, improved; none if it lasts longer than `most`.
    fn improved(&self, frame: &Frame, most: f64) -> Touched {
        let tried = (0..TOUCHES).map(|i| Value { at: self.roots[i], value: self.lead[i] + self.go[i] });
        let best = tried.min_by(|x, y| x.value.total_cmp(&y.value)).filter(|best| best.value.is_finite());
        let Some(mut best) = best.or_else(|| self.between(frame)) else { return Touched::NONE };
        if best.value > most {
            return Touched::NONE;
        }
        let (root, (below, above)) = (best.at, self.around(best.at));
        let overshoot = |x: f64| frame.lead_overshoot(x).max(frame.go_overshoot(x));
        for beside in [below, above] {
            if frame.time_with(beside) == f64::INFINITY {
                best = best.or(boundary(overshoot, (root, beside), BOUNDARY_STEPS), |x| frame.time_with(x));
            }
        }
        let best = minimise(|x| frame.time_with(x), best, (below, above), STEPS);
        Touched { time: best.value, first: best.at, ..Touched::NONE }
    }

    /// A touch between two, of which one can be reached and the other one left.
    fn between(&self, frame: &Frame) -> Option<Value> {
        let reached = |i: &usize| self.lead[*i] < f64::INFINITY;
        let left = |i: &usize| self.go[*i] < f64::INFINITY;
        let beside = |i: usize, k: usize| {
            let (below, above) = self.around(self.roots[i]);
            self.roots[k] == below || self.roots[k] == above
        };
        let (to, from) = (0..TOUCHES)
            .filter(reached)
            .find_map(|i| (0..TOUCHES).filter(left).find(|k| beside(i, *k)).map(|k| (self.roots[i], self.roots[k])))?;
        let none = Value { at: to, value: f64::INFINITY };
        let best = none
            .or(boundary(|x| frame.lead_overshoot(x), (to, from), BOUNDARY_STEPS), |x| frame.time_with(x))
            .or(boundary(|x| frame.go_overshoot(x), (from, to), BOUNDARY_STEPS), |x| frame.time_with(x));
        best.value.is_finite().then_some(best)
    }
}

/// A touch of the upper end of a frame, and a touch of the upper end of the other one after it.
struct Pair<'a> {
    frame: &'a Frame,
    other: &'a Frame,
}

impl Pair<'_> {
    /// The states at both touches, in the frame of the first.
    fn touches(&self, first: f64, second: f64) -> (AxisState, AxisState) {
        (self.frame.touch(first), mirrored(&self.other.touch(second)))
    }

    fn between(&self, first: f64, second: f64, most: f64) -> f64 {
        let (from, to) = self.touches(first, second);
        self.frame.leg_time(&from, &to, most)
    }

    fn excess(&self, first: f64, second: f64) -> f64 {
        let (from, to) = self.touches(first, second);
        self.frame.excess(&from, &to)
    }

    /// The shortest motion with both touches, or none that is shorter than `most`.
    fn search(&self, (first, second): (&Side, &Side), most: f64) -> Touched {
        let positions = &self.frame.positions;
        let fastest = self.frame.limits.v_max().max(-self.frame.limits.v_min());
        let least = (positions.upper() - positions.lower()) / fastest;
        let mut best = Touched { time: most * PROMISING, ..Touched::NONE };
        for i in 0..TOUCHES {
            for k in 0..TOUCHES {
                let ends = first.lead[i] + second.go[k];
                if ends + least < best.time {
                    let (x, y) = (first.roots[i], second.roots[k]);
                    let time = ends + self.between(x, y, best.time - ends);
                    best = best.shorter(Touched { time, first: x, second: Some(y), ..best });
                }
            }
        }
        match best.second {
            None => Touched::NONE,
            Some(y) => self.improved(best, (first.around(best.first), second.around(y))),
        }
    }

    /// Improves both touches in turn, each inside its interval.
    fn improved(&self, best: Touched, (around_x, around_y): ((f64, f64), (f64, f64))) -> Touched {
        let Touched { mut time, first: mut x, .. } = best;
        let (mut y, any) = (best.second.unwrap_or(0.0), f64::INFINITY);
        let (frame, other) = (self.frame, self.other);
        for _ in 0..ROUNDS {
            let go = other.go_time(y);
            let with = |x: f64| frame.lead_time(x) + self.between(x, y, any) + go;
            let direct = roots(|x| self.excess(x, y), |x| self.between(x, y, any), &frame.places([x, x]));
            let found = minimise(
                with,
                direct.into_iter().fold(Value { at: x, value: time }, |best, x| best.or(x, with)),
                around_x,
                STEPS_OF_ROUND,
            );
            (x, time) = (found.at, found.value);
            let lead = frame.lead_time(x);
            let with = |y: f64| lead + self.between(x, y, any) + other.go_time(y);
            let direct = roots(|y| self.excess(x, y), |y| self.between(x, y, any), &other.places([y, y]));
            let found = minimise(
                with,
                direct.into_iter().fold(Value { at: y, value: time }, |best, y| best.or(y, with)),
                around_y,
                STEPS_OF_ROUND,
            );
            (y, time) = (found.at, found.value);
        }
        Touched { time, first: x, second: Some(y), mirrored: false }
    }
}
