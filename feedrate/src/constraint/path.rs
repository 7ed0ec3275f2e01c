//! The shape of a path as seen by its joints: derivatives by the path parameter on a grid.

use crate::error::FeedError;

/// Derivatives by `s` of one or more axes (joints, or tool coordinates) at every grid point,
/// row-major: entry `i * axes + j` belongs to axis `j` at grid point `i`.
///
/// At a grid point where a derivative jumps, as the third one of a cubic spline does at its knots,
/// the main arrays hold the value just after the point and [`PathDerivatives::with_values_before`]
/// the one just before it. A jump of the *first* derivative is a corner, at which the motion has to
/// stop.
#[derive(Debug, Clone, Copy)]
pub struct PathDerivatives<'a> {
    axes: usize,
    points: usize,
    after: [&'a [f64]; 3],
    before: [&'a [f64]; 3],
    middle: Option<[&'a [f64]; 2]>,
    middle_third: Option<&'a [f64]>,
    bounds: Option<[&'a [f64]; 3]>,
    steps: Option<&'a [f64]>,
}

/// First, second and third derivative of one axis at one place.
pub(super) type Jet = [f64; 3];

impl<'a> PathDerivatives<'a> {
    /// First and second derivatives at every grid point.
    ///
    /// # Errors
    /// [`FeedError::Empty`] without axes, [`FeedError::LengthMismatch`] if the arrays differ in
    /// length or do not hold a whole number of points.
    pub fn new(axes: usize, first: &'a [f64], second: &'a [f64]) -> Result<Self, FeedError> {
        if axes == 0 || first.is_empty() {
            return Err(FeedError::Empty { what: "path derivatives" });
        }
        let points = first.len() / axes;
        let (after, before) = ([first, second, &[] as &[f64]], [first, second, &[] as &[f64]]);
        let path = Self { axes, points, after, before, middle: None, middle_third: None, bounds: None, steps: None };
        path.check("first derivatives", first)?;
        path.check("second derivatives", second)?;
        Ok(path)
    }

    /// Adds third derivatives at every grid point, just after it.
    ///
    /// # Errors
    /// [`FeedError::LengthMismatch`].
    pub fn with_third(mut self, third: &'a [f64]) -> Result<Self, FeedError> {
        self.check("third derivatives", third)?;
        self.after[2] = third;
        self.before[2] = third;
        Ok(self)
    }

    /// Gives the values just before every grid point where they may differ from those after it:
    /// first, second and third derivatives; an empty array means "the same". The entries of the
    /// first grid point are not used.
    ///
    /// # Errors
    /// [`FeedError::LengthMismatch`].
    pub fn with_values_before(
        mut self,
        first: &'a [f64],
        second: &'a [f64],
        third: &'a [f64],
    ) -> Result<Self, FeedError> {
        let names = ["first derivatives before", "second derivatives before", "third derivatives before"];
        for (k, values) in [first, second, third].into_iter().enumerate() {
            if !values.is_empty() {
                self.check(names[k], values)?;
                self.before[k] = values;
            }
        }
        Ok(self)
    }

    /// Gives first and second derivatives in the middle of every interval (one point less than the
    /// grid has). Without them they are interpolated from both ends by Hermite's formula, which is
    /// exact on a cubic path.
    ///
    /// # Errors
    /// [`FeedError::LengthMismatch`].
    pub fn with_middles(mut self, first: &'a [f64], second: &'a [f64]) -> Result<Self, FeedError> {
        for (what, values) in [("first derivatives in the middle", first), ("second derivatives in the middle", second)]
        {
            self.check_intervals(what, values)?;
        }
        self.middle = Some([first, second]);
        Ok(self)
    }

    /// Gives the third derivatives in the middle of every interval; without them the mean of both
    /// ends is taken, which is exact on a quartic path.
    ///
    /// # Errors
    /// [`FeedError::LengthMismatch`].
    pub fn with_third_in_middles(mut self, third: &'a [f64]) -> Result<Self, FeedError> {
        self.check_intervals("third derivatives in the middle", third)?;
        self.middle_third = Some(third);
        Ok(self)
    }

    /// Gives magnitudes that first, second and third derivatives do not exceed on every interval.
    /// Without them those of the cubics through values and slopes at both ends are taken.
    ///
    /// # Errors
    /// [`FeedError::LengthMismatch`].
    pub fn with_bounds(mut self, bounds: [&'a [f64]; 3]) -> Result<Self, FeedError> {
        let names = ["bounds of first derivatives", "bounds of second derivatives", "bounds of third derivatives"];
        for (what, values) in names.into_iter().zip(bounds) {
            self.check_intervals(what, values)?;
        }
        self.bounds = Some(bounds);
        Ok(self)
    }

    /// Gives, for every interval, the magnitude of the jumps of the second derivatives over the time
    /// (s) that a controller spreads a jump over; 0 where none is within that time. With it the path
    /// may be in motion where they jump; without it the motion has to stop there.
    ///
    /// # Errors
    /// [`FeedError::LengthMismatch`].
    pub fn with_steps(mut self, steps: &'a [f64]) -> Result<Self, FeedError> {
        self.check_intervals("steps of the second derivatives", steps)?;
        self.steps = Some(steps);
        Ok(self)
    }

    fn check_intervals(&self, what: &'static str, values: &[f64]) -> Result<(), FeedError> {
        let expected = (self.points - 1) * self.axes;
        if values.len() == expected {
            Ok(())
        } else {
            Err(FeedError::LengthMismatch { what, got: values.len(), expected })
        }
    }

    /// Magnitudes that the three derivatives of axis `j` do not exceed on interval `k` of length
    /// `h`.
    pub(super) fn interval(&self, k: usize, h: f64, j: usize) -> Jet {
        if let Some(bounds) = self.bounds {
            return bounds.map(|values| values[k * self.axes + j]);
        }
        let ([p0, s0, t0], [p1, s1, t1]) = (self.start(k, j), self.end(k + 1, j));
        let (t0, t1) = if self.has_third() { (t0, t1) } else { ((s1 - s0) / h, (s1 - s0) / h) };
        // The Bernstein coefficients of a cubic enclose it.
        let enclose = |f0: f64, g0: f64, f1: f64, g1: f64| {
            f0.abs().max((f0 + h * g0 / 3.0).abs()).max((f1 - h * g1 / 3.0).abs()).max(f1.abs())
        };
        [enclose(p0, s0, p1, s1), enclose(s0, t0, s1, t1), t0.abs().max(t1.abs())]
    }

    /// The step of axis `j` on interval `k`.
    pub(super) fn step(&self, k: usize, j: usize) -> f64 {
        self.steps.map_or(0.0, |steps| steps[k * self.axes + j])
    }

    /// Returns true if jumps of the second derivatives are spread over some time.
    pub(super) fn has_steps(&self) -> bool {
        self.steps.is_some()
    }

    fn check(&self, what: &'static str, values: &[f64]) -> Result<(), FeedError> {
        let expected = self.points * self.axes;
        if values.len() == expected {
            Ok(())
        } else {
            Err(FeedError::LengthMismatch { what, got: values.len(), expected })
        }
    }

    /// Number of axes.
    pub fn axes(&self) -> usize {
        self.axes
    }

    /// Number of grid points.
    pub fn points(&self) -> usize {
        self.points
    }

    /// Returns true if third derivatives are known.
    pub fn has_third(&self) -> bool {
        !self.after[2].is_empty()
    }

    /// Returns true if first and second derivatives just after the points are small enough for sums
    /// of two of them.
    pub(super) fn is_finite(&self) -> bool {
        // All that overflow or NaN could hide in is one sum, eight numbers at a time.
        let small = |values: &[f64]| {
            let mut sums = [0.0_f64; 8];
            let (eights, rest) = values.as_chunks::<8>();
            eights.iter().for_each(|eight| sums.iter_mut().zip(eight).for_each(|(sum, value)| *sum += value.abs()));
            sums.iter().chain(rest).map(|value| value.abs()).sum::<f64>() < 0.5 * f64::MAX
        };
        small(self.after[0]) && small(self.after[1])
    }

    /// First derivatives of all axes just after point `i`.
    pub(super) fn first(&self, i: usize) -> &'a [f64] {
        &self.after[0][i * self.axes..(i + 1) * self.axes]
    }

    /// Second derivatives of all axes just after point `i`.
    pub(super) fn second(&self, i: usize) -> &'a [f64] {
        &self.after[1][i * self.axes..(i + 1) * self.axes]
    }

    /// First derivatives of all axes just before point `i`, if they are given apart.
    pub(super) fn first_before(&self, i: usize) -> Option<&'a [f64]> {
        self.apart(0, i)
    }

    /// Second derivatives of all axes just before point `i`, if they are given apart.
    pub(super) fn second_before(&self, i: usize) -> Option<&'a [f64]> {
        self.apart(1, i)
    }

    fn apart(&self, order: usize, i: usize) -> Option<&'a [f64]> {
        let apart = i > 0 && !std::ptr::eq(self.before[order], self.after[order]);
        apart.then(|| &self.before[order][i * self.axes..(i + 1) * self.axes])
    }

    /// Axis `j` just after point `i`; an unknown third derivative is 0.
    pub(super) fn start(&self, i: usize, j: usize) -> Jet {
        self.after.map(|values| values.get(i * self.axes + j).copied().unwrap_or(0.0))
    }

    /// Axis `j` just before point `i`.
    pub(super) fn end(&self, i: usize, j: usize) -> Jet {
        self.before.map(|values| values.get(i * self.axes + j).copied().unwrap_or(0.0))
    }

    /// Axis `j` in the middle of interval `k` of length `h`.
    pub(super) fn mid(&self, k: usize, h: f64, j: usize) -> Jet {
        let ([p0, s0, t0], [p1, s1, t1]) = (self.start(k, j), self.end(k + 1, j));
        let third = match self.middle_third {
            Some(third) => third[k * self.axes + j],
            None if self.has_third() => 0.5 * (t0 + t1),
            None => (s1 - s0) / h,
        };
        if let Some([first, second]) = self.middle {
            return [first[k * self.axes + j], second[k * self.axes + j], third];
        }
        let second = if self.has_third() {
            0.5 * (s0 + s1) + 0.125 * h * (t0 - t1)
        } else {
            1.5 * (p1 - p0) / h - 0.25 * (s0 + s1)
        };
        [0.5 * (p0 + p1) + 0.125 * h * (s0 - s1), second, third]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cubic through values and slopes at both ends of an interval is enclosed by its Bernstein coefficients, and by nothing wider.
    #[test]
    fn an_interval_is_enclosed_by_the_coefficients_of_its_cubics() {
        for (second, coefficient) in [([0.0, -1.0], 1.0 / 3.0), ([1.0, 0.0], 1.0 / 3.0), ([-0.6, 0.9], 0.3)] {
            let path = PathDerivatives::new(1, &[0.0, 0.0], &second).expect("two points");
            for h in [1.0, 2.0] {
                let [first, second_most, third] = path.interval(0, h, 0);
                assert!((first - h * coefficient).abs() < 1e-15, "{first}");
                assert_eq!(
                    (second_most, third),
                    (second[0].abs().max(second[1].abs()), (second[1] - second[0]).abs() / h)
                );
            }
        }
    }
}
