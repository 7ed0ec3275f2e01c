//! Four axes along straight lines with blends, some sections free, from any state of motion to rest.
//!
//! Judged from samples and phases: no route is refused; a straight section is on the line between its points; a blend is within its
//! deviation of the lines, and passes its point within it; sections join; all limits hold to 1e-12; no motion is longer than one
//! that rests in every point.

use std::cell::RefCell;

use arcfeed_sync::feedrate::{AxisLimits, AxisState};
use arcfeed_sync::{Route, SectionKind, Trajectory, WayPoint, WayPointPlanner, WayPointTrajectory};
use arcfeed_testing::Random;

use super::{Failure, Outcome, random};

const AXES: usize = 4;

type Point = [f64; AXES];

#[derive(Debug)]
struct Input {
    start: [AxisState; AXES],
    points: Vec<WayPoint<AXES>>,
    target: Point,
    limits: [AxisLimits; AXES],
    straight: Vec<bool>,
}

/// Corners of any kind: any corner, gentle ones, or points on one line.
fn random_places(rng: &mut Random, count: usize) -> Vec<Point> {
    let (size, kind) = (rng.log(1e-3, 2.0), rng.below(3));
    let mut place = [0.0; AXES];
    let mut step: Point = std::array::from_fn(|_| rng.between(-size, size));
    (0..count)
        .map(|_| {
            let turn = |rng: &mut Random| match kind {
                // Any corner; a gentle one; on one line, forward or back.
                0 => std::array::from_fn(|_| if rng.chance(0.3) { 0.0 } else { rng.between(-size, size) }),
                1 => step.map(|x| x + 0.2 * rng.between(-size, size)),
                _ => step.map(|x| x * if rng.chance(0.8) { 1.0 } else { -0.5 }),
            };
            let next: Point = turn(rng);
            step = next;
            place = std::array::from_fn(|k| place[k] + step[k]);
            place
        })
        .collect()
}

impl Input {
    fn new(rng: &mut Random) -> Self {
        let limits: [AxisLimits; AXES] = std::array::from_fn(|_| {
            let mut pair = |lo: f64, hi: f64| (-rng.log(lo, hi), rng.log(lo, hi));
            AxisLimits::new(pair(0.1, 5.0), pair(1.0, 30.0), pair(5.0, 500.0)).expect("limits on both sides of zero")
        });
        let count = if rng.chance(0.9) { 1 + rng.below(8) } else { 1 + rng.below(32) };
        let places = random_places(rng, count + 2);
        let all_straight = rng.chance(0.7);
        let straight: Vec<bool> = (0..=count).map(|_| all_straight || rng.chance(0.6)).collect();
        let points = (0..count).map(|i| {
            let mut point = WayPoint::new(places[i + 1]);
            if straight[i] {
                point = point.with_straight_section();
            }
            if straight[i] && straight[i + 1] && rng.chance(0.8) {
                point = point.with_blend(rng.log(1e-6, 1.0));
            }
            if rng.chance(0.05) {
                point = point.with_least_duration(rng.log(1e-3, 3.0));
            }
            if rng.chance(0.1) {
                let scale = rng.log(0.2, 5.0);
                let pair = |(lo, hi): (f64, f64)| (scale * lo, scale * hi);
                let scaled = |l: &AxisLimits| {
                    AxisLimits::new(
                        pair((l.v_min(), l.v_max())),
                        pair((l.a_min(), l.a_max())),
                        pair((l.j_min(), l.j_max())),
                    )
                };
                point = point.with_limits(limits.each_ref().map(|l| scaled(l).expect("limits on both sides of zero")));
            }
            point
        });
        let points: Vec<_> = points.collect();
        let first = points[0].position();
        let mut start = places[0].map(AxisState::rest);
        match rng.below(4) {
            0 => {
                start = std::array::from_fn(|k| {
                    let l = &limits[k];
                    let s = AxisState::new(
                        start[k].p,
                        rng.between(l.v_min(), l.v_max()),
                        rng.between(l.a_min(), l.a_max()),
                    );
                    if l.contain(&s) { s } else { start[k] }
                });
            }
            1 => {
                // On the first line.
                let share = rng.between(0.0, 0.5);
                let way: Point = std::array::from_fn(|k| first[k] - places[0][k]);
                let most = (0..AXES)
                    .filter(|&k| way[k] != 0.0)
                    .map(|k| (limits[k].v_max() / way[k]).max(limits[k].v_min() / way[k]));
                let rate = share * most.fold(f64::INFINITY, f64::min);
                if rate.is_finite() {
                    start = std::array::from_fn(|k| AxisState::new(places[0][k], rate * way[k], 0.0));
                }
            }
            _ => {}
        }
        Self { start, points, target: places[count + 1], limits, straight }
    }

    fn route(&self) -> Route<'_, AXES> {
        self.route_through(&self.points)
    }

    fn route_through<'a>(&self, points: &'a [WayPoint<AXES>]) -> Route<'a, AXES> {
        let route = Route::new(points, self.target.map(AxisState::rest), self.limits);
        if self.straight[self.points.len()] { route.with_straight_section() } else { route }
    }

    /// By how much the motion breaks what must hold, and what that is.
    fn judge(&self, motion: &WayPointTrajectory<AXES>) -> Option<(String, f64)> {
        let count = motion.section_durations().len();
        let mut here = self.start;
        // The place where the line under way begins, and the index of the next point.
        let (mut from, mut next) = (self.start.map(|s| s.p), 0);
        for i in 0..count {
            let (Ok(section), Ok(kind)) = (motion.section(i), motion.section_kind(i)) else {
                return Some((format!("section {i} is refused"), 1.0));
            };
            let begin: [AxisState; AXES] = std::array::from_fn(|k| axis_state(&section, k, 0.0));
            let jump = (0..AXES).map(|k| off(&begin[k], &here[k])).fold(0.0, f64::max);
            if jump.is_nan() || jump > 1e-11 {
                return Some((format!("section {i} does not begin where the one before ends"), jump));
            }
            here = std::array::from_fn(|k| axis_state(&section, k, section.duration()));
            let ways = Ways { from, to: self.place(next), after: self.place(next + 1) };
            let fault = match kind {
                SectionKind::Blend => ways.off_blend(&section, self.points[next].blend().unwrap_or(0.0)),
                SectionKind::Line => ways.off_line(&section),
                SectionKind::Stop => (i > 0 || here.iter().any(|s| s.v != 0.0)).then_some(1.0),
                _ => self.straight[next].then_some(1.0),
            };
            if let Some(size) = fault {
                return Some((format!("{kind:?} is not what it should be, section {i}"), size));
            }
            // A start outside the limits of the first section is brought back.
            let inside = i > 0 || (0..AXES).all(|k| self.route().limits(0)[k].contain(&self.start[k]));
            let sections = (next, next + usize::from(kind == SectionKind::Blend));
            if let Some(excess) = self.excess(&section, sections).filter(|_| inside) {
                return Some((format!("limits in section {i}, {kind:?}"), excess));
            }
            let blend_follows = motion.section_kind(i + 1) == Ok(SectionKind::Blend);
            if kind == SectionKind::Stop {
                from = here.map(|s| s.p);
            } else if !blend_follows {
                if kind != SectionKind::Blend && length(&here.map(|s| s.p), &ways.to) > 1e-12 {
                    return Some((format!("{kind:?} does not end in its point, section {i}"), 1.0));
                }
                (from, next) = (ways.to, next + 1);
            }
        }
        let missed = (0..AXES).map(|k| off(&here[k], &AxisState::rest(self.target[k]))).fold(0.0, f64::max);
        (missed > 1e-12 || next != self.points.len() + 1).then(|| ("the target is missed".to_owned(), missed))
    }

    fn place(&self, i: usize) -> Point {
        self.points.get(i).map_or(self.target, WayPoint::position)
    }

    /// The excess of a section over the limits of the section to the next point, in a blend also over those of the one after it.
    fn excess(&self, section: &Trajectory<AXES>, (next, last): (usize, usize)) -> Option<f64> {
        let route = self.route();
        let mut worst: f64 = 0.0;
        for (k, axis) in section.axes().iter().enumerate() {
            let beside = [next, last].map(|i| &route.limits(i)[k]);
            let least = |f: fn(&AxisLimits) -> f64| f64::min(f(beside[0]).abs(), f(beside[1]).abs());
            let over = |x: f64, lo: f64, hi: f64| (x / hi).max(-x / lo) - 1.0;
            for (phase, dt) in axis.phases() {
                for s in [0.0, phase.turn(dt).unwrap_or(0.0), dt].map(|t| phase.after(t)) {
                    worst = worst
                        .max(over(s.v, least(AxisLimits::v_min), least(AxisLimits::v_max)))
                        .max(over(s.a, least(AxisLimits::a_min), least(AxisLimits::a_max)))
                        .max(over(s.j, least(AxisLimits::j_min), least(AxisLimits::j_max)));
                }
            }
        }
        (worst.is_nan() || worst > 1e-12).then_some(worst)
    }
}

/// The lines before and after a point.
struct Ways {
    from: Point,
    to: Point,
    after: Point,
}

impl Ways {
    fn off_line(&self, section: &Trajectory<AXES>) -> Option<f64> {
        let worst = samples(section).map(|q| distance(&q, &self.from, &self.to)).fold(0.0, f64::max);
        (worst > 1e-12 * size(&self.to)).then_some(worst)
    }

    /// The middle sample is the one that is nearest to the point.
    fn off_blend(&self, section: &Trajectory<AXES>, deviation: f64) -> Option<f64> {
        let lines = |q: &Point| distance(q, &self.from, &self.to).min(distance(q, &self.to, &self.after));
        let worst = samples(section).map(|q| lines(&q)).fold(0.0, f64::max);
        let nearest = samples(section).map(|q| length(&q, &self.to)).fold(f64::INFINITY, f64::min);
        let worst = worst.max(nearest);
        (worst > deviation * (1.0 + 1e-9) + 1e-12 * size(&self.to)).then_some(worst / deviation)
    }
}

fn samples(section: &Trajectory<AXES>) -> impl Iterator<Item = Point> + '_ {
    (0..=40).map(|x| std::array::from_fn(|k| section.at(section.duration() * f64::from(x) / 40.0).q[k]))
}

fn size(q: &Point) -> f64 {
    q.iter().fold(1.0, |m: f64, x| m.max(x.abs()))
}

fn axis_state(section: &Trajectory<AXES>, k: usize, t: f64) -> AxisState {
    let s = section.axes()[k].at_or_after(t);
    AxisState::new(s.p, s.v, s.a)
}

fn off(x: &AxisState, y: &AxisState) -> f64 {
    (x.p - y.p).abs().max((x.v - y.v).abs()).max((x.a - y.a).abs())
}

fn length(x: &Point, y: &Point) -> f64 {
    x.iter().zip(y).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}

/// The distance of a point from the line between two others.
fn distance(q: &Point, from: &Point, to: &Point) -> f64 {
    let way: Point = std::array::from_fn(|k| to[k] - from[k]);
    let square = way.iter().map(|x| x * x).sum::<f64>();
    let along = (0..AXES).map(|k| (q[k] - from[k]) * way[k]).sum::<f64>();
    let part = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
    length(q, &std::array::from_fn(|k| from[k] + part * way[k]))
}

thread_local! {
    static PLANNER: RefCell<Box<WayPointPlanner<AXES>>> = RefCell::new(Box::default());
}

/// One route.
pub fn case(seed: u64) -> Outcome {
    let input = Input::new(&mut random(seed));
    let mut outcome = Outcome { counted: 1, ..Outcome::default() };
    let plan = |route: &Route<'_, AXES>| PLANNER.with_borrow_mut(|planner| planner.plan(&input.start, route));
    let failure = match plan(&input.route()) {
        Err(e) => Some((format!("refused: {e}"), 1.0)),
        Ok(motion) => {
            let inner = &motion.states()[1..motion.section_durations().len()];
            let rests = inner.iter().all(|state| state.iter().all(|s| s.v == 0.0));
            outcome.see(if rests { "rests in every point" } else { "passes points" });
            input.judge(&motion).or_else(|| {
                let resting: Vec<_> =
                    input.points.iter().map(|p| p.blend().map_or(*p, |_| p.with_blend(0.0))).collect();
                let resting = plan(&input.route_through(&resting)).map_or(f64::INFINITY, |motion| motion.duration());
                let longer = motion.duration() / resting - 1.0;
                (longer > 1e-9).then(|| ("longer than with rests".to_owned(), longer))
            })
        }
    };
    outcome.failure = failure.map(|(kind, size)| (kind, Failure { size, seed, input: format!("{input:?}") }));
    outcome
}
