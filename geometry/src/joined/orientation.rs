//! Orientation of the tool along a path of many pieces.

use nalgebra::{UnitQuaternion, Vector3};

use super::path::{JoinedPath, PathPiece, PieceKind};
use crate::arc_length::ArcLengthCurve;
use crate::chord::check_positive;
use crate::curve::Curve;
use crate::error::GeometryError;
use crate::orientation::{OrientationPath, Stretch, Through, shorter_way};

/// Largest deviation of a blend of rates, as a part of the jump of the rate times half the length of the blend.
const BLEND_DEVIATION: f64 = 3.0 / 16.0;
/// Rates that differ by this part are the same but for rounding.
const SAME_RATE: f64 = 1e-9;
/// Keys closer together than this part of the path count as one.
const SAME_PLACE: f64 = 1e-12;

/// An orientation at an arc length, and the constant rate (in the axes of the tool) from there to the next one.
#[derive(Debug, Clone, Copy)]
struct Key {
    s: f64,
    rotation: UnitQuaternion<f64>,
    rate: Vector3<f64>,
}

impl JoinedPath {
    /// The orientation of the tool along the path, from the orientations between the programmed pieces.
    ///
    /// `keys` are the orientation at the start and one at the end of each piece that was appended to the builder;
    /// `curve` is [`JoinedPath::to_curve`] of this path by arc length. Along each programmed piece the orientation
    /// goes from key to key on the shorter way, in step with the arc length (slerp). On a blend that replaces a
    /// joint, the key stands in its middle and each half runs through the length that was taken on its side.
    ///
    /// Where the rate jumps, it is blended over so short a stretch that the orientation stays within `tolerance`
    /// (rad) of that, by half of either neighbour at most, and then the angular acceleration is continuous. The
    /// bound is certain: the deviation in the chart about the key is `3/16` of the jump times half the stretch, and
    /// angles between orientations are not larger than distances in the chart. Where all keys are equal the
    /// orientation is constant.
    ///
    /// # Errors
    /// Fails when the number of keys does not fit, a quaternion is not finite, the tolerance is not above 0, or the
    /// curve is that of another path.
    pub fn orientation(
        &self,
        curve: &ArcLengthCurve<3>,
        keys: &[UnitQuaternion<f64>],
        tolerance: f64,
    ) -> Result<OrientationPath, GeometryError> {
        check_positive("angular tolerance", tolerance)?;
        if keys.len() != self.calls.len() {
            return Err(GeometryError::OrientationCount { keys: keys.len(), pieces: self.calls.len() - 1 });
        }
        for (index, key) in keys.iter().enumerate() {
            if let Some(&value) = key.coords.iter().find(|x| !x.is_finite()) {
                return Err(GeometryError::QuaternionNotFinite { index, value });
            }
        }
        if curve.curve().domain() != self.domain() {
            let ((start, end), (_, expected)) = (curve.curve().domain(), self.domain());
            return Err(GeometryError::OtherCurve { start, end, expected });
        }
        if keys.iter().all(|key| key == &keys[0]) {
            return Ok(OrientationPath::Constant(keys[0]));
        }
        Ok(OrientationPath::Through(blended_rates(&self.slerps(curve, keys), tolerance)))
    }

    /// The places where the rate may jump, with the rates between them.
    fn slerps(&self, curve: &ArcLengthCurve<3>, keys: &[UnitQuaternion<f64>]) -> Vec<Key> {
        let mut places = vec![(0.0, 0.0)];
        let mut add = |s: f64, programmed: f64| {
            if s - places[places.len() - 1].0 > SAME_PLACE * curve.length() {
                places.push((s, programmed));
            }
        };
        for PathPiece { kind, start, end, programmed, .. } in &self.pieces {
            if *kind == PieceKind::Blend {
                add(curve.arc_length_at(0.5 * (start + end)), programmed[1]);
            }
            add(curve.arc_length_at(*end), programmed[2]);
        }
        let calls = &self.calls;
        let ways: Vec<Vector3<f64>> = keys.windows(2).map(|k| shorter_way(&k[0], &k[1])).collect();
        let call_at = |programmed: f64| calls[1..calls.len() - 1].partition_point(|&end| end <= programmed);
        let part = |call: usize, at: f64| (at - calls[call]) / (calls[call + 1] - calls[call]);
        let mut out = Vec::with_capacity(places.len());
        for (i, &(s, programmed)) in places.iter().enumerate() {
            // Between two places the programmed piece is one, found from its middle.
            let (s1, programmed1) = places[(i + 1).min(places.len() - 1)];
            let (s0, programmed0) = places[(i + 1).min(places.len() - 1) - 1];
            let call = call_at(0.5 * (programmed0 + programmed1));
            let rate = ways[call] * ((part(call, programmed1) - part(call, programmed0)) / (s1 - s0));
            let rotation = keys[call] * UnitQuaternion::from_scaled_axis(ways[call] * part(call, programmed));
            out.push(Key { s, rotation, rate });
        }
        out
    }
}

/// Constant rates from key to key, with a blend about each key between them.
///
/// About the key both slerps are straight in the rotation vector `phi` of `key * exp(phi)`: `a y` before it and `b
/// y` after it. The blend over `-h < y < h` is `(a + b) y / 2 + (b - a) h (3/16 + 3/8 (y/h)^2 - 1/16 (y/h)^4)`,
/// which has the value, the slope and the vanishing second derivative of both at its ends.
fn blended_rates(keys: &[Key], tolerance: f64) -> Through {
    let last = keys.len() - 1;
    let half = |i: usize| {
        if i == 0 || i == last {
            return 0.0;
        }
        let (before, after) = (keys[i - 1].rate, keys[i].rate);
        let jump = (after - before).norm();
        if jump <= SAME_RATE * before.norm().max(after.norm()) {
            return 0.0;
        }
        let most = 0.5 * (keys[i].s - keys[i - 1].s).min(keys[i + 1].s - keys[i].s);
        most.min(tolerance / (BLEND_DEVIATION * jump))
    };
    let (mut s, mut stretches) = (vec![keys[0].s], Vec::with_capacity(2 * keys.len()));
    let zero = Vector3::zeros();
    for i in 0..last {
        let (key, next) = (&keys[i], &keys[i + 1]);
        let (from, to) = (s[s.len() - 1], next.s - half(i + 1));
        if to > from {
            stretches.push(Stretch {
                key: key.rotation,
                first: key.rate * (from - key.s),
                c: [key.rate, zero, zero, zero, zero],
            });
            s.push(to);
        }
        let h = half(i + 1);
        if h > 0.0 {
            let (rate, jump) = (key.rate, next.rate - key.rate);
            let c = [rate, zero, jump / (4.0 * h * h), jump / (-16.0 * h * h * h), zero];
            stretches.push(Stretch { key: next.rotation, first: rate * -h, c });
            s.push(next.s + h);
        }
    }
    Through::from_stretches(s, stretches)
}
