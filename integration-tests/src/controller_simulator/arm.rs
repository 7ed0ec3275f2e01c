//! The arm: setpoints, drives that lag, brakes. Degrees and seconds; a step is 1 ms.

use std::collections::VecDeque;

/// A step, s.
pub const STEP: f64 = 1e-3;
/// Periods between the first setpoint and its playing.
const AHEAD: f64 = 2.0;
/// A value may exceed its limit by this part: the digits of the setpoints.
const ROUNDING: f64 = 1e-3;

/// Limits of each joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmLimits {
    /// Least positions.
    pub lower: [f64; 6],
    /// Largest positions.
    pub upper: [f64; 6],
    /// Velocities.
    pub velocity: [f64; 6],
    /// Accelerations.
    pub acceleration: [f64; 6],
}

/// A limit that the arm exceeded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excess {
    /// Which one.
    pub what: &'static str,
    /// The joint, from 0.
    pub joint: usize,
    /// The value.
    pub value: f64,
    /// The limit.
    pub limit: f64,
}

#[derive(Debug, Clone, Copy)]
struct Brake {
    from: [f64; 6],
    velocity: [f64; 6],
    duration: f64,
    elapsed: f64,
}

/// Six joints that follow setpoints.
#[derive(Debug, Clone)]
pub struct SimulatedArm {
    limits: ArmLimits,
    lag: f64,
    waiting: VecDeque<([f64; 6], f64)>,
    /// Time until the first setpoint is played; none while one is played or nothing waits.
    countdown: Option<f64>,
    /// End, duration and elapsed time of the line that is played, and its start.
    line: Option<([f64; 6], f64, f64)>,
    line_start: [f64; 6],
    line_velocity: [f64; 6],
    on_line: [f64; 6],
    window: VecDeque<[f64; 6]>,
    reference: [f64; 6],
    reference_velocity: [f64; 6],
    brake: Option<Brake>,
    stuck: Option<usize>,
    q: [f64; 6],
    velocity: [f64; 6],
    excess: Option<Excess>,
    starved: bool,
}

impl SimulatedArm {
    /// An arm at rest whose drives lag by `lag` seconds.
    pub fn new(q: [f64; 6], limits: ArmLimits, lag: f64) -> Self {
        Self {
            limits,
            lag,
            waiting: VecDeque::new(),
            countdown: None,
            line: None,
            line_start: q,
            line_velocity: [0.0; 6],
            on_line: q,
            window: VecDeque::from([q]),
            reference: q,
            reference_velocity: [0.0; 6],
            brake: None,
            stuck: None,
            q,
            velocity: [0.0; 6],
            excess: None,
            starved: false,
        }
    }

    /// Actual positions.
    pub fn q(&self) -> &[f64; 6] {
        &self.q
    }

    /// Actual velocities.
    pub fn velocity(&self) -> &[f64; 6] {
        &self.velocity
    }

    /// The positions asked of the drives, and their velocities.
    pub fn reference(&self) -> (&[f64; 6], &[f64; 6]) {
        (&self.reference, &self.reference_velocity)
    }

    /// The first limit that was exceeded.
    pub fn excess(&self) -> Option<Excess> {
        self.excess
    }

    /// True if setpoints stayed out while it moved, or one asked for too much acceleration; asked once.
    pub fn take_starved(&mut self) -> bool {
        std::mem::take(&mut self.starved)
    }

    /// True while setpoints are played or wait, or it brakes.
    pub fn is_led(&self) -> bool {
        self.line.is_some() || !self.waiting.is_empty() || self.brake.is_some()
    }

    /// True if no joint moves.
    pub fn rests(&self) -> bool {
        self.velocity.iter().all(|v| v.abs() < 0.01) && self.reference_velocity.iter().all(|v| v.abs() < 0.01)
    }

    /// A setpoint that is to be reached `period` seconds after the one before.
    pub fn follow(&mut self, q: [f64; 6], period: f64) {
        if self.brake.is_some() {
            return;
        }
        if self.line.is_none() && self.waiting.is_empty() {
            self.countdown = Some(AHEAD * period);
        }
        self.waiting.push_back((q, period));
    }

    /// Forgets all setpoints and comes to rest within the limits.
    pub fn stop(&mut self) {
        self.waiting.clear();
        self.line = None;
        self.countdown = None;
        if self.brake.is_some() {
            return;
        }
        let times = (0..6).map(|k| self.reference_velocity[k].abs() / self.limits.acceleration[k]);
        let duration = times.fold(0.0, f64::max);
        if duration > 0.0 {
            let (from, velocity) = (self.reference, self.reference_velocity);
            self.brake = Some(Brake { from, velocity, duration, elapsed: 0.0 });
        } else {
            self.settle();
        }
    }

    /// A joint that moves no more, whatever is asked of it.
    pub fn block(&mut self, joint: usize) {
        self.stuck = Some(joint);
    }

    /// The next millisecond.
    pub fn step(&mut self) {
        let before = self.reference;
        if self.brake.is_none() {
            self.play();
        }
        match &mut self.brake {
            Some(brake) => {
                brake.elapsed = (brake.elapsed + STEP).min(brake.duration);
                let (e, d) = (brake.elapsed, brake.duration);
                self.reference = std::array::from_fn(|k| brake.from[k] + brake.velocity[k] * (e - 0.5 * e * e / d));
                self.reference_velocity = std::array::from_fn(|k| brake.velocity[k] * (1.0 - e / d));
                if e >= d {
                    self.settle();
                }
            }
            None => self.reference_velocity = std::array::from_fn(|k| (self.reference[k] - before[k]) / STEP),
        }
        self.drive();
    }

    /// Rests at the reference.
    fn settle(&mut self) {
        self.brake = None;
        (self.reference_velocity, self.line_velocity) = ([0.0; 6], [0.0; 6]);
        (self.on_line, self.line_start) = (self.reference, self.reference);
        self.window = VecDeque::from([self.reference]);
    }

    /// Moves along the lines between the setpoints, and takes the mean.
    fn play(&mut self) {
        if let Some(left) = &mut self.countdown {
            *left -= STEP;
            if *left <= 0.5 * STEP {
                self.countdown = None;
            }
        }
        if self.line.is_none() && self.countdown.is_none() {
            self.begin_line();
            if self.brake.is_some() {
                return;
            }
        }
        if let Some((end, period, elapsed)) = &mut self.line {
            *elapsed += STEP;
            let part = (*elapsed / *period).min(1.0);
            self.on_line = std::array::from_fn(|k| self.line_start[k] + (end[k] - self.line_start[k]) * part);
            if part >= 1.0 - 1e-9 {
                let fast = (0..6).any(|k| self.line_velocity[k].abs() > 0.5 * self.limits.acceleration[k] * *period);
                self.on_line = *end;
                self.line = None;
                if self.waiting.is_empty() {
                    if fast {
                        self.starved = true;
                        return self.stop();
                    }
                    self.line_velocity = [0.0; 6];
                }
            }
        }
        self.window.push_back(self.on_line);
        self.window.pop_front();
        let count = self.window.len() as f64;
        self.reference = std::array::from_fn(|k| self.window.iter().map(|q| q[k]).sum::<f64>() / count);
    }

    /// Takes the next setpoint, unless it asks for too much.
    fn begin_line(&mut self) {
        let Some((end, period)) = self.waiting.pop_front() else { return };
        let velocity: [f64; 6] = std::array::from_fn(|k| (end[k] - self.on_line[k]) / period);
        let most = |k: usize| self.limits.acceleration[k] * period * (1.0 + ROUNDING) + 1e-3;
        if (0..6).any(|k| (velocity[k] - self.line_velocity[k]).abs() > most(k)) {
            self.starved = true;
            return self.stop();
        }
        (self.line_start, self.line_velocity) = (self.on_line, velocity);
        self.line = Some((end, period, 0.0));
        let count = ((period / STEP).round() as usize).max(1);
        while self.window.len() < count {
            self.window.push_front(self.window[0]);
        }
        self.window.drain(..self.window.len() - count);
    }

    /// The drives follow the reference, and the limits are looked at.
    fn drive(&mut self) {
        let part = 1.0 - (-STEP / self.lag).exp();
        for k in 0..6 {
            let velocity = if self.stuck == Some(k) {
                let slower = self.velocity[k].abs() - self.limits.acceleration[k] * STEP;
                slower.max(0.0).copysign(self.velocity[k])
            } else {
                (self.reference[k] - self.q[k]) * part / STEP
            };
            let acceleration = (velocity - self.velocity[k]) / STEP;
            self.q[k] += velocity * STEP;
            self.velocity[k] = velocity;
            let checks = [
                ("velocity", velocity.abs(), self.limits.velocity[k]),
                ("acceleration", acceleration.abs(), self.limits.acceleration[k]),
                ("upper end", self.q[k], self.limits.upper[k]),
                ("lower end", -self.q[k], -self.limits.lower[k]),
            ];
            for (what, value, limit) in checks {
                // Not `>`: a NaN has to show.
                let holds = value <= limit + ROUNDING * limit.abs() + 1e-3;
                if !holds && self.excess.is_none() {
                    self.excess = Some(Excess { what, joint: k, value, limit });
                }
            }
        }
    }
}
