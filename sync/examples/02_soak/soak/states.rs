//! One axis from state to state, and four of them in a common time.
//!
//! Judged phase by phase: no calculation fails; the end state is met to 1e-8; velocity, acceleration and jerk stay within their
//! limits to 1e-12 once they are inside; a motion of a random longer duration exists exactly where it is said to; the mirrored and,
//! from inside the limits, the time-reversed problem takes the same time; rest to rest takes what the closed form says.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

use arcfeed_sync::feedrate::{AxisLimits, AxisProblem, AxisState, FeedError, MotionLaw, Phase, StateToState};
use arcfeed_sync::{MotionOptions, Trajectory};

use arcfeed_testing::Random;

use super::{Failure, Outcome, random};

#[derive(Debug, Clone, Copy)]
pub struct Input {
    pub start: AxisState,
    pub target: AxisState,
    pub v: (f64, f64),
    pub a: (f64, f64),
    pub j: (f64, f64),
}

impl Input {
    pub fn limits(&self) -> AxisLimits {
        AxisLimits::new(self.v, self.a, self.j).expect("limits on both sides of zero")
    }

    pub fn code(&self) -> String {
        let state = |s: &AxisState| format!("AxisState::new({:?}, {:?}, {:?})", s.p, s.v, s.a);
        let (v, a, j) = (self.v, self.a, self.j);
        let limits = format!("AxisLimits::new({v:?}, {a:?}, {j:?})?");
        format!("AxisProblem::new(&{}, &{}, &{limits})?", state(&self.start), state(&self.target))
    }

    fn mirrored(&self) -> Self {
        let flip = |s: AxisState| AxisState::new(-s.p, -s.v, -s.a);
        let swap = |l: (f64, f64)| (-l.1, -l.0);
        Self { start: flip(self.start), target: flip(self.target), v: swap(self.v), a: swap(self.a), j: swap(self.j) }
    }

    pub fn reversed(&self) -> Self {
        let back = |s: AxisState| AxisState::new(-s.p, s.v, -s.a);
        Self { start: back(self.target), target: back(self.start), a: (-self.a.1, -self.a.0), ..*self }
    }
}

/// A number in a pair of limits: inside, at one of them, zero, or a distance of 1e-15 to 1e-3 of the range inside one.
fn within(rng: &mut Random, (lo, hi): (f64, f64)) -> f64 {
    let near = rng.log(1e-15, 1e-3) * (hi - lo);
    match (rng.unit() * 10.0) as u32 {
        0 | 1 => 0.0_f64.clamp(lo, hi),
        2 => lo,
        3 => hi,
        4 => (lo + near).min(hi),
        5 => (hi - near).max(lo),
        _ => lo + (hi - lo) * rng.unit(),
    }
}

/// The families in which libraries of this kind are known to fail.
const FAMILIES: [&str; 11] = [
    "jerk 1e9 to 1e12",
    "micrometres and millimetres",
    "start outside the limits",
    "rest to rest",
    "tiny moves",
    "moving",
    "limits decades apart",
    "equal numbers",
    "units far from 1",
    "far and slow",
    "one direction decades weaker",
];

/// Limits as pairs and the size of the displacement.
fn any_limits(family: usize, rng: &mut Random) -> ([(f64, f64); 3], f64) {
    let mut limits = [rng.log(0.05, 10.0), rng.log(0.1, 30.0), rng.log(0.3, 300.0)];
    let mut reach = rng.log(1e-3, 30.0);
    match family {
        0 => (limits[2], reach) = (rng.log(1e9, 1e12), rng.log(1e-9, 10.0)),
        1 => (limits[2], reach) = (rng.log(1.0, 1e5), rng.log(1e-7, 1e-2)),
        3 => reach = rng.log(0.1, 100.0),
        4 => reach = rng.log(1e-18, 1e-3),
        6 => limits = limits.map(|x| x * rng.log(1e-3, 1e3)),
        7 => {
            limits = [(); 3].map(|()| rng.one_of(&[0.5, 1.0, 2.0, 4.0, 8.0]));
            let [v, a, j] = limits;
            let special =
                [0.0, v * a / j, v * v / a, v * (v / a + a / j), 2.0 * v * (v / j).sqrt(), 2.0 * a.powi(3) / j / j];
            reach = rng.one_of(&special) * rng.one_of(&[0.5, 1.0, 1.0, 2.0]);
        }
        8 => {
            let (length, time) = (rng.log(1e-9, 1e9), rng.log(1e-6, 1e6));
            reach *= length;
            for (x, order) in limits.iter_mut().zip(1..) {
                *x *= length / time.powi(order);
            }
        }
        9 => (limits[0], reach) = (rng.log(1e-6, 1.0), rng.log(1e3, 1e9)),
        _ => {}
    }
    let pairs = limits.map(|x| {
        let weaker = if family == 10 { rng.log(1e-2, 1e2) } else { rng.log(0.03, 30.0) };
        (if family != 7 && rng.chance(0.5) { -x * weaker } else { -x }, x)
    });
    (pairs, reach)
}

/// A problem of one axis, and what is special about it.
pub fn any_input(rng: &mut Random) -> (Input, &'static str) {
    let family = rng.below(FAMILIES.len());
    let ([v, a, j], reach) = any_limits(family, rng);
    // `before`: room to have got there from, otherwise room to go on.
    let state = |rng: &mut Random, before: bool| {
        let x = within(rng, a);
        let room = 0.5 * x * x / if (x > 0.0) == before { j.1 } else { -j.0 };
        let range = if (x > 0.0) == before { (v.0 + room, v.1) } else { (v.0, v.1 - room) };
        if range.0 > range.1 { (within(rng, v), 0.0) } else { (within(rng, range), x) }
    };
    let ((v0, a0), (vf, af)) = match family {
        2 => ((3.0 * within(rng, v), 3.0 * within(rng, a)), state(rng, true)),
        3 => ((0.0, 0.0), (0.0, 0.0)),
        _ => (state(rng, false), state(rng, true)),
    };
    let from = if rng.unit() < 0.5 { 0.0 } else { 2.0 * rng.unit() - 1.0 };
    let to = from + rng.sign() * reach;
    (Input { start: AxisState::new(from, v0, a0), target: AxisState::new(to, vf, af), v, a, j }, FAMILIES[family])
}

/// Adds up the phases.
pub fn judge(case: &Input, motion: &StateToState) -> Result<(), String> {
    let l = case.limits();
    let (mut p, mut v, mut a) = (case.start.p, case.start.v, case.start.a);
    let span = |l: (f64, f64)| l.1 - l.0;
    let mut far = p.abs().max(case.target.p.abs()).max(span(case.v) * motion.duration());
    // Round-off is relative to the largest numbers on the way.
    let (mut fast, hard) = (span(case.v) + v.abs(), span(case.a) + a.abs());
    let mut inside = l.contain(&case.start);
    for (phase, dt) in motion.phases() {
        let Phase { j, .. } = phase;
        let gap = ((phase.s - p).abs() / far).max((phase.v - v).abs() / fast).max((phase.a - a).abs() / hard);
        if !(gap <= 1e-8) {
            return Err(format!("the phase at {} s begins {gap:e} away from the end of the one before", phase.t));
        }
        if j > case.j.1 * (1.0 + 1e-12) || j < case.j.0 * (1.0 + 1e-12) {
            return Err(format!("jerk {j}"));
        }
        let top = -phase.a / j;
        for t in [0.0, if top > 0.0 && top < dt { top } else { dt }, dt] {
            let s = phase.after(t);
            let over = |x: f64, l: (f64, f64), most: f64| (x - l.1).max(l.0 - x) / span(l).max(most);
            let worst = over(s.v, case.v, fast).max(over(s.a, case.a, hard));
            if inside && !(worst <= 1e-12) {
                return Err(format!("a limit is exceeded by {worst:e} at {} s", phase.t + t));
            }
            inside |= l.contain(&AxisState::new(s.p, s.v, s.a));
        }
        let end = phase.after(dt);
        (p, v, a) = (end.p, end.v, end.a);
        far = far.max(p.abs());
        fast = fast.max(v.abs());
    }
    let miss =
        ((p - case.target.p).abs() / far).max((v - case.target.v).abs() / fast).max((a - case.target.a).abs() / hard);
    if miss <= 1e-8 { Ok(()) } else { Err(format!("misses the target by {miss:e}")) }
}

/// Whether two durations agree, where a change of the displacement by round-off does not make the duration jump.
fn agree(case: &Input, t: f64, other: f64) -> bool {
    let close = |x: f64, y: f64| (x - y).abs() <= 1e-9 * x.max(y);
    if close(t, other) {
        return true;
    }
    let size = case.start.p.abs() + case.target.p.abs() + (case.v.1 - case.v.0) * t;
    let mut range = (t, t);
    // Near an end both ways of rounding must be allowed for all of the numbers.
    for nudge in [-1e-9, -1e-10, 1e-10, 1e-9] {
        for which in 0..3 {
            let mut c = *case;
            match which {
                0 => c.target.p += nudge * size,
                1 => c.start.v = (c.start.v + nudge * (c.v.1 - c.v.0)).clamp(c.v.0, c.v.1),
                _ => c.start.a = (c.start.a + nudge * (c.a.1 - c.a.0)).clamp(c.a.0, c.a.1),
            }
            if let Ok(m) = StateToState::new(&c.start, &c.target, &c.limits()) {
                range = (range.0.min(m.duration()), range.1.max(m.duration()));
            }
        }
    }
    other >= range.0 * (1.0 - 1e-6) && other <= range.1 * (1.0 + 1e-6)
}

/// Textbook duration from rest to rest under symmetric limits.
fn rest_to_rest(d: f64, v: f64, a: f64, j: f64) -> f64 {
    let ramp = |v: f64| if v * j >= a * a { v / a + a / j } else { 2.0 * (v / j).sqrt() };
    if d >= v * ramp(v) {
        return d / v + ramp(v);
    }
    if d >= 2.0 * a.powi(3) / (j * j) { a / j + ((a / j).powi(2) + 4.0 * d / a).sqrt() } else { (32.0 * d / j).cbrt() }
}

fn check(i: u64, case: &Input, name: &str, rng: &mut Random) -> Result<(), String> {
    let l = case.limits();
    let problem = AxisProblem::new(&case.start, &case.target, &l).map_err(|e| e.to_string())?;
    let motion = problem.shortest();
    judge(case, &motion)?;
    let t = motion.duration();
    let longer = t * (1.0 + rng.log(1e-9, 10.0));
    let possible = problem.durations().contains(longer);
    match problem.with_duration(longer) {
        Ok(m) if possible => judge(case, &m).map_err(|e| format!("in {longer} s: {e}"))?,
        // From outside the limits more may be possible than is promised.
        Ok(m) if !l.contain(&case.start) => judge(case, &m).map_err(|e| format!("in {longer} s: {e}"))?,
        Err(_) if !possible => {}
        // Phases have the round-off of acceleration over jerk; the motion is refused where that is all there is.
        Err(FeedError::DurationImpossible { .. })
            if 1e-7 * longer < f64::EPSILON * (case.a.1 - case.a.0) / case.j.1.min(-case.j.0) => {}
        other => return Err(format!("in {longer} s: possible is {possible}, but {:?}", other.map(|m| m.duration()))),
    }
    if i.is_multiple_of(4) {
        let m = case.mirrored();
        let other = StateToState::new(&m.start, &m.target, &m.limits()).map_err(|e| e.to_string())?.duration();
        if other != t {
            return Err(format!("{t} s, but mirrored {other} s"));
        }
        // A start outside the limits is no target.
        let r = case.reversed();
        if l.contain(&case.start)
            && let Ok(m) = StateToState::new(&r.start, &r.target, &r.limits())
            && r.limits().contain(&r.start)
            && !agree(case, t, m.duration())
        {
            return Err(format!("{t} s, but reversed in time {} s", m.duration()));
        }
        let symmetric = case.v.0 == -case.v.1 && case.a.0 == -case.a.1 && case.j.0 == -case.j.1;
        if name == "rest to rest" && symmetric {
            let textbook = rest_to_rest((case.target.p - case.start.p).abs(), case.v.1, case.a.1, case.j.1);
            if (t - textbook).abs() > 1e-9 * t {
                return Err(format!("{t} s instead of {textbook} s"));
            }
        }
    }
    Ok(())
}

fn together(cases: &[Input; 4]) -> Result<(), String> {
    let limits = cases.map(|c| c.limits());
    let motion = Trajectory::new(&cases.map(|c| c.start), &cases.map(|c| c.target), &limits, &MotionOptions::default())
        .map_err(|e| e.to_string())?;
    for (k, (case, axis)) in cases.iter().zip(motion.axes()).enumerate() {
        judge(case, axis).map_err(|e| format!("together, axis {k}: {e}"))?;
        if axis.duration() != motion.duration() {
            return Err(format!("axis {k} arrives at {} s, not at {} s", axis.duration(), motion.duration()));
        }
    }
    Ok(())
}

/// The case of a seed: one axis, and four axes for every eighth seed.
pub fn case(seed: u64) -> Outcome {
    let mut rng = random(seed);
    let mut outcome = Outcome { counted: 1, ..Outcome::default() };
    let mut fail = |name: &str, e: String, input: String| {
        let kind: String = e.chars().map(|c| if c.is_ascii_digit() { '#' } else { c }).collect();
        let failure = Failure { size: 1.0, seed, input: format!("{e}\n{input}") };
        outcome.failure = Some((format!("{name}: {}", kind.split("##").next().unwrap_or("")), failure));
    };
    let (input, name) = any_input(&mut rng);
    if let Err(e) = check(seed, &input, name, &mut rng) {
        fail(name, e, input.code());
    } else if seed.is_multiple_of(8) {
        let inputs = [input, any_input(&mut rng).0, any_input(&mut rng).0, any_input(&mut rng).0];
        if let Err(e) = together(&inputs) {
            fail("together", e, inputs.map(|i| i.code()).join("\n"));
        }
    }
    outcome.see(name);
    outcome
}
