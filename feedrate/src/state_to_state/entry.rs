//! A problem entered: its start acceleration brought inside the limits, and everything that is
//! solved from there on.

use super::brake_to_limits::Brake;
use super::cruise;
use super::displacement_function::Problem;
use super::durations::Gaps;
use super::extremal::Extremals;
use super::mean::Mean;
use super::phase_writer::Writer;
use super::profile::StateToState;
use super::shape::{Shape, displacement, end_of};
use super::solve::{Direct, solve, starts_too_fast};
use crate::error::FeedError;
use crate::limits::{AxisLimits, SLACK};
use crate::scurve::closed_form::Jerks;
use crate::state::AxisState;

/// The shortest motion, not yet written down.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shortest {
    shape: Shape,
    /// True if it is an extremal of the mirrored frame.
    pub mirrored: bool,
    /// It begins with braking as hard as possible to the velocity limit; the shape goes on from
    /// there, mirrored or not.
    after_braking: Option<bool>,
    /// In working units.
    pub duration: f64,
}

/// A problem whose start acceleration is inside its limits, and the phase that brought it there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    problem: Problem,
    from: f64,
    to: f64,
    /// Round-off in the displacement.
    noise: f64,
    /// Start and jerk of the phase before, and its duration.
    lead: AxisState,
    jerk: f64,
    pub lead_time: f64,
}

impl Entry {
    pub fn new(s: &AxisState, t: &AxisState, l: &AxisLimits) -> Result<Self, FeedError> {
        let j = Jerks::new(l.j.1, -l.j.0);
        check_entry(t, l, &j)?;
        let (lead, mut s) = (*s, *s);
        // Acceleration outside its bounds by more than round-off.
        let bound = s.a.clamp(l.a.0, l.a.1);
        if (s.a - bound).abs() <= SLACK * l.a.1.max(-l.a.0) {
            s.a = bound;
        }
        let jerk = if s.a > bound { l.j.0 } else { l.j.1 };
        let lead_time = if bound == s.a { 0.0 } else { (bound - s.a) / jerk };
        if bound != s.a {
            let dt = lead_time;
            s = AxisState {
                p: s.p + dt * (s.v + dt * (0.5 * s.a + dt * jerk / 6.0)),
                v: s.v + 0.5 * dt * (s.a + bound),
                a: bound,
            };
        }
        let problem = Problem {
            d: t.p - s.p,
            v0: s.v,
            a0: s.a,
            vf: t.v,
            af: t.a,
            v_min: l.v.0,
            v_max: l.v.1,
            rise: l.a.1,
            fall: -l.a.0,
            j,
        };
        let noise = 2.0 * f64::EPSILON * (s.p.abs() + t.p.abs());
        Ok(Self { problem, from: s.p, to: t.p, noise, lead, jerk, lead_time })
    }

    /// A writer with the phase that brings the acceleration inside its limits.
    fn writer<'a>(&self, out: &'a mut StateToState) -> Writer<'a> {
        let mut writer = Writer::new(&mut out.phases);
        writer.push(self.lead_time, self.lead.p, self.lead.v, self.lead.a, self.jerk);
        writer
    }

    /// The shortest motion from here on.
    pub fn solve(&self) -> Shortest {
        let p = &self.problem;
        let (shape, mirrored) = solve(p, self.noise);
        let duration = end_of(p, &shape, mirrored, self.lead_time);
        let settling = Shortest { shape, mirrored, after_braking: None, duration };
        if !shape.squeezed {
            return settling;
        }
        let frame = if mirrored { p.mirrored() } else { *p };
        let Some(brake) = Brake::new(&frame) else { return settling };
        let (shape, flipped) = solve(&brake.rest, 0.0);
        let duration = end_of(&brake.rest, &shape, flipped, self.lead_time + brake.t1 + brake.peak.hold);
        let braking = Shortest { shape, mirrored, after_braking: Some(flipped), duration };
        if braking.duration < settling.duration { braking } else { settling }
    }

    /// The shortest motion written down, its target excepted.
    pub fn write(&self, shortest: &Shortest, out: &mut StateToState) {
        let Shortest { shape, mirrored, after_braking, duration } = *shortest;
        let mut writer = self.writer(out);
        let p = &self.problem;
        let frame = if mirrored { p.mirrored() } else { *p };
        if let Some(flipped) = after_braking
            && let Some(brake) = Brake::new(&frame)
        {
            let from = writer.brake(&brake, mirrored, self.from);
            writer.write(&brake.rest, &shape, flipped, from, if mirrored { -self.to } else { self.to });
        } else {
            writer.write(p, &shape, mirrored, self.from, self.to);
        }
        writer.finish(duration);
    }

    /// Where the shortest change of velocity and acceleration ends.
    pub fn direct_end(&self) -> f64 {
        self.from + Direct::new(&self.problem).displacement
    }

    /// The shortest change of velocity and acceleration; where it ends.
    pub fn direct(&self, out: &mut StateToState) -> f64 {
        let p = &self.problem;
        let direct = Direct::new(p);
        let to = self.from + direct.displacement;
        let mut writer = self.writer(out);
        writer.write(p, &direct.shape, false, self.from, to);
        let duration = writer.duration();
        writer.finish(duration);
        to
    }

    /// The frame in which the velocity starts above its limit, and whether it is the mirrored one.
    fn too_fast(&self) -> Option<(Problem, bool)> {
        let p = &self.problem;
        if starts_too_fast(p) {
            return Some((*p, false));
        }
        let mirrored = p.mirrored();
        starts_too_fast(&mirrored).then_some((mirrored, true))
    }

    /// The impossible durations above the shortest one, without the time of the phase before.
    pub fn gaps(&self, shortest: f64, mirrored: bool) -> Gaps {
        let Some((frame, _)) = self.too_fast() else {
            return gaps_inside(&self.problem, shortest, Some(mirrored));
        };
        let settling = gaps_inside(&self.problem, shortest, None);
        let Some(brake) = Brake::new(&frame) else {
            return settling;
        };
        // Braking first: the same question from the end of the brake on.
        let lead = brake.duration();
        let (shape, mirrored) = solve(&brake.rest, 0.0);
        let later = gaps_inside(&brake.rest, end_of(&brake.rest, &shape, mirrored, 0.0), Some(mirrored));
        settling.common(&later.delayed(shortest, lead))
    }

    /// A motion of this duration with one cruise velocity, if there is one.
    pub fn cruising(&self, duration: f64, out: &mut StateToState) -> bool {
        let Some(shape) = cruise::solve(&self.problem, duration - self.lead_time) else { return false };
        let mut writer = self.writer(out);
        writer.write(&self.problem, &shape, false, self.from, self.to);
        writer.finish(duration);
        true
    }

    /// The mean of the farthest motion of this duration and the least far one.
    pub fn between(&self, duration: f64, out: &mut StateToState) -> bool {
        let left = duration - self.lead_time;
        let mut writer = self.writer(out);
        let done = between(&self.problem, left, self.noise, (self.from, self.to), &mut writer)
            || self.between_after_braking(left, &mut writer);
        writer.finish(duration);
        done
    }

    fn between_after_braking(&self, left: f64, writer: &mut Writer<'_>) -> bool {
        let Some((frame, mirrored)) = self.too_fast() else { return false };
        let Some(brake) = Brake::new(&frame) else { return false };
        let from = writer.brake(&brake, mirrored, self.from);
        let to = if mirrored { -self.to } else { self.to };
        let left = left - brake.duration();
        if let Some(shape) = cruise::solve(&brake.rest, left) {
            writer.write(&brake.rest, &shape, false, from, to);
            return true;
        }
        between(&brake.rest, left, self.noise, (from, to), writer)
    }
}

fn gaps_inside(p: &Problem, shortest: f64, solved_mirrored: Option<bool>) -> Gaps {
    let rises = Direct::new(p).up;
    let mut gaps = Gaps::new(shortest);
    Extremals::new(p, rises).blocked(solved_mirrored == Some(false), &mut gaps);
    Extremals::new(&p.mirrored(), !rises).blocked(solved_mirrored == Some(true), &mut gaps);
    gaps
}

fn between(p: &Problem, t: f64, noise: f64, ends: (f64, f64), writer: &mut Writer<'_>) -> bool {
    let rises = Direct::new(p).up;
    let mirrored = p.mirrored();
    let up = Extremals::new(p, rises).at(t);
    let down = Extremals::new(&mirrored, !rises).at(t);
    let (Some(up), Some(down)) = (up, down) else { return false };
    // Beside a short way round-off of the formula would be a jump of the position.
    let up = (displacement(p, &up.1) - p.d, up.1);
    let down = (displacement(&mirrored, &down.1) - mirrored.d, down.1);
    // Round-off of the ends of the possible durations, and of the displacement.
    let slow = p.j.up.min(p.j.down);
    let lead = |v: f64, a: f64| a.abs() / slow * (v.abs() + a * a / slow);
    let speeds = p.v0.abs() + p.vf.abs() + p.v_max - p.v_min;
    let noise = 4.0 * noise + ROUND_OFF * (p.d.abs() + t * speeds + lead(p.v0, p.a0) + lead(p.vf, p.af));
    if up.0 < -noise || down.0 < -noise {
        return false;
    }
    Mean::new(p, t, (&up, &down), ends).map(|mean| mean.write(writer)).is_some()
}

const ROUND_OFF: f64 = 1e-13;

/// Returns true if the target can be entered at all: its acceleration cannot have come from
/// nowhere.
fn check_entry(t: &AxisState, l: &AxisLimits, j: &Jerks) -> Result<(), FeedError> {
    let slack = SLACK * l.v.1.max(-l.v.0);
    let change = 0.5 * t.a * t.a;
    let (before, limit) = if t.a > 0.0 { (t.v - change * j.inv_up, l.v.0) } else { (t.v + change * j.inv_down, l.v.1) };
    let excess = if t.a > 0.0 { limit - before } else { before - limit };
    if excess > slack { Err(FeedError::TargetUnreachable { v: t.v, a: t.a, before, limit }) } else { Ok(()) }
}
