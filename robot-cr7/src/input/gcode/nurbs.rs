//! NURBS blocks: G5.2 with G5.3, and G6.2.
//!
//! G5.2 (LinuxCNC, "G5.2 G5.3 NURBS Block"): the present position is the first control point, P is the weight of a point
//! (default 1) and L the order (default 3). The knots are uniform and clamped.
//!
//! G6.2 (Fanuc Series 15i/150i-MA, Programming Manual, "NURBS interpolation"; LinuxCNC takes the same form): P is the
//! order (default 4), each control point stands with a knot K and a weight R (default 1), and blocks with a knot alone
//! follow, as many as the order. The curve starts at the first control point, which is the present position, and ends at
//! the last one, so that the first and the last knots are repeated. LinuxCNC adds Q 1, 2 or 3: how its interpolator
//! steps along the curve. It has no effect on the curve.

use arcfeed_geometry::NurbsCurve;
use nalgebra::Vector3;

use super::block::{Block, Word};
use super::expression::whole;
use super::fault::{GcodeFault, Located};
use super::program::{MoveKind, MoveShape};
use crate::input::path_file::MOST_CONTROL_POINTS;

/// Orders that a block may ask for.
const ORDERS: std::ops::RangeInclusive<f64> = 2.0..=16.0;
/// The first control point may differ from the present position by this, in metres.
const START_TOLERANCE: f64 = 1e-6;
/// Control points within this distance in metres make no curve.
const SHORTEST: f64 = 1e-9;

/// A NURBS block that is being read.
#[derive(Debug)]
pub(super) struct NurbsBlock {
    /// Line of its first block.
    pub(super) line: u64,
    /// N word of its first block.
    pub(super) number: Option<u32>,
    pub(super) kind: MoveKind,
    order: usize,
    points: Vec<Vector3<f64>>,
    weights: Vec<f64>,
    /// Knots of G6.2; G5.2 has none.
    knots: Option<Vec<f64>>,
    /// Blocks with a knot alone.
    knots_alone: usize,
}

impl NurbsBlock {
    /// A block that starts at `position` with the words of its first line.
    ///
    /// `explicit` is true for G6.2. `to` is the control point of the line.
    pub(super) fn open(
        block: &mut Block,
        (line, kind): (u64, MoveKind),
        position: Vector3<f64>,
        explicit: bool,
        to: Option<Vector3<f64>>,
    ) -> Result<Self, Located> {
        let mut this = Self {
            line,
            number: block.number,
            kind,
            order: if explicit { 4 } else { 3 },
            points: Vec::new(),
            weights: Vec::new(),
            knots: explicit.then(Vec::new),
            knots_alone: 0,
        };
        if !explicit {
            // Without a point, P is the weight of the present position.
            let weight = block.take(b'p');
            this.push(position, weight.filter(|_| to.is_none()))?;
            if let Some(word) = block.take(b'l') {
                this.order = order(&word)?;
            }
            if let Some(point) = to {
                this.push(point, weight)?;
            }
            return Ok(this);
        }
        if let Some(word) = block.take(b'p') {
            this.order = order(&word)?;
        }
        if let Some(word) = block.take(b'q')
            && !matches!(whole(word.value), Some(q) if (1.0..=3.0).contains(&q))
        {
            return Err(word.refuse("Q of G6.2 is 1, 2 or 3", "correct or remove it"));
        }
        let first = to.unwrap_or(position);
        let gap = (first - position).norm();
        if gap > START_TOLERANCE {
            let rule = "the first control point of G6.2 is the present position";
            let remedy = "move to it before (the value is the distance in m)";
            return Err(block.code_fault(62, GcodeFault::Value { value: gap, rule, remedy }));
        }
        this.add(block, Some(position))?;
        Ok(this)
    }

    /// Takes over the words of a further line with the control point `to`.
    pub(super) fn add(&mut self, block: &mut Block, to: Option<Vector3<f64>>) -> Result<(), Located> {
        match &mut self.knots {
            None => {
                if let Some(word) = block.take(b'l') {
                    self.order = order(&word)?;
                }
                match (to, block.take(b'p')) {
                    (Some(point), weight) => self.push(point, weight),
                    (None, Some(word)) => Err(word
                        .refuse("a weight without a control point belongs to the first line of G5.2", "add X and Y")),
                    (None, None) => Ok(()),
                }
            }
            Some(knots) => {
                let needs = "each line of G6.2 has a knot";
                let remedy = "add K; a curve of order P ends with P lines of a knot alone";
                let Some(knot) = block.take(b'k') else {
                    return Err(block.fault(GcodeFault::Missing { needs, remedy }));
                };
                if knots.last().is_some_and(|&last| knot.value < last) {
                    return Err(knot.refuse("knots must not decrease", "correct the knot"));
                }
                knots.push(knot.value);
                match to {
                    Some(_) if self.knots_alone > 0 => {
                        let rule = "a control point stands behind a knot alone";
                        let remedy = "finish the knots of the curve first";
                        Err(block.fault(GcodeFault::Syntax { rule, remedy }))
                    }
                    Some(point) => {
                        let weight = block.take(b'r');
                        self.push(point, weight)
                    }
                    None => {
                        self.knots_alone += 1;
                        Ok(())
                    }
                }
            }
        }
    }

    /// True where a curve of G6.2 has all its knots.
    pub(super) fn is_complete(&self) -> bool {
        self.knots.is_some() && self.knots_alone == self.order
    }

    /// True for G6.2.
    pub(super) fn is_explicit(&self) -> bool {
        self.knots.is_some()
    }

    fn push(&mut self, point: Vector3<f64>, weight: Option<Word>) -> Result<(), Located> {
        if let Some(word) = weight
            && word.value <= 0.0
        {
            return Err(word.refuse("weights are above 0", "correct the weight"));
        }
        if self.points.len() >= MOST_CONTROL_POINTS {
            let rule = "a curve has 25000 control points at most";
            return Err(Located::new(1, "the block", GcodeFault::Syntax { rule, remedy: "divide it" }));
        }
        self.points.push(point);
        self.weights.push(weight.map_or(1.0, |w| w.value));
        Ok(())
    }

    /// The curve.
    pub(super) fn curve(self) -> Result<MoveShape, GcodeFault> {
        let (order, count) = (self.order, self.points.len());
        if count < order {
            let needs = "a NURBS block has at least as many control points as its order";
            return Err(GcodeFault::Missing { needs, remedy: "add points or lower the order" });
        }
        let knots = match self.knots {
            Some(knots) => {
                let ends = [&knots[..order], &knots[knots.len() - order..]];
                if ends.iter().any(|end| end.iter().any(|k| k != &end[0])) {
                    let rule = "the first P knots of G6.2 are equal, and so are the last P";
                    return Err(GcodeFault::Syntax { rule, remedy: "repeat the knots at both ends" });
                }
                knots
            }
            None => {
                let last = count - order + 1;
                (0..count + order).map(|i| (i + 1).saturating_sub(order).min(last) as f64).collect()
            }
        };
        spline(self.points, self.weights, knots)
    }
}

/// The curve of these control points; the degree follows from the number of knots.
pub(super) fn spline(points: Vec<Vector3<f64>>, weights: Vec<f64>, knots: Vec<f64>) -> Result<MoveShape, GcodeFault> {
    if points.iter().all(|p| (p - points[0]).norm() < SHORTEST) {
        let needs = "the control points of a spline are not all the same";
        return Err(GcodeFault::Missing { needs, remedy: "correct or remove the spline" });
    }
    let degree = knots.len().saturating_sub(points.len() + 1);
    let curve = NurbsCurve::new(degree, points, weights, knots).map_err(GcodeFault::Curve)?;
    Ok(MoveShape::Curve(Box::new(curve)))
}

fn order(word: &Word) -> Result<usize, Located> {
    match whole(word.value) {
        Some(order) if ORDERS.contains(&order) => Ok(order as usize),
        _ => Err(word.refuse("the order of a curve is a whole number from 2 to 16", "correct it")),
    }
}
