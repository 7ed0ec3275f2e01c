//! States on one line: the motion of all axes as that of one, in proportion.

use arcfeed_feedrate::{AxisLimits, AxisState};

/// How many times the round-off of the numbers themselves a state may be off the line.
const SLACK: f64 = 16.0 * f64::EPSILON;

/// A line through both states: all axes move in proportion to the one that moves farthest.
pub(crate) struct Line<const N: usize> {
    pub reference: usize,
    pub ratios: [f64; N],
}

impl<const N: usize> Line<N> {
    /// The line, or the first axis that is off it.
    pub fn new(start: &[AxisState; N], target: &[AxisState; N]) -> Result<Self, usize> {
        let pairs = || start.iter().zip(target);
        let vectors: [[f64; N]; 5] = [
            from(pairs().map(|(s, t)| t.p - s.p)),
            from(start.iter().map(|s| s.v)),
            from(target.iter().map(|t| t.v)),
            from(start.iter().map(|s| s.a)),
            from(target.iter().map(|t| t.a)),
        ];
        // What the first one is off by round-off: the difference of two positions has that of the positions.
        let blur: [f64; N] = from(pairs().map(|(s, t)| s.p.abs() + t.p.abs()));
        let Some(along) = vectors.iter().position(|w| w.iter().any(|x| *x != 0.0)) else {
            return Ok(Self { reference: 0, ratios: [0.0; N] });
        };
        let direction = &vectors[along];
        let reference = (0..N).fold(0, |m, k| if direction[k].abs() > direction[m].abs() { k } else { m });
        let size = direction[reference];
        let ratios = direction.map(|x| x / size);
        let off = |k: usize| if along == 0 { (blur[k] + blur[reference]) / size.abs() } else { 0.0 };
        for w in &vectors[along + 1..] {
            let largest = w.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            for k in 0..N {
                let slack = SLACK * (largest + w[reference].abs() * off(k));
                let distance = (w[k] - ratios[k] * w[reference]).abs();
                if distance.is_nan() || distance > slack {
                    return Err(k);
                }
            }
        }
        Ok(Self { reference, ratios })
    }

    /// The limits of all axes as limits of the reference axis; `None` if they leave the range of numbers.
    pub fn limits(&self, limits: &[AxisLimits; N]) -> Option<AxisLimits> {
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

fn from<const N: usize>(mut values: impl Iterator<Item = f64>) -> [f64; N] {
    std::array::from_fn(|_| values.next().unwrap_or(0.0))
}
