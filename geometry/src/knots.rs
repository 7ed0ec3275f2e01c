//! Knot vectors: validation, multiplicities, spans.

use crate::error::GeometryError;

/// Binomial coefficients of twice this degree are finite.
const HIGHEST_DEGREE: usize = 500;
/// Knots within this part of the domain count as one, where the curve stays in one piece.
const MERGED: f64 = 1e-9;
/// Narrowest span inside the domain, as a part of its width.
pub(crate) const NARROWEST: f64 = 1e-12;
/// Both are no less than this many units in the last place of the larger end of the domain.
const ULPS: f64 = 4.0;

/// A degree that curves can have.
pub(crate) fn check_degree(degree: usize) -> Result<(), GeometryError> {
    match degree {
        0 => Err(GeometryError::DegreeZero),
        1..=HIGHEST_DEGREE => Ok(()),
        _ => Err(GeometryError::DegreeTooHigh { degree, limit: HIGHEST_DEGREE }),
    }
}

/// A validated, non-decreasing knot vector for curves of one degree.
///
/// The domain is `[knots[degree], knots[points]]`; clamped vectors (first and last knot repeated degree + 1 times) and
/// unclamped ones are both allowed. Spans are half-open, so that every parameter belongs to exactly one (Liu et al.
/// 2023, eq. 2, corrected: printed with both ends closed); the last one includes the end of the domain.
///
/// Knots within 1e-9 of the domain (or four units in the last place) count as one: they get the value of the first of
/// them, or that of the end of the domain they belong to. This moves the curve by about 1e-9 of its size. Knots keep
/// their values where merging would leave more than `degree` of them (`degree + 1` at an end of the vector), because the
/// curve would jump there. The spans between those are at least 1e-12 of the domain wide.
#[derive(Debug, Clone, PartialEq)]
pub struct KnotVector {
    knots: Vec<f64>,
    degree: usize,
}

impl KnotVector {
    /// Checks and wraps `knots` for curves of `degree`.
    ///
    /// # Errors
    /// Fails when the degree is 0, a knot is not finite, the knots decrease, a knot stands more than degree + 1 times, there
    /// are too few for one span, the domain is empty, or a span is too narrow for double precision.
    pub fn new(degree: usize, knots: Vec<f64>) -> Result<Self, GeometryError> {
        check_degree(degree)?;
        if knots.len() < 2 * (degree + 1) {
            return Err(GeometryError::TooFewPoints { points: knots.len().saturating_sub(degree + 1), degree });
        }
        if let Some((index, &value)) = knots.iter().enumerate().find(|(_, k)| !k.is_finite()) {
            return Err(GeometryError::KnotNotFinite { index, value });
        }
        for (i, pair) in knots.windows(2).enumerate() {
            if pair[1] < pair[0] {
                return Err(GeometryError::KnotsDecrease { index: i + 1, value: pair[1], previous: pair[0] });
            }
        }
        let mut this = Self { knots, degree };
        let (start, end) = this.domain();
        if end > start && (end - start).is_finite() {
            this.merge_close();
        }
        for (index, value, multiplicity) in this.runs() {
            if multiplicity > degree + 1 {
                return Err(GeometryError::Multiplicity { index, value, multiplicity, degree });
            }
        }
        // The second condition refuses a domain so wide that its length overflows.
        if start >= end || !(end - start).is_finite() {
            return Err(GeometryError::EmptyDomain { start, end });
        }
        let least = this.resolution(NARROWEST);
        if let Some(index) = this.spans().find(|&k| this.knots[k + 1] - this.knots[k] < least) {
            let (value, width) = (this.knots[index], this.knots[index + 1] - this.knots[index]);
            return Err(GeometryError::KnotsTooClose { index, value, width, least });
        }
        Ok(this)
    }

    /// The part `share` of the width of the domain, or a few units in the last place of its ends.
    fn resolution(&self, share: f64) -> f64 {
        let (start, end) = self.domain();
        // A domain so narrow that it has no such part is resolved as well as it can be.
        (share * (end - start)).max(ULPS * f64::EPSILON * start.abs().max(end.abs())).min(0.25 * (end - start))
    }

    /// Gives knots that count as one the same value.
    fn merge_close(&mut self) {
        let (p, n) = (self.degree, self.point_count());
        let (start, end) = self.domain();
        let close = self.resolution(MERGED);
        let mut first = 0;
        while first < self.knots.len() {
            let value = self.knots[first];
            let behind = first + self.knots[first..].partition_point(|&k| k - value <= close);
            let at_end = first == 0 || behind == self.knots.len();
            if behind - first <= p + usize::from(at_end) {
                let holds = |index: usize| (first..behind).contains(&index);
                let value = match (holds(p), holds(n)) {
                    (true, _) => start,
                    (_, true) => end,
                    _ => value,
                };
                self.knots[first..behind].fill(value);
            }
            first = behind;
        }
    }

    /// The knot that `u` counts as, or `u` itself where there is none.
    pub(crate) fn snapped(&self, u: f64) -> f64 {
        let close = self.resolution(MERGED);
        let after = self.knots.partition_point(|&k| k < u);
        let around = [self.knots.get(after), after.checked_sub(1).and_then(|i| self.knots.get(i))];
        let near = around.into_iter().flatten().copied().filter(|k| (k - u).abs() <= close);
        near.min_by(|a, b| (a - u).abs().total_cmp(&(b - u).abs())).unwrap_or(u)
    }

    /// A clamped vector with equally spaced interior knots on [0, 1].
    ///
    /// # Errors
    /// Fails when the degree is 0 or there are fewer than degree + 1 points.
    pub fn clamped_uniform(degree: usize, points: usize) -> Result<Self, GeometryError> {
        check_degree(degree)?;
        if points < degree + 1 {
            return Err(GeometryError::TooFewPoints { points, degree });
        }
        let spans = points - degree;
        let mut knots = vec![0.0; degree + 1];
        knots.extend((1..spans).map(|i| i as f64 / spans as f64));
        knots.extend(std::iter::repeat_n(1.0, degree + 1));
        Self::new(degree, knots)
    }

    /// Degree of the curves on these knots.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// All knots.
    pub fn as_slice(&self) -> &[f64] {
        &self.knots
    }

    /// Number of control points that go with these knots.
    pub fn point_count(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// First and last parameter.
    pub fn domain(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.point_count()])
    }

    /// Index `k` of the half-open span `[knots[k], knots[k + 1])` that holds `u`; parameters outside the domain are
    /// taken to its nearest end.
    pub fn span(&self, u: f64) -> usize {
        let (start, end) = self.domain();
        let u = u.max(start).min(end);
        let inner = &self.knots[self.degree..=self.point_count()];
        // Number of knots <= u, but never past the last non-empty span.
        let above = inner.partition_point(|&k| k <= u);
        let mut k = self.degree + above.max(1) - 1;
        if k >= self.point_count() {
            k = self.point_count() - 1;
            while self.knots[k] == self.knots[k + 1] {
                k -= 1;
            }
        }
        k
    }

    /// Indices `k` of the non-empty spans of the domain, in order.
    pub fn spans(&self) -> impl Iterator<Item = usize> + '_ {
        (self.degree..self.point_count()).filter(|&k| self.knots[k] < self.knots[k + 1])
    }

    /// The number of times the value `u` stands in the vector (exact comparison).
    pub fn multiplicity(&self, u: f64) -> usize {
        self.knots.iter().filter(|&&k| k == u).count()
    }

    /// Runs of equal knots: index of the first, value, multiplicity.
    pub fn runs(&self) -> impl Iterator<Item = (usize, f64, usize)> + '_ {
        let mut i = 0;
        std::iter::from_fn(move || {
            let value = *self.knots.get(i)?;
            let n = self.knots[i..].iter().take_while(|&&k| k == value).count();
            let first = i;
            i += n;
            Some((first, value, n))
        })
    }

    /// True where the first and the last knot stand degree + 1 times, so that the curve starts and ends in its first
    /// and last control point.
    pub fn is_clamped(&self) -> bool {
        let (start, end) = self.domain();
        self.knots[0] == start && self.knots[self.knots.len() - 1] == end
    }
}
