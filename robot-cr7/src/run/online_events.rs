//! The events of an online motion in words.

use arcfeed_sync::{Events, SyncError};
use serde::Serialize;

/// Something that happened during a motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Happening {
    /// The time, s.
    pub t_s: f64,
    /// The event in words.
    pub what: String,
}

/// Turns the events of cycles into happenings, each told once.
#[derive(Debug)]
pub(crate) struct Teller<const N: usize> {
    /// The joints arrive one by one.
    independent: bool,
    outside: bool,
    braking: [bool; N],
}

impl<const N: usize> Teller<N> {
    pub const fn new(independent: bool) -> Self {
        Self { independent, outside: false, braking: [false; N] }
    }

    /// Tells what happened in the cycle from `begin` to `end` (s).
    pub fn tell(&mut self, events: &Events<N>, (begin, end): (f64, f64), to: &mut Vec<Happening>) {
        let mut say = |t_s: f64, what: String| to.push(Happening { t_s, what });
        if events.outside_limits && !self.outside {
            say(begin, "a joint is outside its new limits and on the way back inside".to_owned());
        }
        if self.outside && !events.outside_limits {
            say(end, "all joints are inside their limits".to_owned());
        }
        self.outside = events.outside_limits;
        for k in 0..N {
            if self.independent && events.arrived[k] {
                say(end, format!("joint {} arrives", k + 1));
            }
            if events.range_ends[k] && !self.braking[k] {
                say(begin, format!("joint {} brakes: its range ends", k + 1));
            }
        }
        self.braking = events.range_ends;
        if events.reached {
            say(end, "target reached".to_owned());
        }
    }
}

/// The same error with the positions of joints in degrees, and what to say of the unit.
pub(crate) fn in_degrees(error: SyncError) -> (SyncError, &'static str) {
    let error = match error {
        SyncError::OutsideRange { axis, what, position, lower, upper } => SyncError::OutsideRange {
            axis,
            what,
            position: position.to_degrees(),
            lower: lower.to_degrees(),
            upper: upper.to_degrees(),
        },
        SyncError::LeavesRange { axis, position, time, limit } => {
            SyncError::LeavesRange { axis, position: position.to_degrees(), time, limit: limit.to_degrees() }
        }
        SyncError::CannotStop { axis, what, position, limit } => {
            SyncError::CannotStop { axis, what, position: position.to_degrees(), limit: limit.to_degrees() }
        }
        other => return (other, ""),
    };
    (error, " (in degrees)")
}
