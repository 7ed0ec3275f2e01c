//! A run held against every limit, with nothing but its setpoints and the arm's forward kinematics.

use arcfeed_kinematics::Joints;
use nalgebra::Vector3;

use super::joint_check::{JointCheck, Rates};
use super::limit_line::{LimitLine, LimitUnit};
use super::play::{Cycle, Played};
use super::stage::Stage;

/// On the path the tool of the setpoints is nearer to it than this, m: what is left to rounding.
pub(crate) const ON_PATH: f64 = 1e-9;

/// Every limit with its worst place: those of the joints all the time, those of the tool on the path.
pub(crate) fn limits(stage: &Stage<'_>, played: &Played) -> Vec<LimitLine> {
    let live = stage.live();
    let joints = live.joints();
    let rates = Rates::from(joints);
    let mut check = JointCheck::new((*joints.lower()).into(), (*joints.upper()).into());
    for row in played.rows() {
        check.see(&row, live.period(), &rates);
    }
    let mut lines = check.into_lines();
    let (tool, none) = (live.tool(), f64::INFINITY);
    let or_none = |limit: Option<f64>| limit.unwrap_or(none);
    let mut worst = [
        Worst::new("feed", LimitUnit::MetrePerSecond, or_none(tool.feed())),
        Worst::new("tangential acceleration", LimitUnit::MetrePerSecond2, or_none(tool.tangential_acceleration())),
        Worst::new("tangential jerk", LimitUnit::MetrePerSecond3, or_none(tool.tangential_jerk())),
        Worst::new("normal acceleration", LimitUnit::MetrePerSecond2, or_none(tool.normal_acceleration())),
        Worst::new("chord error", LimitUnit::Metre, live.chord_tolerance()),
        Worst::new("deviation from the path", LimitUnit::Metre, ON_PATH),
    ];
    // Place on the path and tangential acceleration one cycle before, while on the path.
    let mut before: Option<(f64, f64)> = Some((played.start.s, 0.0));
    for cycle in &played.cycles {
        let p = &cycle.setpoint;
        if !cycle.on_path {
            before = None;
            continue;
        }
        let configuration = stage.arm.configuration(&p.q);
        let linear = |v: nalgebra::SVector<f64, 6>| v.fixed_rows::<3>(0).into_owned();
        let velocity = linear(configuration.jacobian() * p.qd);
        let acceleration = linear(configuration.jacobian() * p.qdd + configuration.acceleration_bias(&p.qd));
        let direction = live.path().pose_path().curve().jet(p.s).d1;
        let tangential = acceleration.dot(&direction);
        let off = configuration.pose().translation.vector - live.path().pose_path().pose(p.s).translation.vector;
        let mut see = |k: usize, value: f64| worst[k].see(value, p.s, p.t);
        see(0, velocity.norm());
        see(1, tangential);
        see(3, (acceleration - direction * tangential).norm());
        see(5, off.norm());
        if let Some((s, a)) = before {
            // Accelerations that are the same but for rounding are no jerk.
            let jerk = (tangential - a) / live.period();
            see(2, jerk.signum() * (jerk.abs() - 1e-11 / live.period()).max(0.0));
            see(4, chord_error(stage, s, p.s));
        }
        before = Some((p.s, tangential));
    }
    lines.extend(worst.into_iter().map(|w| w.0).filter(|line| line.limit != none));
    lines
}

struct Worst(LimitLine);

impl Worst {
    fn new(name: &str, unit: LimitUnit, limit: f64) -> Self {
        let name = name.to_owned();
        Self(LimitLine { name, joint: None, unit, value: 0.0, limit, ratio: 0.0, at_s_m: Some(0.0), at_t_s: 0.0 })
    }

    fn see(&mut self, value: f64, s: f64, t: f64) {
        let ratio = value.abs() / self.0.limit;
        // A NaN, once seen, stays.
        if !self.0.ratio.is_nan() && (ratio > self.0.ratio || ratio.is_nan()) {
            (self.0.value, self.0.ratio, self.0.at_s_m, self.0.at_t_s) = (value, ratio, Some(s), t);
        }
    }
}

/// Distance of the middle of a piece of path from the straight line between its ends.
fn chord_error(stage: &Stage<'_>, from: f64, to: f64) -> f64 {
    let curve = stage.live().path().pose_path().curve();
    let (a, b, middle) = (curve.point(from), curve.point(to), curve.point(0.5 * (from + to)));
    let (chord, d) = (b - a, middle - a);
    let f = if chord.norm_squared() > 0.0 { d.dot(&chord) / chord.norm_squared() } else { 0.0 };
    (d - chord * f).norm()
}

/// Largest distance of the tool from the path over cycles on it: of the setpoints at their arc length, and of the simulated joints from the
/// nearest point of the path.
pub(crate) fn accuracy<'c>(stage: &Stage<'_>, cycles: impl Iterator<Item = &'c Cycle>) -> Option<(f64, f64)> {
    let path = stage.live().path().pose_path();
    let slowest = stage.drive.amax();
    let mut worst: Option<(f64, f64)> = None;
    for cycle in cycles.filter(|c| c.on_path) {
        let p = &cycle.setpoint;
        let (w, drive) = worst.get_or_insert((0.0, 0.0));
        let tool = |q: &Joints<6>| stage.arm.forward(q).translation.vector;
        *w = w.max((tool(&p.q) - path.pose(p.s).translation.vector).norm());
        if slowest == 0.0 {
            *drive = *w;
            continue;
        }
        let reach = 1e-4 + 8.0 * slowest * p.feed.abs();
        *drive = drive.max(nearest(stage, &tool(&cycle.joints), p.s, reach));
    }
    worst
}

/// Distance of `point` from the path around `s`.
fn nearest(stage: &Stage<'_>, point: &Vector3<f64>, s: f64, reach: f64) -> f64 {
    const PIECES: u32 = 12;
    const HALVINGS: usize = 24;
    let curve = stage.live().path().pose_path().curve();
    let (from, to) = ((s - reach).max(0.0), (s + reach).min(curve.length()));
    let at = |s: f64| (curve.point(s) - point).norm();
    let h = (to - from) / f64::from(PIECES);
    let best = (0..=PIECES).map(|i| from + h * f64::from(i)).min_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap_or(s);
    let (mut low, mut high) = ((best - h).max(from), (best + h).min(to));
    for _ in 0..HALVINGS {
        let (a, b) = (low + 0.4 * (high - low), low + 0.6 * (high - low));
        if at(a) < at(b) {
            high = b;
        } else {
            low = a;
        }
    }
    at(0.5 * (low + high)).min(at(best))
}
