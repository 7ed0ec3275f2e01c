//! Torque of joints: rigid-body dynamics with Coulomb and viscous friction.

use super::interface::{PathConstraint, Place, RowSink};
use crate::error::FeedError;
use crate::row::{LimitId, Quantity, Row};

/// `|a u + b x + c sqrt(x) + d| <= tau` for every joint (Electronics 2025, 14, 3869, eq. 8).
///
/// With mass matrix `M`, Coriolis term `C`, gravity `g`, Coulomb friction `f_c` and viscous
/// friction `f_v`: `a = M q'`, `b = M q'' + C(q, q') q'`, `c = f_v q'`, `d = g + f_c sign(q')`. The
/// sums are the caller's, who knows the arm.
#[derive(Debug, Clone, Copy)]
pub struct JointTorque<'a> {
    joints: usize,
    points: usize,
    terms: [&'a [f64]; 4],
    limits: &'a [f64],
}

impl<'a> JointTorque<'a> {
    /// The four terms at every grid point, entry `i * joints + j` for joint `j` at point `i` (an
    /// empty array for `c` or `d` means 0), and the limits per joint (N m), not negative; infinity
    /// means none.
    ///
    /// # Errors
    /// [`FeedError::Empty`], [`FeedError::LengthMismatch`], [`FeedError::Negative`].
    pub fn new(a: &'a [f64], b: &'a [f64], c: &'a [f64], d: &'a [f64], limits: &'a [f64]) -> Result<Self, FeedError> {
        if a.is_empty() || limits.is_empty() {
            return Err(FeedError::Empty { what: "torque terms" });
        }
        let (joints, points) = (limits.len(), a.len() / limits.len());
        for (values, may_be_empty) in [(a, false), (b, false), (c, true), (d, true)] {
            if values.len() != joints * points && !(may_be_empty && values.is_empty()) {
                return Err(FeedError::LengthMismatch {
                    what: "torque terms",
                    got: values.len(),
                    expected: joints * points,
                });
            }
        }
        if let Some(&value) = limits.iter().find(|&&limit| limit.is_nan() || limit < 0.0) {
            return Err(FeedError::Negative { what: "torque limits", value });
        }
        Ok(Self { joints, points, terms: [a, b, c, d], limits })
    }

    fn push(&self, j: usize, [a, b, c, d]: [f64; 4], out: &mut RowSink<'_>) {
        let limit = self.limits[j];
        let source = LimitId::joint(Quantity::JointTorque, j);
        out.row(Row { a, b, c, d, lo: -limit, hi: limit, source });
    }
}

impl PathConstraint for JointTorque<'_> {
    fn points(&self) -> Option<usize> {
        Some(self.points)
    }

    /// In the middle of an interval the terms are interpolated, from four points where there are as
    /// many.
    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        let at = |values: &[f64], i: usize, j: usize| values.get(i * self.joints + j).copied().unwrap_or(0.0);
        for j in 0..self.joints {
            let terms = match place {
                Place::Point(i) => self.terms.map(|values| at(values, i, j)),
                Place::Middle { k, .. } => self.terms.map(|values| {
                    let two = at(values, k, j) + at(values, k + 1, j);
                    if k == 0 || k + 2 >= self.points {
                        0.5 * two
                    } else {
                        (9.0 * two - at(values, k - 1, j) - at(values, k + 2, j)) / 16.0
                    }
                }),
            };
            self.push(j, terms, out);
        }
    }
}
