//! The simulated controller as a wire without a network, as fast as the machine is.

use std::cell::Cell;
use std::collections::VecDeque;
use std::rc::Rc;

use arcfeed_testing::Random;
use robot_cr7::controller::{Channel, FEEDBACK_BYTES, LinkError, Wire};

use super::controller::SimulatedController;
use super::disturbance::Disturbance;

/// How long before the interruption the motion connection stands still, ms.
const BEFORE: u64 = 100;

/// Bytes on their way on one connection, with the time at which they arrive, ms.
type Travelling = VecDeque<(u64, Vec<u8>)>;

/// The next bytes that arrive until the time `now`, ms.
fn arrived(queue: &mut Travelling, now: u64) -> Option<Vec<u8>> {
    let due = queue.front().is_some_and(|(at, _)| *at <= now);
    if due { queue.pop_front().map(|(_, bytes)| bytes) } else { None }
}

/// The connections on which a controller speaks.
const BACK: [Channel; 2] = [Channel::Dashboard, Channel::Feedback];

/// A link with delay and jitter, and its own faults.
#[derive(Debug)]
pub struct InProcess {
    controller: SimulatedController,
    fault: Disturbance,
    fault_at: u64,
    random: Random,
    /// Largest jitter in each direction, ms.
    jitter: usize,
    /// To the dashboard port and the motion port. Connections keep no order between each other.
    out: [Travelling; 2],
    /// From the dashboard port and the feedback port.
    back: [Travelling; 2],
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

    /// When bytes that leave now arrive: never before those that left earlier by the same connection.
    fn arrival(&mut self, channel: Channel, last: Option<u64>) -> u64 {
        let now = self.controller.time();
        let mut at = now + self.random.below(self.jitter + 1) as u64;
        match self.fault {
            Disturbance::Delayed(duration) if self.faulty() => at = at.max(self.fault_at + duration),
            Disturbance::Overtaken(duration) if channel == Channel::Motion && now + BEFORE >= self.fault_at => {
                at = at.max(self.fault_at + duration);
            }
            _ => {}
        }
        at.max(last.unwrap_or(0))
    }

    fn step(&mut self) {
        self.controller.step();
        let now = self.controller.time();
        self.clock.set(now);
        for (port, out) in self.out.iter_mut().enumerate() {
            while let Some(bytes) = arrived(out, now) {
                self.controller.hear(port == 1, &bytes);
            }
        }
        let replies = self.controller.take_replies();
        let feedback = self.controller.take_feedback();
        for (port, bytes) in [replies, feedback].into_iter().enumerate() {
            if !bytes.is_empty() {
                let at = self.arrival(BACK[port], self.back[port].back().map(|(at, _)| *at));
                self.back[port].push_back((at, bytes));
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
        let port = usize::from(channel == Channel::Motion);
        let at = self.arrival(channel, self.out[port].back().map(|(at, _)| *at));
        self.out[port].push_back((at, bytes.to_vec()));
        Ok(())
    }

    fn receive(&mut self, until: f64, bytes: &mut [u8; FEEDBACK_BYTES]) -> Result<Option<(Channel, usize)>, LinkError> {
        if let (Disturbance::Stalled(duration), true, false) = (self.fault, self.faulty(), self.stalled) {
            self.stalled = true;
            self.pass(duration);
        }
        loop {
            let now = self.controller.time();
            let lost = self.fault == Disturbance::Lost && self.faulty();
            for (channel, back) in BACK.into_iter().zip(&mut self.back) {
                if let Some(piece) = arrived(back, now).filter(|_| !lost) {
                    bytes[..piece.len()].copy_from_slice(&piece);
                    return Ok(Some((channel, piece.len())));
                }
            }
            if self.now() >= until {
                return if lost { Err(LinkError::Closed(Channel::Feedback)) } else { Ok(None) };
            }
            self.step();
        }
    }
}
