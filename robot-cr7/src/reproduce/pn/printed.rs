//! Equations of Liu et al. 2023 whose print is wrong, and by how much.

use nalgebra::Vector3;

use crate::reproduce::Reproduction;
use crate::reproduce::spline::Spline;

const PLACE: &str = "Equations as printed: what they give";

/// What the printed equations give.
#[derive(Debug, Clone, PartialEq)]
pub struct PrintedRun {
    /// Largest distance of eq. 8 as printed from Bezier 1 of Table 1, m.
    pub bezier: f64,
    /// Eq. 28 as printed and corrected in the middle of the second knot span of Table 1.
    pub map: (f64, f64),
    /// Eq. 16 as printed and corrected: way at 10 mm/s after 0.1 s, mm.
    pub way: (f64, f64),
    /// Share of the butterfly where the chord speed of Algorithm 2 is no number at 0.05 mm.
    pub no_number: f64,
    /// Normal jerk over its limit with the square root of Algorithm 2, at 0.1/mm and 1000 mm/s^3.
    pub jerk: f64,
}

impl PrintedRun {
    /// Evaluates the printed equations.
    pub fn measure(six: &Spline, butterfly: &Spline) -> Self {
        let spans = six.breaks();
        let points: Vec<Vector3<f64>> = six.bezier(spans[0], spans[1]).iter().map(|p| p.xyz() / p.w).collect();
        let bezier = (0..=100).map(|i| f64::from(i) / 100.0).map(|u| {
            let v = 1.0 - u;
            let rest = points[1] * (3.0 * u * v * v) + points[2] * (3.0 * u * u * v) + points[3] * u.powi(3);
            // Eq. 8 prints (1 - u^3) for (1 - u)^3; the weights are 1.
            let printed = points[0] * (1.0 - u.powi(3)) + rest;
            (printed - six.point(spans[0] + (spans[1] - spans[0]) * u)).norm()
        });
        let (m, n) = (spans[1], spans[2]);
        let mu = 0.5 * (m + n);
        let (v, t) = (10.0, 0.1);
        let (lo, hi) = butterfly.domain();
        let places = 20_000;
        let bend = (0..places).map(|i| lo + (hi - lo) * (f64::from(i) + 0.5) / f64::from(places));
        // 2 delta / kappa - delta^2 < 0.
        let none = bend.filter(|u| butterfly.curvature(*u).abs() * 5e-5 > 2.0).count();
        let (kappa, limit) = (0.1, 1000.0f64);
        let speed = (limit / (kappa * kappa)).sqrt();
        Self {
            bezier: bezier.fold(0.0, f64::max),
            map: ((mu - m) / (m - n), (mu - m) / (n - m)),
            way: (v, v * t),
            no_number: none as f64 / f64::from(places),
            jerk: speed.powi(3) * kappa * kappa / limit,
        }
    }

    /// Adds the rows.
    pub fn judge(&self, r: &mut Reproduction) {
        r.information(PLACE, "eq. 8: off Bezier 1 of Table 1, mm", "0", format!("{:.3}", self.bezier * 1e3))
            .note("(1 - u)^3 is meant where (1 - u^3) is printed");
        r.information(PLACE, "eq. 28: u in the middle of a span", "0.5", format!("{}", self.map.0))
            .note(format!("the denominator is n - m: {}", self.map.1));
        r.information(PLACE, "eq. 16: way at 10 mm/s after 0.1 s, mm", "1", format!("{}", self.way.0))
            .note(format!("a factor t is missing: {}", self.way.1));
        r.information(
            PLACE,
            "Algorithm 2: chord speed is no number, share of the butterfly, %",
            "0",
            format!("{:.3}", self.no_number * 100.0),
        )
        .note("where curvature times tolerance is above 2, at 0.05 mm");
        r.information(PLACE, "Algorithm 2: normal jerk over its limit", "1", format!("{:.0}", self.jerk))
            .note("at 0.1/mm and 1000 mm/s^3; the cube root is meant where the square root is printed");
    }
}
