//! The simulated controller as a wire without a network, as fast as the machine is.

use std::cell::Cell;
use std::collections::VecDeque;
use std::rc::Rc;

use arcfeed_testing::Random;
use robot_cr7::controller::{Channel, FEEDBACK_BYTES, LinkError, Wire};

use super::controller::SimulatedController;
use super::disturbance::Disturbance;

/// Bytes on their way: when they arrive (ms), their connection.
type Travelling = VecDeque<(u64, Channel, Vec<u8>)>;

/// A link with delay and jitter, and its own faults.
#[derive(Debug)]
pub struct InProcess {
    controller: SimulatedController,
    fault: Disturbance,
    fault_at: u64,
    random: Random,
    /// Largest jitter in each direction, ms.
    jitter: usize,
    out: Travelling,
    back: Travelling,
    stalled: bool,
    clock: Rc<Cell<u64>>,
}

impl InProcess {
    /// A link to a controller, with up to `jitter` ms in each direction; `fault` begins at `fault_at` (ms).
    pub fn new(
        controller: SimulatedController,
        jitter: usize,
        (fault, fault_at): (Disturbance, u64),
        seed: u64,
    ) -> Self {
        let random = Random::new(seed);
        let (out, back) = Default::default();
        Self { controller, fault, fault_at, random, jitter, out, back, stalled: false, clock: Rc::default() }
    }

    /// The controller.
    pub fn controller(&self) -> &SimulatedController {
        &self.controller
    }

    /// The time in ms, for those who cannot see the link.
    pub fn clock(&self) -> Rc<Cell<u64>> {
        self.clock.clone()
    }

    /// Lets time pass, ms.
    pub fn pass(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds {
            self.step();
        }
    }

    fn faulty(&self) -> bool {
        self.controller.time() >= self.fault_at
    }

    /// When bytes that leave now arrive: never before those that left earlier.
    fn arrival(&mut self, last: Option<u64>) -> u64 {
        let now = self.controller.time();
        let mut at = now + self.random.below(self.jitter + 1) as u64;
        if let (Disturbance::Delayed(duration), true) = (self.fault, self.faulty()) {
            at = at.max(self.fault_at + duration);
        }
        at.max(last.unwrap_or(0))
    }

    fn step(&mut self) {
        self.controller.step();
        let now = self.controller.time();
        self.clock.set(now);
        while self.out.front().is_some_and(|(at, ..)| *at <= now) {
            if let Some((_, channel, bytes)) = self.out.pop_front() {
                self.controller.hear(channel == Channel::Motion, &bytes);
            }
        }
        let replies = self.controller.take_replies();
        let feedback = self.controller.take_feedback();
        for (channel, bytes) in [(Channel::Dashboard, replies), (Channel::Feedback, feedback)] {
            if !bytes.is_empty() {
                let at = self.arrival(self.back.back().map(|(at, ..)| *at));
                self.back.push_back((at, channel, bytes));
            }
        }
    }
}

impl Wire for InProcess {
    fn now(&self) -> f64 {
        self.controller.time() as f64 * 1e-3
    }

    fn send(&mut self, channel: Channel, bytes: &[u8]) -> Result<(), LinkError> {
        match self.fault {
            Disturbance::Lost if self.faulty() => return Err(LinkError::Closed(channel)),
            Disturbance::Deaf if self.faulty() => return Ok(()),
            _ => {}
        }
        let at = self.arrival(self.out.back().map(|(at, ..)| *at));
        self.out.push_back((at, channel, bytes.to_vec()));
        Ok(())
    }

    fn receive(&mut self, until: f64, bytes: &mut [u8; FEEDBACK_BYTES]) -> Result<Option<(Channel, usize)>, LinkError> {
        if let (Disturbance::Stalled(duration), true, false) = (self.fault, self.faulty(), self.stalled) {
            self.stalled = true;
            self.pass(duration);
        }
        loop {
            if self.fault == Disturbance::Lost && self.faulty() {
                return Err(LinkError::Closed(Channel::Feedback));
            }
            let now = self.controller.time();
            let due = self.back.front().is_some_and(|(at, ..)| *at <= now);
            if let Some((_, channel, piece)) = if due { self.back.pop_front() } else { None } {
                bytes[..piece.len()].copy_from_slice(&piece);
                return Ok(Some((channel, piece.len())));
            }
            if self.now() >= until {
                return Ok(None);
            }
            self.step();
        }
    }
}
