//! From a route to a motion.

use arcfeed_feedrate::AxisState;

use super::guess::Guess;
use super::program::Program;
use super::route::Route;
use super::trajectory::{WayPointTrajectory, section};
use super::{NODES, SECTIONS};
use crate::error::SyncError;

pub struct WayPointPlanner<const N: usize> {
    program: Program<N>,
    pub parts: usize,
    pub rounds: usize,
    pub debug: (f64, usize),
}

/// Times that the velocities next to a section are lowered before they are 0.
const LOWERINGS: usize = 3;
const SLACK: f64 = 1.02;

/// A section is repaired if it takes that much longer than in the program.
const LONGER: f64 = 1.25;
const SLOWER: f64 = 1.03;
const FADING: f64 = 0.6;

impl<const N: usize> Default for WayPointPlanner<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> WayPointPlanner<N> {
    pub const fn new() -> Self {
        Self { program: Program::new(), parts: 1, rounds: 12, debug: (0.0, 0) }
    }

    pub fn plan(
        &mut self,
        start: &[AxisState; N],
        route: &Route<'_, N>,
    ) -> Result<WayPointTrajectory<N>, SyncError> {
        route.check(start)?;
        let n = route.sections();
        let guess = Guess::new(start, route);
        let parts = self.parts;
        guess.write(route, parts, &mut self.program);
        self.program.slow_down();
        self.program.improve(self.rounds);
        self.debug = (self.program.total(), 0);
        let mut motion = self.read(&guess, route);
        let fine = settle(&mut motion, route, &self.excess(n));
        if fine && motion.duration() <= SLACK * self.program.best_total() {
            return Ok(motion);
        }
        self.debug.1 = 1;
        self.program.take_best();
        let mut other = self.read(&guess, route);
        if settle(&mut other, route, &self.excess(n)) && !(fine && motion.duration() <= other.duration()) {
            return Ok(other);
        }
        if fine {
            return Ok(motion);
        }
        self.debug.1 = 1000;
        rest(&mut motion, route)?;
        Ok(motion)
    }

    fn excess(&self, n: usize) -> [f64; SECTIONS] {
        let parts = self.parts;
        let mut excess = [1.0; SECTIONS];
        for (i, x) in excess[..n].iter_mut().enumerate() {
            *x = (i * parts..(i + 1) * parts).fold(1.0, |f: f64, s| f.max(self.program.excess(s)));
        }
        excess
    }

    fn read(&self, guess: &Guess<N>, route: &Route<'_, N>) -> WayPointTrajectory<N> {
        let (n, parts) = (route.sections(), self.parts);
        let mut motion = WayPointTrajectory {
            sections: n,
            states: guess.states,
            durations: [0.0; SECTIONS],
            limits: [*route.limits(0); SECTIONS],
        };
        for i in 0..n {
            motion.limits[i] = *route.limits(i);
            motion.durations[i] = self.program.durations[i * parts..(i + 1) * parts].iter().sum();
            if i > 0 {
                for k in 0..N {
                    let s = self.program.node(i * parts, k);
                    motion.states[i][k] = AxisState { p: motion.states[i][k].p, ..s };
                }
            }
        }
        motion
    }
}

/// All axes rest in the points, as far as no velocity is given.
fn rest<const N: usize>(motion: &mut WayPointTrajectory<N>, route: &Route<'_, N>) -> Result<(), SyncError> {
    for (state, point) in motion.states[1..].iter_mut().zip(route.points) {
        for (s, given) in state.iter_mut().zip(point.velocity()) {
            *s = AxisState::new(s.p, given.unwrap_or(0.0), 0.0);
        }
    }
    for i in 0..motion.sections {
        let made = section(&motion.states[i], &motion.states[i + 1], &motion.limits[i], route.least_duration(i))?;
        motion.durations[i] = made.duration();
    }
    Ok(())
}

/// Replaces the durations of the program by the exact ones. Where a section is impossible or longer,
/// the motion around it is slowed down.
fn settle<const N: usize>(
    motion: &mut WayPointTrajectory<N>,
    route: &Route<'_, N>,
    excess: &[f64; SECTIONS],
) -> bool {
    let n = motion.sections;
    let planned = motion.states;
    let expected = motion.durations;
    let mut factors = [1.0_f64; NODES];
    let mut dirty = [true; SECTIONS];
    for _ in 0..=LOWERINGS {
        let mut wanted = factors;
        let mut failed = false;
        for i in 0..n {
            if !std::mem::take(&mut dirty[i]) {
                continue;
            }
            let made = section(&motion.states[i], &motion.states[i + 1], &motion.limits[i], route.least_duration(i));
            match made {
                Ok(made) if made.duration() <= LONGER * expected[i] => {
                    motion.durations[i] = made.duration();
                }
                _ => {
                    failed = true;
                    dirty[i] = true;
                    let factor = factors[i].max(factors[i + 1]) * excess[i].max(SLOWER);
                    wanted[i] = wanted[i].max(factor);
                    wanted[i + 1] = wanted[i + 1].max(factor);
                }
            }
        }
        if !failed {
            return true;
        }
        for i in 1..=n {
            wanted[i] = wanted[i].max(1.0 + FADING * (wanted[i - 1] - 1.0));
        }
        for i in (0..n).rev() {
            wanted[i] = wanted[i].max(1.0 + FADING * (wanted[i + 1] - 1.0));
        }
        for i in 1..n {
            if wanted[i] <= factors[i] * 1.001 {
                continue;
            }
            factors[i] = wanted[i];
            let f = 1.0 / wanted[i];
            for (k, given) in route.points[i - 1].velocity().iter().enumerate() {
                motion.states[i][k].v = given.unwrap_or(f * planned[i][k].v);
                motion.states[i][k].a = f * f * planned[i][k].a;
            }
            (dirty[i - 1], dirty[i]) = (true, true);
        }
    }
    false
}
