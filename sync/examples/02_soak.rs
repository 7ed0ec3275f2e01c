//! Random motions by seed, judged phase by phase: `02_soak [count] [seed] [threads]`.
//!
//! Every case is one axis, and in every eighth four axes in a common time. Checked: no calculation fails; the end state is met to
//! 1e-8; velocity, acceleration and jerk stay within their limits to 1e-12 once they are inside; a motion of a random longer
//! duration exists exactly where it is said to; and for a sample that the mirrored and, from inside the limits, the time-reversed
//! problem takes the same time and that rest to rest takes what the closed form says. Prints the first failing input.
#![allow(clippy::neg_cmp_op_on_partial_ord)]
use arcfeed_sync::feedrate::{AxisLimits, AxisProblem, AxisState, MotionLaw, Phase, StateToState};
use arcfeed_sync::{MotionOptions, Trajectory};

/// SplitMix64, uniform in [0, 1).
struct Rng(u64);
impl Rng {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn log(&mut self, lo: f64, hi: f64) -> f64 {
        lo * (hi / lo).powf(self.unit())
    }
    fn sign(&mut self) -> f64 {
        if self.unit() < 0.5 { -1.0 } else { 1.0 }
    }
}

#[derive(Debug, Clone, Copy)]
struct Case {
    start: AxisState,
    target: AxisState,
    v: (f64, f64),
    a: (f64, f64),
    j: (f64, f64),
}

impl Case {
    fn limits(&self) -> AxisLimits {
        AxisLimits::new(self.v, self.a, self.j).expect("limits on both sides of zero")
    }

    fn mirrored(&self) -> Self {
        let flip = |s: AxisState| AxisState::new(-s.p, -s.v, -s.a);
        let swap = |l: (f64, f64)| (-l.1, -l.0);
        Self { start: flip(self.start), target: flip(self.target), v: swap(self.v), a: swap(self.a), j: swap(self.j) }
    }

    fn reversed(&self) -> Self {
        let back = |s: AxisState| AxisState::new(-s.p, s.v, -s.a);
        Self { start: back(self.target), target: back(self.start), a: (-self.a.1, -self.a.0), ..*self }
    }
}

/// A number in a pair of limits: inside, at one of them, zero, or a distance of 1e-15 to 1e-3 of the range inside one.
fn within(rng: &mut Rng, (lo, hi): (f64, f64)) -> f64 {
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
fn case(rng: &mut Rng) -> (Case, &'static str) {
    let family = (rng.unit() * 6.0) as u32;
    let (jerk, reach, name) = match family {
        0 => ((1e9, 1e12), (1e-9, 10.0), "jerk 1e9 to 1e12"),
        1 => ((1.0, 1e5), (1e-7, 1e-2), "micrometres and millimetres"),
        2 => ((0.3, 300.0), (1e-3, 30.0), "start outside the limits"),
        3 => ((0.3, 300.0), (0.1, 100.0), "rest to rest"),
        4 => ((0.3, 300.0), (1e-15, 1e-3), "tiny moves"),
        _ => ((0.3, 300.0), (1e-3, 30.0), "moving"),
    };
    let pair = |rng: &mut Rng, lo: f64, hi: f64| {
        let upper = rng.log(lo, hi);
        (if rng.unit() < 0.5 { -upper } else { -rng.log(lo, hi) }, upper)
    };
    let (v, a, j) = (pair(rng, 0.05, 10.0), pair(rng, 0.1, 30.0), pair(rng, jerk.0, jerk.1));
    // `before`: room to have got there from, otherwise room to go on.
    let state = |rng: &mut Rng, before: bool| {
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
    let to = from + rng.sign() * rng.log(reach.0, reach.1);
    (Case { start: AxisState::new(from, v0, a0), target: AxisState::new(to, vf, af), v, a, j }, name)
}

/// Adds up the phases.
fn judge(case: &Case, motion: &StateToState) -> Result<(), String> {
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
            let over = |x: f64, l: (f64, f64)| (x - l.1).max(l.0 - x) / span(l);
            let worst = over(s.v, case.v).max(over(s.a, case.a));
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
fn agree(case: &Case, t: f64, other: f64) -> bool {
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

fn check(i: u64, case: &Case, name: &str, rng: &mut Rng) -> Result<(), String> {
    let l = case.limits();
    let problem = AxisProblem::new(&case.start, &case.target, &l).map_err(|e| e.to_string())?;
    let motion = problem.shortest();
    judge(case, &motion)?;
    let t = motion.duration();
    let longer = t * (1.0 + rng.log(1e-9, 10.0));
    let possible = problem.durations().contains(longer);
    match problem.lasting(longer) {
        Ok(m) if possible => judge(case, &m).map_err(|e| format!("in {longer} s: {e}"))?,
        // From outside the limits more may be possible than is promised.
        Ok(m) if !l.contain(&case.start) => judge(case, &m).map_err(|e| format!("in {longer} s: {e}"))?,
        Err(_) if !possible => {}
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

fn together(cases: &[Case; 4]) -> Result<(), String> {
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

fn run(count: u64, seed: u64) -> Result<(), String> {
    let mut rng = Rng(seed);
    let mut last = [case(&mut rng).0; 4];
    for i in 0..count {
        let (case, name) = case(&mut rng);
        check(i, &case, name, &mut rng).map_err(|e| format!("{name}, case {i}: {e}\n{case:?}"))?;
        last[(i % 4) as usize] = case;
        if i % 8 == 7 {
            together(&last).map_err(|e| format!("case {i}: {e}\n{last:?}"))?;
        }
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let numbers: Vec<u64> = std::env::args().skip(1).map(|x| x.parse()).collect::<Result<_, _>>()?;
    let count = numbers.first().copied().unwrap_or(20_000);
    let seed = numbers.get(1).copied().unwrap_or(1);
    let threads = numbers.get(2).copied().unwrap_or(2).max(1);
    let clock = std::time::Instant::now();
    let workers: Vec<_> = (0..threads)
        .map(|k| std::thread::spawn(move || run(count / threads, seed.wrapping_mul(0x1_0000_0000).wrapping_add(k))))
        .collect();
    let failures: Vec<String> = workers
        .into_iter()
        .filter_map(|w| w.join().map_or(Some("panicked".into()), |r: Result<(), String>| r.err()))
        .collect();
    println!("{count} cases of seed {seed} on {threads} threads in {:.1} s", clock.elapsed().as_secs_f64());
    if failures.is_empty() {
        println!("no failure");
        return Ok(());
    }
    Err(failures.join("\n").into())
}
