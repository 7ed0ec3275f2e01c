//! Curves by arc length: s -> u to near machine precision at sampling speed.

mod chebyshev;
mod map;

use nalgebra::SVector;

use self::chebyshev::Chebyshev;
use self::map::{Builder, MOST_STEPS, MapPiece};
use crate::curve::{Curve, Jet};
use crate::error::GeometryError;
use crate::nurbs::NurbsCurve;
use crate::quadrature::check_tolerance;

/// Entries of the table that finds the piece of an arc length, per piece.
const BUCKETS_PER_PIECE: usize = 8;
/// A knot span is halved at most this often before the curve is said to stand still.
const MAX_HALVINGS: u32 = 36;

/// A NURBS curve by arc length.
///
/// Holds a map `s -> u` in Chebyshev-fitted polynomial pieces, built once to a tolerance; looking a point up takes one
/// polynomial and one curve evaluation, without iteration or allocation, and derivatives come by arc length: `d1` is the
/// unit tangent, `d2` the curvature vector. This replaces the Taylor steps of Liu et al. 2023, eqs. 33-38, which
/// accumulate error, and solves their eq. 39 (corrected: `(S(u) - s)^2`) in advance.
///
/// ```
/// use arcfeed_geometry::{ArcLengthCurve, NurbsCurve, nalgebra::vector};
///
/// let curve = NurbsCurve::bspline(
///     2,
///     vec![vector![0.0, 0.0], vector![1.0, 2.0], vector![3.0, 0.0]],
///     vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
/// )?;
/// let path = ArcLengthCurve::new(curve, 1e-12)?;
/// let middle = path.jet(0.5 * path.length());
/// assert!((middle.d1.norm() - 1.0).abs() < 1e-12);
/// # Ok::<(), arcfeed_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone)]
pub struct ArcLengthCurve<const D: usize> {
    curve: NurbsCurve<D>,
    pieces: Vec<MapPiece>,
    /// The curve's own parameter at the end of each piece.
    ends: Vec<f64>,
    buckets: Vec<u32>,
    bucket_scale: f64,
    length: f64,
}

/// A place where the direction of the path jumps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Arc length of the place.
    pub s: f64,
    /// Angle between the tangents before and after, rad.
    pub angle: f64,
}

impl<const D: usize> ArcLengthCurve<D> {
    /// Prepares `curve` for evaluation by arc length, with positions good to `tolerance` (in the curve's unit).
    ///
    /// Below about 1e-15 of the curve's size the tolerance is without effect: double precision ends there.
    ///
    /// # Errors
    /// Fails when the tolerance is not above 0, the curve has no length, or it stands still somewhere (cusp, coincident
    /// control points), so that no derivative by arc length exists there.
    pub fn new(curve: NurbsCurve<D>, tolerance: f64) -> Result<Self, GeometryError> {
        check_tolerance(tolerance)?;
        let size = curve.control_points().iter().fold(0.0f64, |m, p| m.max(p.norm()));
        // A first, rough length: for the floor of the tolerance, for messages, and to find curves without any.
        let rough = curve.arc_length(tolerance.max(1e-9 * size).max(f64::MIN_POSITIVE))?;
        if rough <= 1e-14 * size || rough == 0.0 {
            return Err(GeometryError::ZeroLength { length: rough });
        }
        let tolerance = tolerance.max(2.0 * f64::EPSILON * (size + rough));
        let mut builder = Builder {
            curve: &curve,
            tolerance,
            rough,
            pieces: Vec::new(),
            length: 0.0,
            lost: 0.0,
            speed_nodes: Chebyshev::new(),
            map_nodes: Chebyshev::new(),
        };
        for piece in 0..curve.pieces().frames.len() {
            builder.add(piece, -1.0, 1.0, MAX_HALVINGS)?;
        }
        let (pieces, length) = (builder.pieces, builder.length);

        let own = |m: &MapPiece| curve.pieces().frames[m.piece as usize].parameter(m.local(m.end));
        let ends = pieces.iter().map(own).collect();
        let count = BUCKETS_PER_PIECE * pieces.len();
        let bucket_scale = count as f64 / length;
        let mut buckets = Vec::with_capacity(count);
        let mut i = 0;
        for b in 0..count {
            // Half a bucket early: rounding must never start the search behind the place.
            let s = (b as f64 - 0.5) / bucket_scale;
            while i + 1 < pieces.len() && pieces[i].end <= s {
                i += 1;
            }
            buckets.push(i as u32);
        }
        Ok(Self { curve, pieces, ends, buckets, bucket_scale, length })
    }

    /// Length of the curve.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The curve itself, by its own parameter.
    pub fn curve(&self) -> &NurbsCurve<D> {
        &self.curve
    }

    /// Number of polynomial pieces of the map `s -> u`.
    pub fn map_pieces(&self) -> usize {
        self.pieces.len()
    }

    /// Arc lengths at which the pieces of the map end, the last at the length.
    ///
    /// A piece is as long as the speed `|C'|` is smooth, so that the ends crowd around sharp bends: between two of them
    /// no bend hides.
    pub fn map_ends(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.pieces.iter().map(|piece| piece.end)
    }

    #[inline]
    fn find(&self, s: f64) -> usize {
        let b = (s * self.bucket_scale) as usize;
        let mut i = self.buckets[b.min(self.buckets.len() - 1)] as usize;
        while i + 1 < self.pieces.len() && s >= self.pieces[i].end {
            i += 1;
        }
        i
    }

    /// The curve's own parameter at the arc length `s` (taken to the nearest end outside `[0, length]`).
    pub fn parameter(&self, s: f64) -> f64 {
        // The ends exactly; the rest of the computation rounds.
        if s >= self.length {
            return self.curve.domain().1;
        } else if s.is_nan() || s <= 0.0 {
            return self.curve.domain().0;
        }
        let m = &self.pieces[self.find(s)];
        self.curve.pieces().frames[m.piece as usize].parameter(m.local(s))
    }

    /// Arc length from the start to the curve's own parameter `u`: the inverse of [`ArcLengthCurve::parameter`].
    pub fn arc_length_at(&self, u: f64) -> f64 {
        let (a, b) = self.curve.domain();
        // The ends exactly; the rest of the computation rounds.
        if u >= b {
            return self.length;
        } else if u.is_nan() || u <= a {
            return 0.0;
        }
        let i = self.ends.partition_point(|&end| end < u).min(self.pieces.len() - 1);
        let m = &self.pieces[i];
        let t = self.curve.pieces().local(m.piece as usize, u);
        // t(s) increases on the piece and is nearly straight: Newton's method, kept on the piece, needs a few steps.
        let mut s = m.middle;
        for _ in 0..MOST_STEPS {
            let (at, slope) = m.local_and_slope(s);
            let next = (s - (at - t) / slope).max(m.start).min(m.end);
            let step = (next - s).abs();
            s = next;
            if step <= 4.0 * f64::EPSILON * self.length {
                break;
            }
        }
        s
    }

    /// Position and derivatives by arc length; `s` outside `[0, length]` is taken to the nearest end. Where
    /// derivatives jump (at knots), those from the right.
    #[inline]
    pub fn jet(&self, s: f64) -> Jet<D> {
        let m = &self.pieces[self.find(s)];
        self.with_end(s, self.curve.pieces().jet_by_arc_length(m.piece as usize, m.local(s)))
    }

    /// Like [`ArcLengthCurve::jet`], with the derivatives from the left where they jump.
    pub fn jet_left(&self, s: f64) -> Jet<D> {
        let mut i = self.find(s);
        if i > 0 && s <= self.pieces[i].start {
            i -= 1;
        }
        let m = &self.pieces[i];
        self.with_end(s, self.curve.pieces().jet_by_arc_length(m.piece as usize, m.local(s)))
    }

    /// The jet with the exact point at the ends.
    #[inline(always)]
    fn with_end(&self, s: f64, jet: Jet<D>) -> Jet<D> {
        match self.curve.end(s, (0.0, self.length)) {
            Some(&point) => Jet { point, ..jet },
            None => jet,
        }
    }

    /// Position at the arc length `s`.
    #[inline]
    pub fn point(&self, s: f64) -> SVector<f64, D> {
        if let Some(&end) = self.curve.end(s, (0.0, self.length)) {
            return end;
        }
        let m = &self.pieces[self.find(s)];
        self.curve.pieces().point(m.piece as usize, m.local(s))
    }

    /// Arc lengths of the curve's distinct knots, from 0 to the length: where higher derivatives may jump.
    pub fn knots(&self) -> Vec<f64> {
        let mut out = vec![0.0];
        for pair in self.pieces.windows(2) {
            let frames = &self.curve.pieces().frames;
            let (a, b) = (pair[0].piece as usize, pair[1].piece as usize);
            // The knots are sorted, and pieces start at them exactly.
            if a != b && self.curve.knots().as_slice().binary_search_by(|k| k.total_cmp(&frames[b].start)).is_ok() {
                out.push(pair[1].start);
            }
        }
        out.push(self.length);
        out
    }

    /// Places inside the path where its direction turns by more than `angle` (rad) at once.
    pub fn corners(&self, angle: f64) -> Vec<Corner> {
        let knots = self.knots();
        knots[1..knots.len() - 1]
            .iter()
            .filter_map(|&s| {
                let (before, after) = (self.jet_left(s).d1, self.jet(s).d1);
                // atan2 of the chord of two unit vectors keeps its accuracy for small angles, unlike acos.
                let turn = 2.0 * ((after - before).norm()).atan2((after + before).norm());
                (turn > angle).then_some(Corner { s, angle: turn })
            })
            .collect()
    }
}
