//! A judge of motions of constant jerk that adds up their phases by itself.

/// A stretch of constant jerk: state at its start, jerk, and how long it lasts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phase {
    /// Position, velocity and acceleration at its start.
    pub state: [f64; 3],
    /// Jerk.
    pub jerk: f64,
    /// How long it lasts.
    pub time: f64,
}

/// What a motion of one axis has to keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    /// Position, velocity and acceleration at the start.
    pub start: [f64; 3],
    /// The same at the end.
    pub target: [f64; 3],
    /// Lower and upper limits of velocity, acceleration and jerk.
    pub limits: [(f64, f64); 3],
}

impl Wanted {
    /// True if the start is within the limits by `slack` of their width, and can be left within them.
    pub fn starts_inside(&self, slack: f64) -> bool {
        let ([_, v, a], [of_v, of_a, of_j]) = (self.start, self.limits);
        let stop = v + 0.5 * a * a / if a > 0.0 { -of_j.0 } else { -of_j.1 };
        let within = |x: f64, l: (f64, f64)| l.0 - slack * span(l) <= x && x <= l.1 + slack * span(l);
        within(a, of_a) && within(v, of_v) && within(stop, of_v)
    }

    /// What is wrong with a motion, if anything: gaps between phases over 1e-9, a limit exceeded by 1e-12 (velocity and
    /// acceleration where the start is `inside`), or an end 1e-9 away. Positions count by the largest on the way.
    pub fn fault(&self, phases: &[Phase], inside: bool) -> Option<String> {
        let [mut p, mut v, mut a] = self.start;
        let [of_v, of_a, of_j] = self.limits;
        let duration: f64 = phases.iter().map(|phase| phase.time).sum();
        let (fast, hard) = (span(of_v) + v.abs(), span(of_a) + a.abs());
        let mut length = p.abs() + self.target[0].abs() + fast * duration;
        let off = |length: f64, a: [f64; 3], b: [f64; 3]| {
            ((a[0] - b[0]).abs() / length).max((a[1] - b[1]).abs() / fast).max((a[2] - b[2]).abs() / hard)
        };
        for (i, phase) in phases.iter().enumerate() {
            length = length.max(p.abs());
            let gap = off(length, phase.state, [p, v, a]);
            if gap.is_nan() || gap > 1e-9 {
                return Some(format!("phase {i} starts {gap:e} away from where the one before ended: {p} {v} {a}"));
            }
            let ([p0, v0, a0], Phase { jerk, time, .. }) = (phase.state, *phase);
            let over = |x: f64, l: (f64, f64)| (x - l.1).max(l.0 - x) / span(l);
            let top = -a0 / jerk;
            let times = [Some(0.0), Some(time), Some(top).filter(|&top| top > 0.0 && top < time)];
            for t in times.into_iter().flatten() {
                let (vt, at) = (v0 + t * (a0 + 0.5 * t * jerk), a0 + t * jerk);
                if over(jerk, of_j) > 1e-12 || inside && over(vt, of_v).max(over(at, of_a)) > 1e-12 {
                    return Some(format!("phase {i}: v {vt}, a {at}, j {jerk} break {:?}", self.limits));
                }
            }
            p = p0 + time * (v0 + time * (0.5 * a0 + time * jerk / 6.0));
            v = v0 + time * (a0 + 0.5 * time * jerk);
            a = a0 + time * jerk;
        }
        let miss = off(length, [p, v, a], self.target);
        if miss <= 1e-9 { None } else { Some(format!("ends {miss:e} away from the target: {p} {v} {a}")) }
    }
}

fn span(limits: (f64, f64)) -> f64 {
    limits.1 - limits.0
}
