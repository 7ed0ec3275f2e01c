//! The segments behind the present one that have arrived, with the speeds at which each may be
//! entered.

use std::collections::VecDeque;

use crate::error::FeedError;
use crate::scan::Segment;
use crate::scurve::solve::{raise, raise_from_any};

/// Largest look-ahead.
const MOST: usize = 1_000_000;

/// A segment that waits, and the highest speeds at its start.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Waiting {
    segment: Segment,
    /// Lower of the speed limits of the segments that meet at its start.
    cap: f64,
    /// From which the motion can stop at the end of the last segment, whatever arrives until then.
    bound: f64,
    /// From which it can pass the end of the last segment as fast as that one allows.
    free: f64,
}

/// A buffer of fixed size.
#[derive(Debug, Clone)]
pub(super) struct Window {
    waiting: VecDeque<Waiting>,
    most: usize,
    /// Speed limit of the last segment that has arrived.
    last: f64,
    finished: bool,
}

impl Window {
    pub fn new(most: usize) -> Result<Self, FeedError> {
        match most {
            0 => Err(FeedError::NotPositive { what: "look-ahead", value: 0.0 }),
            1..=MOST => Ok(Self { waiting: VecDeque::with_capacity(most), most, last: f64::INFINITY, finished: false }),
            got => Err(FeedError::TooMany { what: "segments of look-ahead", got, most: MOST }),
        }
    }

    /// Makes `segment`, which is not in the window, the one before the first.
    pub fn follows(&mut self, segment: &Segment) {
        self.last = segment.v_max();
    }

    pub fn push(&mut self, segment: Segment) -> Result<(), FeedError> {
        if self.finished {
            return Err(FeedError::StreamEnded);
        }
        if self.vacant() == 0 {
            return Err(FeedError::StreamFull { most: self.most });
        }
        let cap = self.last.min(segment.v_max());
        self.last = segment.v_max();
        // Speeds that no pass gives: the pass over the others must not stop before the new one.
        self.waiting.push_back(Waiting { segment, cap, bound: -1.0, free: -1.0 });
        self.pass();
        Ok(())
    }

    pub fn finish(&mut self) {
        self.finished = true;
        self.pass();
    }

    /// Backwards over the segments that wait, until nothing changes.
    fn pass(&mut self) {
        let (mut bound, mut free) = (0.0, self.free_end());
        for i in (0..self.waiting.len()).rev() {
            let Waiting { segment, cap, .. } = self.waiting[i];
            bound = cap.min(self.before(&segment, bound));
            free = cap.min(self.before(&segment, free));
            let new = Waiting { bound, free, ..self.waiting[i] };
            if new == self.waiting[i] {
                break;
            }
            self.waiting[i] = new;
        }
    }

    /// Highest speed at the start of `segment` for a speed at its end of at most `v`. A segment
    /// that arrives later may raise `v`, and no stop must follow from that.
    pub fn before(&self, segment: &Segment, v: f64) -> f64 {
        let (length, a, j) = (segment.length(), segment.a_max(), segment.j_max());
        if self.finished { raise(v, length, a, j) } else { raise_from_any(v, length, a, j) }
    }

    /// Speed at the end of the last segment if the motion did not have to stop there.
    const fn free_end(&self) -> f64 {
        if self.finished { 0.0 } else { self.last }
    }

    pub fn pop(&mut self) -> Option<Segment> {
        self.waiting.pop_front().map(|waiting| waiting.segment)
    }

    /// Highest speed at the end of the present segment from which the motion can stop. It never
    /// falls while that segment is run.
    pub fn bound(&self) -> f64 {
        self.waiting.front().map_or(0.0, |waiting| waiting.bound)
    }

    /// The same if it did not have to stop at the end of the last segment.
    pub fn free(&self) -> f64 {
        self.waiting.front().map_or(self.free_end(), |waiting| waiting.free)
    }

    pub fn vacant(&self) -> usize {
        self.most - self.waiting.len()
    }

    pub const fn is_finished(&self) -> bool {
        self.finished
    }
}
