//! Limits and ranges that are set while the online generator follows a command and its time is scaled.

use arcfeed_sync::SyncError;
use arcfeed_testing::Random;

use super::Outcome;
use super::generator_input::{AXES, Limits};
use super::interrupts::{Expect, Play, Verdict, cycles, stop_time, wrong};

impl Play {
    /// One of five kinds of change, from 13 on.
    pub(super) fn change(&mut self, which: usize, rng: &mut Random, outcome: &mut Outcome) -> Verdict {
        match which {
            13 | 14 => self.change_limits(rng, outcome),
            15 => self.change_both(rng, outcome),
            _ => self.change_ranges(rng, outcome),
        }
    }

    fn new_limits(&self, rng: &mut Random) -> Limits {
        if rng.chance(0.5) { self.scene.any_limits(rng) } else { self.scene.drifted(&self.limits, rng) }
    }

    /// Other limits for what is under way, or for one axis of it.
    fn change_limits(&mut self, rng: &mut Random, outcome: &mut Outcome) -> Verdict {
        let (mut limits, k) = (self.new_limits(rng), rng.below(AXES));
        let done = if rng.chance(0.3) {
            limits = std::array::from_fn(|i| if i == k { limits[i] } else { self.limits[i] });
            self.generator.set_axis_limits(k, limits[k])
        } else {
            self.generator.set_limits(limits)
        };
        self.note("set_limits", &format!("{limits:?}"), &done, outcome);
        if done.is_ok() {
            (self.limits, self.lowered) = (limits, true);
            self.expect_anew();
        }
        Ok(())
    }

    /// Target and limits at once, for one axis or for all.
    fn change_both(&mut self, rng: &mut Random, outcome: &mut Outcome) -> Verdict {
        let (rest, limits) = (rng.chance(0.6), self.new_limits(rng));
        let target = self.scene.target(rest, &limits, rng);
        let done = self.generator.set(target, limits);
        self.note("set", &format!("{target:?} {limits:?}"), &done, outcome);
        match done {
            Ok(()) => {
                (self.limits, self.lowered) = (limits, true);
                self.path_over();
                Ok(())
            }
            Err(e) if rest && self.scene.ranges.is_none() => wrong(format!("refused without a reason: {e}"), 1.0),
            Err(_) => Ok(()),
        }
    }

    /// Ranges around where the axes are, mostly near.
    fn change_ranges(&mut self, rng: &mut Random, outcome: &mut Outcome) -> Verdict {
        let here = self.now;
        let ends = self.generator.target().map(|s| s.p);
        let ranges: [(f64, f64); AXES] = std::array::from_fn(|k| {
            let (low, high) = (here[k].p.min(ends[k]), here[k].p.max(ends[k]));
            (low - rng.log(1e-3, 4.0), high + rng.log(1e-3, 4.0))
        });
        let changed = self.generator.clone().with_ranges(ranges);
        let done = changed.map(|generator| self.generator = generator);
        self.note("with_ranges", &format!("{ranges:?}"), &done, outcome);
        if done.is_ok() {
            self.scene.ranges = Some(ranges);
            self.expect_anew();
            // A stop takes the place of one on the path that goes on behind its end.
            if self.generator.target().map(|s| s.p) != ends {
                (self.path_limits, self.braking) = (None, true);
            }
        }
        Ok(())
    }

    /// What is under way goes on in another way.
    fn expect_anew(&mut self) {
        self.curve = None;
        self.expect = match self.expect {
            Expect::Rest(left) => {
                let time = 2.0 * self.generator.time_left() + stop_time(&self.now, &self.limits) + 1.0;
                Expect::Rest(left.max(cycles(self.scene.cycle, time)))
            }
            _ => Expect::Nothing,
        };
    }

    fn note(&mut self, name: &str, what: &str, done: &Result<(), SyncError>, outcome: &mut Outcome) {
        outcome.see(&format!("{name}{}", if done.is_err() { ", refused" } else { "" }));
        self.log.push(format!("{name} {what}: {done:?}"));
    }
}
