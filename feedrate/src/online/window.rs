//! The segments behind the present one that have arrived, with the speeds at which each may be
//! entered.

use std::collections::VecDeque;

use crate::error::FeedError;
use crate::scan::Segment;
use crate::scan::per_segment::backward_step;

/// Largest look-ahead.
const MOST: usize = 1_000_000;

/// A segment that waits, and the highest speeds at its start.
#[derive(Debug, Clone, Copy)]
struct Waiting {
    segment: Segment,
    /// Lower of the speed limits of the segments that meet at its start.
    cap: f64,
    /// From which the motion can stop at the end of the last segment.
    stop: f64,
    /// From which it can pass that end as fast as the last segment allows.
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
        self.waiting.push_back(Waiting { segment, cap, stop: -1.0, free: -1.0 });
        self.pass();
        Ok(())
    }

    pub fn finish(&mut self) {
        self.finished = true;
        self.pass();
    }

    /// Backwards over the segments that wait, until nothing changes.
    fn pass(&mut self) {
        let (mut stop, mut free) = self.end();
        for waiting in self.waiting.iter_mut().rev() {
            stop = backward_step(&waiting.segment, waiting.cap, stop, true);
            free = backward_step(&waiting.segment, waiting.cap, free, true);
            if stop == waiting.stop && free == waiting.free {
                break;
            }
            (waiting.stop, waiting.free) = (stop, free);
        }
    }

    /// Speeds at the end of the last segment.
    fn end(&self) -> (f64, f64) {
        (0.0, if self.finished { 0.0 } else { self.last })
    }

    pub fn pop(&mut self) -> Option<Segment> {
        self.waiting.pop_front().map(|waiting| waiting.segment)
    }

    /// Highest speed at the end of the present segment from which the motion can stop.
    pub fn stop(&self) -> f64 {
        self.waiting.front().map_or(self.end().0, |waiting| waiting.stop)
    }

    /// The same if it did not have to stop at the end of the last segment.
    pub fn free(&self) -> f64 {
        self.waiting.front().map_or(self.end().1, |waiting| waiting.free)
    }

    pub fn vacant(&self) -> usize {
        self.most - self.waiting.len()
    }

    pub const fn is_finished(&self) -> bool {
        self.finished
    }
}
