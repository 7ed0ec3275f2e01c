//! The setpoints that an arm may still be on its way to.

use arcfeed_kinematics::Joints;

/// Most setpoints that lie within the lag.
pub(super) const MOST_RECENT: usize = 128;

/// The last setpoints with the times at which they were sent (s): a ring.
#[derive(Debug)]
pub(super) struct Recent<const N: usize> {
    ring: [(f64, Joints<N>); MOST_RECENT],
    sent: usize,
}

impl<const N: usize> Recent<N> {
    /// No setpoint yet: an arm that stands at `start`, rad.
    pub(super) fn new(start: Joints<N>) -> Self {
        Self { ring: [(f64::NEG_INFINITY, start); MOST_RECENT], sent: 0 }
    }

    /// Takes a setpoint that is sent at time `now`, s.
    pub(super) fn push(&mut self, now: f64, q: Joints<N>) {
        self.ring[self.sent % MOST_RECENT] = (now, q);
        self.sent += 1;
    }

    /// The setpoint that was sent last, rad; the start before the first one.
    pub(super) fn last(&self) -> &Joints<N> {
        &self.ring[self.sent.saturating_sub(1) % MOST_RECENT].1
    }

    /// The least and the largest position of each joint that was asked of it since the time `since` (s), and in force then.
    pub(super) fn range(&self, since: f64) -> (Joints<N>, Joints<N>) {
        let (mut least, mut most) = (*self.last(), *self.last());
        let mut before = self.ring[self.sent % MOST_RECENT];
        for (at, q) in &self.ring {
            if *at >= since {
                (least, most) = (least.inf(q), most.sup(q));
            } else if *at > before.0 {
                before = (*at, *q);
            }
        }
        (least.inf(&before.1), most.sup(&before.1))
    }
}
