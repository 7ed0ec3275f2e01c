//! States on one line: the motion of all axes as that of one, in proportion.

use arcfeed_feedrate::{AxisLimits, AxisState};

/// Round-off of a number, relative to the size of the numbers it is computed from.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

/// A line through both states: all axes move in proportion to the one that moves farthest.
pub(crate) struct Line<const N: usize> {
    pub reference: usize,
    pub ratios: [f64; N],
}

/// A vector of both states that must point along the line, and the round-off in each of its
/// components.
struct Part<const N: usize> {
    values: [f64; N],
    round_off: [f64; N],
}

impl<const N: usize> Part<N> {
    fn new(values: impl Fn(usize) -> f64, sizes: impl Fn(usize) -> f64) -> Self {
        let values: [f64; N] = std::array::from_fn(values);
        // A component can be what two large numbers leave: its round-off is that of the limit, not
        // its own.
        let round_off = std::array::from_fn(|k| ROUND_OFF * sizes(k).max(values[k].abs()));
        Self { values, round_off }
    }

    /// Index of the largest component.
    fn largest(&self) -> usize {
        (0..N).fold(0, |m, k| if self.values[k].abs() > self.values[m].abs() { k } else { m })
    }

    /// Length of the vector in units of its round-off.
    fn certainty(&self) -> f64 {
        if N == 0 {
            return 0.0;
        }
        let m = self.largest();
        if self.values[m] == 0.0 { 0.0 } else { self.values[m].abs() / self.round_off[m] }
    }
}

impl<const N: usize> Line<N> {
    /// The line, or the first axis that is off it.
    ///
    /// The direction is that of the vector (displacement, velocities, accelerations) that is the
    /// longest against its own round-off: a displacement of round-off has no direction. Every other
    /// vector must be on that line up to the round-off of its numbers.
    pub fn new(start: &[AxisState; N], target: &[AxisState; N], limits: &[AxisLimits; N]) -> Result<Self, usize> {
        let (s, t) = (start, target);
        let velocity = |k: usize| limits[k].v_max().max(-limits[k].v_min());
        let acceleration = |k: usize| limits[k].a_max().max(-limits[k].a_min());
        let place = s.iter().chain(t).fold(0.0, |m: f64, x| m.max(x.p.abs()));
        let parts: [Part<N>; 5] = [
            Part::new(|k| t[k].p - s[k].p, |_| place),
            Part::new(|k| s[k].v, velocity),
            Part::new(|k| t[k].v, velocity),
            Part::new(|k| s[k].a, acceleration),
            Part::new(|k| t[k].a, acceleration),
        ];
        let best = |m: usize, i: usize| if parts[i].certainty() > parts[m].certainty() { i } else { m };
        let along = &parts[(1..parts.len()).fold(0, best)];
        if along.certainty() == 0.0 {
            // Nothing moves, or a number is none.
            return match (0..N).find(|&k| parts.iter().any(|w| w.values[k] != 0.0)) {
                Some(k) => Err(k),
                None => Ok(Self { reference: 0, ratios: [0.0; N] }),
            };
        }
        let reference = along.largest();
        let ratios = along.values.map(|x| x / along.values[reference]);
        for w in &parts {
            for (k, ratio) in ratios.iter().enumerate() {
                let off = (w.values[k] - ratio * w.values[reference]).abs();
                // Of this component and, in proportion, of the one it is compared with.
                if off.is_nan() || off > 2.0 * w.round_off[k] {
                    return Err(k);
                }
            }
        }
        Ok(Self { reference, ratios })
    }

    /// The limits of all axes as limits of the reference axis; `None` if they leave the range of
    /// numbers.
    pub fn limits(&self, limits: &[AxisLimits; N]) -> Option<AxisLimits> {
        if self.ratios.iter().all(|&r| r == 0.0) {
            // Nothing moves.
            return limits.get(self.reference).copied();
        }
        let mut all = [(f64::NEG_INFINITY, f64::INFINITY); 3];
        for (l, &r) in limits.iter().zip(&self.ratios) {
            if r == 0.0 {
                continue;
            }
            for (out, (lower, upper)) in
                all.iter_mut().zip([(l.v_min(), l.v_max()), (l.a_min(), l.a_max()), (l.j_min(), l.j_max())])
            {
                let (x, y) = (lower / r, upper / r);
                *out = (out.0.max(x.min(y)), out.1.min(x.max(y)));
            }
        }
        AxisLimits::new(all[0], all[1], all[2]).ok()
    }
}
