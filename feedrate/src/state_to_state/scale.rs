//! Powers of two that bring the numbers of a problem near 1, exactly.

use crate::limits::AxisLimits;
use crate::state::AxisState;

/// Units of length and time as exponents of two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Units {
    length: i32,
    time: i32,
}

/// Within these exponents nothing that is computed on the way can leave the range of `f64`.
const SAFE_EXPONENT: i32 = 60;

impl Units {
    /// The units to work in, or `None` if the given ones will do.
    pub fn choose(start: &AxisState, target: &AxisState, l: &AxisLimits) -> Option<Self> {
        let states = [start.p, start.v, start.a, target.p, target.v, target.a];
        let limits = [l.v.0, l.v.1, l.a.0, l.a.1, l.j.0, l.j.1];
        let fits = |x: &f64| *x == 0.0 || exponent(*x).abs() <= SAFE_EXPONENT;
        if limits.iter().chain(&states).all(fits) {
            return None;
        }
        let a = exponent(l.a.1.max(-l.a.0));
        let j = exponent(l.j.1.max(-l.j.0));
        let time = a - j;
        Some(Self { length: a + 2 * time, time })
    }

    /// A quantity in units of `length / time^n`, into these units.
    pub fn into(self, x: f64, n: i32) -> f64 {
        times_power(x, n * self.time - self.length)
    }

    /// Back from these units.
    pub fn back(self, x: f64, n: i32) -> f64 {
        times_power(x, self.length - n * self.time)
    }

    /// A duration into these units.
    pub fn time_into(self, x: f64) -> f64 {
        times_power(x, -self.time)
    }

    /// A duration back from these units.
    pub fn time_back(self, x: f64) -> f64 {
        times_power(x, self.time)
    }

    pub fn state_into(self, s: &AxisState) -> AxisState {
        AxisState { p: self.into(s.p, 0), v: self.into(s.v, 1), a: self.into(s.a, 2) }
    }

    pub fn limits_into(self, l: &AxisLimits) -> AxisLimits {
        let pair = |x: (f64, f64), n| (self.into(x.0, n), self.into(x.1, n));
        AxisLimits { v: pair(l.v, 1), a: pair(l.a, 2), j: pair(l.j, 3) }
    }
}

/// Exponent of a finite number other than 0, as of `frexp` up to a constant.
fn exponent(x: f64) -> i32 {
    let raw = |x: f64| ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    match raw(x) {
        -1023 => raw(x * (1u64 << 60) as f64) - 60,
        e => e,
    }
}

/// `x * 2^e`, in steps that do not leave the range before the result does.
fn times_power(mut x: f64, mut e: i32) -> f64 {
    while e != 0 && x != 0.0 && x.is_finite() {
        let step = e.clamp(-900, 900);
        x *= f64::from_bits(((1023 + step) as u64) << 52);
        e -= step;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_and_exponents() {
        assert_eq!(exponent(1.0), 0);
        assert_eq!(exponent(-0.75), -1);
        assert_eq!(exponent(5e-324), -1074);
        assert_eq!(times_power(1.5, 2000), f64::INFINITY);
        assert_eq!(times_power(5e-324, 2000), 2f64.powi(926));
        assert_eq!(times_power(3.0, -1), 1.5);
    }
}
