//! The distance of a piece of a curve from its chord.

use nalgebra::SVector;

use crate::bezier::{Homogeneous, RationalBezier, keep_left, keep_right, lerp};
use crate::error::GeometryError;

/// Splits of one piece after which its bound is accepted as it stands.
///
/// The gap between bound and curve falls by 4 with every halving, so rounding is reached long before.
const DEEPEST: u32 = 48;

/// The largest distance between a piece of a curve and its chord, enclosed from both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// A distance that a point of the curve does reach, in the curve's unit.
    pub lower: f64,
    /// A distance that no point of the curve exceeds, an allowance for rounding included, in the curve's unit.
    pub upper: f64,
    /// Parameter of the curve where `lower` is reached.
    pub at: f64,
}

/// Measures deviations from chords; holds the working memory, so that repeated measurements do not allocate.
///
/// The chord is the straight *segment* between the two ends of a piece, not the infinite line, so that loops, reversals
/// and closed pieces (a chord without length) are measured as they should be.
///
/// The distance to a segment is a convex function, hence on a rational Bezier piece with positive weights it is nowhere
/// above its largest value at the control points. The piece is split where the derivative of the distance vanishes
/// (Newton's method; the extreme point of Liu et al. 2023, section 2.2), where both halves of a plane piece without
/// inflection have control points no farther away than the extreme point itself; whatever does not obey at once is
/// split further until upper and lower bound meet.
///
/// ```
/// use arcfeed_geometry::{ChordMeter, NurbsCurve, nalgebra::vector};
///
/// // The parabola (t, 2 t (1 - t)) rises 0.5 above its chord.
/// let points = vec![vector![0.0, 0.0], vector![0.5, 1.0], vector![1.0, 0.0]];
/// let curve = NurbsCurve::bspline(2, points, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0])?;
/// let mut meter = ChordMeter::new();
/// let deviation = meter.measure(&curve.decompose()[0], 1e-9)?;
/// assert!(deviation.lower <= 0.5 && 0.5 <= deviation.upper);
/// assert!(deviation.upper - deviation.lower < 1e-9);
/// # Ok::<(), arcfeed_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct ChordMeter {
    /// Control points of the parts still to be looked at, one part after the other, relative to the chord's start.
    points: Vec<Homogeneous>,
    parts: Vec<Part>,
    order: usize,
    start: [f64; 3],
    /// Unit vector along the chord; zero for a chord without length.
    direction: [f64; 3],
    length: f64,
    rounding: f64,
    lower2: f64,
    at: f64,
}

#[derive(Debug, Clone, Copy)]
struct Part {
    u0: f64,
    u1: f64,
    /// Squared distance of the farthest control point.
    upper2: f64,
    /// Its index.
    farthest: usize,
    depth: u32,
}

/// The condition under which a measurement may stop.
#[derive(Debug, Clone, Copy)]
struct Goal {
    /// Relative gap between the bounds.
    precision: f64,
    /// Parts whose bound is no larger than this need no closer look.
    floor: f64,
    /// Stop as soon as a point of the curve is farther away than this.
    ceiling: f64,
}

impl ChordMeter {
    /// A meter without memory yet; it grows with the first measurements.
    pub fn new() -> Self {
        Self::default()
    }

    /// Largest distance of `piece` from its chord, to the relative `precision` (or to rounding, if that is coarser).
    ///
    /// # Errors
    /// Fails when `precision` is not a finite number above 0.
    pub fn measure<const D: usize>(
        &mut self,
        piece: &RationalBezier<D>,
        precision: f64,
    ) -> Result<Deviation, GeometryError> {
        check_positive("precision", precision)?;
        self.load_piece(piece);
        Ok(self.measure_loaded(precision))
    }

    /// True where `piece` leaves its chord by more than `tolerance`, or so nearly that rounding hides the difference.
    ///
    /// # Errors
    /// Fails when `tolerance` is not a finite number above 0.
    pub fn exceeds<const D: usize>(
        &mut self,
        piece: &RationalBezier<D>,
        tolerance: f64,
    ) -> Result<bool, GeometryError> {
        check_positive("tolerance", tolerance)?;
        self.load_piece(piece);
        let floor = tolerance - self.rounding;
        Ok(self.run(Goal { precision: 0.0, floor, ceiling: tolerance }).upper > tolerance)
    }

    fn load_piece<const D: usize>(&mut self, piece: &RationalBezier<D>) {
        let h = piece.homogeneous();
        let size = h.iter().map(size_of).fold(0.0, f64::max);
        self.begin(&cartesian(&h[0]), &cartesian(&h[h.len() - 1]), size, h.len());
        let (u0, u1) = piece.interval();
        self.add(h, (u0, u1), (0.0, 1.0));
    }

    /// Starts a measurement against the chord from `a` to `b`, of pieces with `order` control points each, on a curve
    /// whose coordinates have magnitude `size` at most.
    pub(crate) fn begin(&mut self, a: &[f64; 3], b: &[f64; 3], size: f64, order: usize) {
        self.points.clear();
        self.parts.clear();
        self.order = order;
        self.start = *a;
        let v = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        self.length = dot(&v, &v).sqrt();
        let il = if self.length > 0.0 { 1.0 / self.length } else { 0.0 };
        self.direction = [v[0] * il, v[1] * il, v[2] * il];
        self.rounding = 4.0 * f64::EPSILON * size;
        self.lower2 = 0.0;
    }

    /// Adds the part between the local parameters `t0 < t1` of Bezier control points; it runs over `[u0, u1]` of the
    /// curve.
    #[inline]
    pub(crate) fn add(&mut self, h: &[Homogeneous], (u0, u1): (f64, f64), (t0, t1): (f64, f64)) {
        let first = self.points.len();
        let a = self.start;
        self.points.extend(h.iter().map(|h| [h[0] - h[3] * a[0], h[1] - h[3] * a[1], h[2] - h[3] * a[2], h[3]]));
        // As in `run`: the loops unroll for cubics.
        let part = &mut self.points[first..];
        if part.len() == 4 {
            cut_out(&mut part[..4], t0, t1)
        } else {
            cut_out(part, t0, t1)
        }
        let n = self.order;
        let (d0, d1) = (self.distance2(&self.points[first]), self.distance2(&self.points[first + n - 1]));
        if self.parts.is_empty() {
            self.at = u0;
        }
        self.raise(d0, u0);
        self.raise(d1, u1);
        let (upper2, farthest) = self.bound2(&self.points[first..]);
        self.parts.push(Part { u0, u1, upper2, farthest, depth: 0 });
    }

    /// Deviation of what has been added, to a relative precision.
    #[inline]
    pub(crate) fn measure_loaded(&mut self, precision: f64) -> Deviation {
        self.run(Goal { precision, floor: 0.0, ceiling: f64::INFINITY })
    }

    /// Largest distance of the control points added, the hull bound of Actuators 2024, 13, 108, section 2.
    #[inline]
    pub(crate) fn hull_loaded(&self) -> f64 {
        self.parts.iter().fold(0.0f64, |m, p| m.max(p.upper2)).sqrt() + self.rounding
    }

    fn run(&mut self, goal: Goal) -> Deviation {
        // The same code twice: with the number of control points known, the loops of the cubic case unroll.
        match self.order {
            4 => self.run_order(goal, 4),
            n => self.run_order(goal, n),
        }
    }

    #[inline(always)]
    fn run_order(&mut self, goal: Goal, n: usize) -> Deviation {
        let mut done2 = 0.0f64;
        let mut enough2 = self.enough2(goal);
        let ceiling2 = goal.ceiling * goal.ceiling;
        while let Some(part) = self.parts.pop() {
            let base = self.parts.len() * n;
            if part.upper2 <= enough2 || part.depth == DEEPEST {
                done2 = done2.max(part.upper2);
                self.points.truncate(base);
                continue;
            }
            let t = self.peak(base, n, part.farthest as f64 / (n - 1) as f64).unwrap_or(0.5);
            split(&mut self.points, base, n, t);
            let u = part.u0 + t * (part.u1 - part.u0);
            self.raise(self.distance2(&self.points[base + n]), u);
            if self.lower2 > ceiling2 {
                return Deviation { lower: self.lower2.sqrt(), upper: f64::INFINITY, at: self.at };
            }
            enough2 = self.enough2(goal);
            let depth = part.depth + 1;
            let (left2, left_far) = self.bound2(&self.points[base..base + n]);
            let (right2, right_far) = self.bound2(&self.points[base + n..base + 2 * n]);
            let left = Part { u0: part.u0, u1: u, upper2: left2, farthest: left_far, depth };
            let right = Part { u0: u, u1: part.u1, upper2: right2, farthest: right_far, depth };
            // The more promising part comes last, to be looked at first.
            if left2 > right2 {
                let (l, r) = self.points[base..base + 2 * n].split_at_mut(n);
                l.swap_with_slice(r);
                self.parts.extend([right, left]);
            } else {
                self.parts.extend([left, right]);
            }
        }
        let upper2 = done2.max(self.lower2);
        Deviation { lower: self.lower2.sqrt(), upper: upper2.sqrt() + self.rounding, at: self.at }
    }

    #[inline]
    fn enough2(&self, goal: Goal) -> f64 {
        let e = (self.lower2.sqrt() * (1.0 + goal.precision) + self.rounding).max(goal.floor);
        e * e
    }

    #[inline]
    fn raise(&mut self, distance2: f64, u: f64) {
        if distance2 > self.lower2 {
            self.lower2 = distance2;
            self.at = u;
        }
    }

    /// Squared distance of a point from the chord.
    #[inline(always)]
    fn distance2(&self, h: &Homogeneous) -> f64 {
        let iw = 1.0 / h[3];
        let v = [h[0] * iw, h[1] * iw, h[2] * iw];
        let s = dot(&v, &self.direction).max(0.0).min(self.length);
        let d = &self.direction;
        let q = [v[0] - s * d[0], v[1] - s * d[1], v[2] - s * d[2]];
        dot(&q, &q)
    }

    /// Largest squared distance of the inner control points, and whose it is. (The end points lie on the curve: they
    /// are counted in the lower bound.)
    #[inline(always)]
    fn bound2(&self, h: &[Homogeneous]) -> (f64, usize) {
        let mut best = (0.0, 0);
        let inner = &h[1..h.len() - 1];
        for (i, p) in inner.iter().enumerate() {
            let d = self.distance2(p);
            if d > best.0 {
                best = (d, i + 1);
            }
        }
        best
    }

    /// Local parameter of the distance's largest value inside the part at `base`, by Newton's method from `t`, if
    /// there is one well inside.
    #[inline(always)]
    fn peak(&self, base: usize, n: usize, t: f64) -> Option<f64> {
        let h = &self.points[base..base + n];
        let mut t = t.max(0.25).min(0.75);
        for _ in 0..6 {
            let (v, v1, v2) = derivatives(h, t)?;
            let s = dot(&v, &self.direction);
            // Beside the chord only what is normal to it counts; past its ends everything.
            let beside = 0.0 < s && s < self.length;
            let anchor = s.max(0.0).min(self.length);
            let normal = |x: &[f64; 3], along: f64| -> [f64; 3] {
                if !beside {
                    return *x;
                }
                let d = &self.direction;
                [x[0] - along * d[0], x[1] - along * d[1], x[2] - along * d[2]]
            };
            let d = &self.direction;
            let q = [v[0] - anchor * d[0], v[1] - anchor * d[1], v[2] - anchor * d[2]];
            let q1 = normal(&v1, dot(&v1, d));
            let q2 = normal(&v2, dot(&v2, d));
            // Newton's step for |q|' = 0, that is -|q|' / |q|'', with both multiplied by |q|.
            let slope = dot(&q, &q1);
            let bend = dot(&q, &q2) + dot(&q1, &q1) - slope * slope / dot(&q, &q);
            if bend >= 0.0 || bend.is_nan() {
                return None;
            }
            let step = -slope / bend;
            t += step;
            if !(0.02..0.98).contains(&t) {
                return None;
            }
            // The error is about the square of the last step.
            if step.abs() < 1e-4 {
                break;
            }
        }
        Some(t)
    }
}

/// Restricts control points to the local parameters `[t0, t1]`.
#[inline(always)]
fn cut_out(h: &mut [Homogeneous], t0: f64, t1: f64) {
    if t1 < 1.0 {
        keep_left(h, t1);
    }
    if t0 > 0.0 {
        keep_right(h, t0 / t1);
    }
}

#[inline(always)]
fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn cartesian(h: &Homogeneous) -> [f64; 3] {
    [h[0] / h[3], h[1] / h[3], h[2] / h[3]]
}

/// The coordinates of a point in three lanes.
#[inline(always)]
pub(crate) fn three<const D: usize>(p: &SVector<f64, D>) -> [f64; 3] {
    [p[0], p[1], if D > 2 { p[2] } else { 0.0 }]
}

/// Largest coordinate of a control point, by magnitude.
#[inline(always)]
pub(crate) fn size_of(h: &Homogeneous) -> f64 {
    h[0].abs().max(h[1].abs()).max(h[2].abs()) / h[3]
}

pub(crate) fn check_positive(what: &'static str, value: f64) -> Result<(), GeometryError> {
    if value.is_finite() && value > 0.0 { Ok(()) } else { Err(GeometryError::NotPositive { what, value }) }
}

/// Splits the control points at `base` at the local parameter `t`: the first part stays there, the second follows.
#[inline(always)]
fn split(points: &mut Vec<Homogeneous>, base: usize, n: usize, t: f64) {
    points.resize(base + 2 * n, [0.0; 4]);
    let (left, right) = points[base..].split_at_mut(n);
    right[n - 1] = left[n - 1];
    for r in 1..n {
        for i in (r..n).rev() {
            left[i] = lerp(&left[i - 1], &left[i], t);
        }
        right[n - 1 - r] = left[n - 1];
    }
}

/// Position and two derivatives by the local parameter, for degree 2 or more.
#[inline(always)]
fn derivatives(h: &[Homogeneous], t: f64) -> Option<([f64; 3], [f64; 3], [f64; 3])> {
    let p = h.len() - 1;
    if p < 2 {
        return None;
    }
    // The last three points of de Casteljau's scheme, as Bernstein sums of degree p - 2, each by Horner's scheme.
    let m = p - 2;
    let s = 1.0 - t;
    let mut b = [h[0], h[1], h[2]];
    let (mut binomial, mut power) = (1.0, 1.0);
    for i in 1..=m {
        binomial *= (m + 1 - i) as f64 / i as f64;
        power *= t;
        let f = binomial * power;
        for (j, sum) in b.iter_mut().enumerate() {
            for l in 0..4 {
                sum[l] = sum[l] * s + f * h[i + j][l];
            }
        }
    }
    let (c0, c1) = (lerp(&b[0], &b[1], t), lerp(&b[1], &b[2], t));
    let x = lerp(&c0, &c1, t);
    let (k1, k2) = (p as f64, (p * (p - 1)) as f64);
    let iw = 1.0 / x[3];
    let w1 = k1 * (c1[3] - c0[3]);
    let w2 = k2 * (b[0][3] - 2.0 * b[1][3] + b[2][3]);
    let (mut v, mut v1, mut v2) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    for l in 0..3 {
        v[l] = x[l] * iw;
        v1[l] = (k1 * (c1[l] - c0[l]) - w1 * v[l]) * iw;
        v2[l] = (k2 * (b[0][l] - 2.0 * b[1][l] + b[2][l]) - 2.0 * w1 * v1[l] - w2 * v[l]) * iw;
    }
    Some((v, v1, v2))
}
