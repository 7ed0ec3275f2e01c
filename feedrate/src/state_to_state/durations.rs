//! The durations in which a state can be reached.

/// At most so many separate blocked intervals are kept; two is the most there are with one axis
/// inside its limits.
const CAPACITY: usize = 4;

/// The shortest duration of a motion, and the longer ones that are impossible.
///
/// Between two moving states not every duration above the shortest can be met: a car at full speed,
/// ten metres before the point where it is to be at full speed, is there in one moment or only
/// after having turned back. All of these *blocked intervals* are open: their ends are possible.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Durations {
    pub(super) shortest: f64,
    pub(super) blocked: [(f64, f64); CAPACITY],
    pub(super) count: usize,
}

impl Durations {
    /// The shortest duration (s).
    pub const fn shortest(&self) -> f64 {
        self.shortest
    }

    /// The open intervals above the shortest duration that are impossible (s), in order and
    /// disjoint.
    pub fn blocked(&self) -> &[(f64, f64)] {
        &self.blocked[..self.count]
    }

    /// Returns true if the target can be reached in exactly `duration` (s).
    pub fn contains(&self, duration: f64) -> bool {
        duration >= self.shortest && !self.blocked().iter().any(|&(a, b)| a < duration && duration < b)
    }

    /// The shortest possible duration that is not below `least` (s).
    pub fn at_least(&self, least: f64) -> f64 {
        let least = self.shortest.max(least);
        self.blocked().iter().find(|&&(a, b)| a < least && least < b).map_or(least, |&(_, b)| b)
    }

    /// The longest possible duration that is not above `most` (s); `None` if even the shortest is.
    pub fn at_most(&self, most: f64) -> Option<f64> {
        let inside = self.blocked().iter().find(|&&(a, b)| a < most && most < b).map_or(most, |&(a, _)| a);
        (inside >= self.shortest).then_some(inside)
    }
}

/// Impossible durations after a possible one, while they are collected.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gaps {
    pub after: f64,
    ranges: [(f64, f64); CAPACITY],
    count: usize,
}

impl Gaps {
    pub fn new(after: f64) -> Self {
        Self { after, ranges: [(0.0, 0.0); CAPACITY], count: 0 }
    }

    /// Returns true if `t` is later than the possible duration by more than round-off.
    pub fn is_after(&self, t: f64) -> bool {
        t > self.after * (1.0 + ROUND_OFF)
    }

    /// Adds the durations between `from` and `to`.
    pub fn add(&mut self, from: f64, to: f64) {
        let (mut from, mut to) = (from.max(self.after), to);
        if !(self.is_after(to) && from < to) {
            return;
        }
        let mut kept = 0;
        for i in 0..self.count {
            let (a, b) = self.ranges[i];
            if a <= to && from <= b {
                (from, to) = (from.min(a), to.max(b));
            } else {
                self.ranges[kept] = (a, b);
                kept += 1;
            }
        }
        if kept == CAPACITY {
            // More than there can be: everything from the first to the last counts as blocked.
            for &(a, b) in &self.ranges {
                (from, to) = (from.min(a), to.max(b));
            }
            kept = 0;
        }
        let at = self.ranges[..kept].iter().take_while(|r| r.0 < from).count();
        self.ranges.copy_within(at..kept, at + 1);
        self.ranges[at] = (from, to);
        self.count = kept + 1;
    }

    /// The durations that are impossible by both counts.
    pub fn common(&self, other: &Self) -> Self {
        let mut all = Self::new(self.after);
        for a in &self.ranges[..self.count] {
            for b in &other.ranges[..other.count] {
                all.add(a.0.max(b.0), a.1.min(b.1));
            }
        }
        all
    }

    /// The same with `lead` before all of them, above a possible duration `after`; all before the
    /// first one are impossible.
    pub fn delayed(&self, after: f64, lead: f64) -> Self {
        let mut all = Self::new(after);
        all.add(after, lead + self.after);
        for r in &self.ranges[..self.count] {
            all.add(lead + r.0, lead + r.1);
        }
        all
    }

    /// As public durations; `to` converts each time.
    pub fn durations(&self, shortest: f64, to: impl Fn(f64) -> f64) -> Durations {
        let mut blocked = [(0.0, 0.0); CAPACITY];
        for (out, &(a, b)) in blocked.iter_mut().zip(&self.ranges[..self.count]) {
            *out = (to(a), to(b));
        }
        Durations { shortest, blocked, count: self.count }
    }
}

/// An interval that ends this close to the possible duration is the one that ends there.
const ROUND_OFF: f64 = 1e-12;
