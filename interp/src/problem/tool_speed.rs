//! Speed of the tool on a path of the joints, where the tool is not prescribed.

use arcfeed_feedrate::constraint::{PathConstraint, Place, RowSink};
use arcfeed_feedrate::{IntervalBound, LimitId, Quantity};
use arcfeed_kinematics::ForwardKinematics;

use crate::path::{JointJet, JointPath};

/// Speeds of the tool by the parameter, linear and angular: at the grid points and in the middle between two.
#[derive(Debug, Clone)]
pub(crate) struct ToolRates {
    points: Vec<[f64; 2]>,
    middles: Vec<[f64; 2]>,
}

impl ToolRates {
    pub fn of<const N: usize>(arm: &dyn ForwardKinematics<N>, joints: &JointPath<N>, middles: &[JointJet<N>]) -> Self {
        let rates = |jet: &JointJet<N>| {
            let twist = arm.jacobian(&jet.q) * jet.d1;
            [twist.fixed_rows::<3>(0).norm(), twist.fixed_rows::<3>(3).norm()]
        };
        Self { points: joints.nodes().iter().map(rates).collect(), middles: middles.iter().map(rates).collect() }
    }

    /// A limit (m/s) on the speed of the tool point.
    pub fn linear(&self, limit: f64) -> ToolSpeed<'_> {
        ToolSpeed { rates: self, part: 0, limit, source: LimitId::path(Quantity::Feed) }
    }

    /// A limit (rad/s) on the angular speed.
    pub fn angular(&self, limit: f64) -> ToolSpeed<'_> {
        ToolSpeed { rates: self, part: 1, limit, source: LimitId::path(Quantity::AngularSpeed) }
    }
}

/// A limit on the linear or the angular speed of the tool.
#[derive(Debug)]
pub(crate) struct ToolSpeed<'a> {
    rates: &'a ToolRates,
    part: usize,
    limit: f64,
    source: LimitId,
}

impl ToolSpeed<'_> {
    /// Rates over interval `k` as Bernstein coefficients of the parabola through three of them.
    fn over(&self, k: usize) -> [f64; 3] {
        let [p, q] = [k, k + 1].map(|i| self.rates.points[i][self.part]);
        let middle = self.rates.middles.get(k).map_or(0.5 * (p + q), |rates| rates[self.part]);
        [p, 2.0 * middle - 0.5 * (p + q), q]
    }
}

impl PathConstraint for ToolSpeed<'_> {
    fn points(&self) -> Option<usize> {
        Some(self.rates.points.len())
    }

    fn rows(&self, place: Place, out: &mut RowSink<'_>) {
        let rate = match place {
            Place::Point(i) => self.rates.points[i][self.part],
            Place::Middle { k, .. } => self.rates.middles[k][self.part],
        };
        let speed = self.limit / rate;
        if speed.is_finite() {
            out.cap(speed * speed, self.source);
        }
    }

    fn interval_bounds(&self, k: usize, _h: f64, out: &mut Vec<IntervalBound>) {
        let rate = self.over(k).into_iter().fold(0.0, f64::max);
        if rate > 0.0 {
            out.push(IntervalBound::Speed { most: self.limit / rate, source: self.source });
        }
    }

    fn axis_speeds(&self, k: usize, _h: f64, out: &mut dyn FnMut([f64; 3], f64, LimitId)) {
        out(self.over(k), self.limit, self.source);
    }
}
