//! Paths to plan on and an independent judge of plans.
#![allow(dead_code, clippy::unwrap_used, clippy::neg_cmp_op_on_partial_ord, missing_docs)]

pub mod axis;

use arcfeed_feedrate::{Phase, Segment, SpeedLaw};
use arcfeed_testing::Random;

/// A path as curve interpolation makes it: 1e-5 .. 1e-3 m segments, a speed cap from 0.002 to 0.1 m/s that varies smoothly
/// with sharp dips at corners and long slow slopes, bounds on acceleration and jerk that vary slowly.
pub fn curve_like(n: usize, seed: u64) -> Vec<Segment> {
    let mut rng = Random::new(seed);
    let waves: Vec<(f64, f64)> =
        (0..4).map(|i| (rng.unit() * 6.3, (2.0 + 3.0 * rng.unit()) * f64::from(1 << i))).collect();
    let lengths: Vec<f64> = {
        let mut l = 2e-4;
        (0..n)
            .map(|_| {
                l = (l * rng.log(0.7, 1.43)).clamp(1e-5, 1e-3);
                l
            })
            .collect()
    };
    let total: f64 = lengths.iter().sum();
    let corners: Vec<(f64, f64, f64)> =
        (0..n / 60).map(|_| (rng.unit() * total, rng.log(0.002, 0.03), rng.log(2e-4, 4e-3))).collect();
    let mut s = 0.0;
    lengths
        .iter()
        .map(|&l| {
            let mid = (s + 0.5 * l) / total;
            let slow: f64 = waves.iter().map(|(p, f)| (p + f * std::f64::consts::TAU * mid).sin() / f.sqrt()).sum();
            let mut v = 0.05 * (0.9 * slow).exp();
            for &(at, depth, width) in &corners {
                let d = (s + 0.5 * l - at) / width;
                v = v.min(depth * (1.0 + d * d));
            }
            s += l;
            let a = 1.0 + 0.3 * (5.0 * mid + waves[0].0).sin();
            let j = 50.0 * (1.0 + 0.4 * (7.0 * mid + waves[1].0).cos());
            Segment::new(l, v.clamp(0.002, 0.1), a, j).unwrap()
        })
        .collect()
}

/// Duration of the second-order optimum (no jerk limit): a lower bound for every legal motion.
pub fn lower_bound(segments: &[Segment], v0: f64, v1: f64) -> f64 {
    let n = segments.len();
    let mut x = vec![0.0; n + 1];
    for i in 0..=n {
        let l = if i > 0 { segments[i - 1].v_max() } else { f64::INFINITY };
        let r = if i < n { segments[i].v_max() } else { f64::INFINITY };
        x[i] = l.min(r).powi(2);
    }
    x[0] = v0 * v0;
    x[n] = v1 * v1;
    for i in 0..n {
        x[i + 1] = x[i + 1].min(x[i] + 2.0 * segments[i].a_max() * segments[i].length());
    }
    for i in (0..n).rev() {
        x[i] = x[i].min(x[i + 1] + 2.0 * segments[i].a_max() * segments[i].length());
    }
    (0..n)
        .map(|i| {
            let (a, l) = (segments[i].a_max(), segments[i].length());
            let top = (0.5 * (x[i] + x[i + 1]) + a * l).min(segments[i].v_max().powi(2)).max(x[i]).max(x[i + 1]);
            let (va, vb, vt) = (x[i].sqrt(), x[i + 1].sqrt(), top.sqrt());
            let used = (2.0 * top - x[i] - x[i + 1]) / (2.0 * a);
            (2.0 * vt - va - vb) / a + (l - used).max(0.0) / vt
        })
        .sum()
}

/// Worst ratio to a limit (speed, acceleration, jerk) over dense samples of every phase, and the worst relative break of continuity.
#[derive(Debug, Clone, Copy)]
pub struct Verdict {
    pub v: f64,
    pub a: f64,
    pub j: f64,
    pub gap: f64,
    pub at: f64,
}

pub fn judge(plan: &SpeedLaw, segments: &[Segment], v0: f64, v1: f64) -> Verdict {
    let mut b = vec![0.0];
    for s in segments {
        b.push(b[b.len() - 1] + s.length());
    }
    let total = b[b.len() - 1];
    let v_scale = segments.iter().map(Segment::v_max).fold(0.0, f64::max);
    let a_scale = segments.iter().map(Segment::a_max).fold(0.0, f64::max);
    let mut w = Verdict { v: 0.0, a: 0.0, j: 0.0, gap: 0.0, at: 0.0 };
    let phase = |(t, m): (f64, arcfeed_feedrate::MotionState)| Phase { t, s: m.p, v: m.v, a: m.a, j: m.j };
    let phases: Vec<Phase> = plan.knots().map(phase).collect();
    let mut before = (0.0, v0, 0.0);
    for (i, p) in phases.iter().enumerate() {
        let gap = ((p.s - before.0).abs() / total)
            .max((p.v - before.1).abs() / v_scale)
            .max((p.a - before.2).abs() / a_scale);
        if gap > w.gap {
            w.gap = gap;
            w.at = p.s;
        }
        let dt = phases.get(i + 1).map_or(plan.duration(), |n| n.t) - p.t;
        assert!(dt >= 0.0, "phase {i} has duration {dt}");
        let state = |t: f64| {
            (p.s + t * (p.v + t * (p.a / 2.0 + t * p.j / 6.0)), p.v + t * (p.a + t * p.j / 2.0), p.a + t * p.j)
        };
        for k in 0..=24 {
            let (s, v, a) = state(dt * f64::from(k) / 24.0);
            // At a boundary round-off decides the side: grant the looser of the two.
            let eps = 1e-11 * total;
            let lo = b.partition_point(|&x| x <= s - eps).clamp(1, segments.len()) - 1;
            let hi = b.partition_point(|&x| x <= s + eps).clamp(1, segments.len()) - 1;
            let loosest = |f: fn(&Segment) -> f64| (lo..=hi).map(|q| f(&segments[q])).fold(0.0, f64::max);
            let (rv, ra, rj) =
                (v / loosest(Segment::v_max), a.abs() / loosest(Segment::a_max), p.j.abs() / loosest(Segment::j_max));
            if rv > w.v.max(1.0) || ra > w.a.max(1.0) || rj > w.j.max(1.0) {
                w.at = s;
            }
            w.v = w.v.max(rv);
            w.a = w.a.max(ra);
            w.j = w.j.max(rj);
            assert!(v >= -1e-9 * v_scale, "runs backwards: v = {v} at s = {s}");
        }
        before = state(dt);
    }
    let end = ((before.0 - total).abs() / total).max((before.1 - v1).abs() / v_scale).max(before.2.abs() / a_scale);
    w.gap = w.gap.max(end);
    w
}
