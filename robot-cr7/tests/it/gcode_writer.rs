//! Writes random moves as G-code in many styles.

use std::f64::consts::{PI, TAU};

use arcfeed_geometry::NurbsCurve;
use arcfeed_geometry::nalgebra::{Unit, Vector3, vector};
use arcfeed_testing::Random;
use robot_cr7::{GcodeMove, MoveKind, MoveShape};

const INCH: f64 = 0.0254;

/// Writes moves as G-code. Its fields are what the reader has to keep in mind too.
pub struct Writer {
    pub random: Random,
    pub text: String,
    line: u64,
    /// Words of the present block.
    words: Vec<String>,
    unit: f64,
    incremental: bool,
    absolute_centres: bool,
    plane: usize,
    /// Last motion code, where a block may leave it out.
    motion: Option<&'static str>,
    feed: Option<f64>,
    inverse_time: bool,
    position: Vector3<f64>,
    rotary: Option<Vector3<f64>>,
    pub moves: Vec<GcodeMove>,
}

impl Writer {
    pub fn new(seed: u64) -> Self {
        Self {
            random: Random::new(seed),
            text: String::new(),
            line: 1,
            words: vec!["G21".to_owned(), "G90".to_owned(), "G91.1".to_owned(), "G17".to_owned()],
            unit: 1e-3,
            incremental: false,
            absolute_centres: false,
            plane: 0,
            motion: None,
            feed: None,
            inverse_time: false,
            position: Vector3::zeros(),
            rotary: None,
            moves: Vec::new(),
        }
    }

    fn point(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| 0.3 * self.random.signed())
    }

    /// `value` as digits, with a sign, without a zero, or as an expression.
    fn number(&mut self, value: f64) -> String {
        let digits = format!("{value}");
        match self.random.below(8) {
            0 if value >= 0.0 => format!("+{digits}"),
            1 if value.abs() < 1.0 => digits.replace("0.", "."),
            2 if !digits.contains('.') => format!("{digits}."),
            3 => format!("[{digits}]"),
            4 => format!("[[{digits}*4]/4]"),
            5 if value < 0.0 => format!("-[{}]", &digits[1..]),
            _ => digits,
        }
    }

    fn word(&mut self, letter: &str, value: f64) {
        let number = self.number(value);
        self.words.push(format!("{letter}{number}"));
    }

    fn length(&mut self, letter: &str, metres: f64) {
        self.word(letter, metres / self.unit);
    }

    fn code(&mut self, code: &str) {
        let (letter, number) = code.split_at(1);
        let zero = if number.len() == 1 && self.random.chance(0.3) { "0" } else { "" };
        self.words.push(format!("{letter}{zero}{number}"));
    }

    fn blanks(&mut self) -> &'static str {
        self.random.one_of(&["", "", "", " ", "  ", "\t"])
    }

    /// Ends the block: mixes its words, and adds numbers, comments, blanks and case. Returns line and number.
    pub fn end_block(&mut self) -> (u64, Option<u32>) {
        let number = self.random.chance(0.3).then(|| self.random.below(99_999) as u32);
        let mut words = std::mem::take(&mut self.words);
        for i in (1..words.len()).rev() {
            words.swap(i, self.random.below(i + 1));
        }
        if let Some(number) = number {
            words.insert(0, format!("N{number}"));
        }
        for word in words {
            let lower = self.random.chance(0.3);
            for c in word.chars() {
                self.text.push(if lower { c.to_ascii_lowercase() } else { c });
                if self.random.chance(0.1) {
                    let blanks = self.blanks();
                    self.text.push_str(blanks);
                }
            }
            let comment = self.random.one_of(&["", "", "", "", "(G41 not a code)", "(é;)"]);
            let blanks = self.blanks();
            self.text.push_str(blanks);
            self.text.push_str(comment);
        }
        self.text.push_str(self.random.one_of(&["\n", "\n", "\r\n", "; G41 (\n", " \n"]));
        self.line += 1;
        (self.line - 1, number)
    }

    /// Blocks without a move, and changes of modes.
    pub fn chatter(&mut self) {
        if self.random.chance(0.2) {
            self.text.push_str(self.random.one_of(&[
                "\n",
                "(a comment)\n",
                "; another\n",
                "/G1 X999\n",
                "M8\n",
                "S500 M3\n",
            ]));
            self.line += 1;
        }
        if self.random.chance(0.15) {
            let metric = self.unit == INCH;
            self.unit = if metric { 1e-3 } else { INCH };
            self.code(if metric { "G21" } else { "G20" });
        }
        if self.random.chance(0.15) {
            self.incremental = !self.incremental;
            self.code(if self.incremental { "G91" } else { "G90" });
        }
        if self.random.chance(0.15) {
            self.absolute_centres = !self.absolute_centres;
            self.code(if self.absolute_centres { "G90.1" } else { "G91.1" });
        }
        if !self.words.is_empty() && self.random.chance(0.3) {
            self.end_block();
        }
    }

    /// Writes the end point of a move; coordinates that stay may be left out.
    fn target(&mut self, to: Vector3<f64>) {
        for (axis, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
            if to[axis] == self.position[axis] && self.random.chance(0.7) {
                continue;
            }
            let from = if self.incremental { self.position[axis] } else { 0.0 };
            self.length(letter, to[axis] - from);
        }
    }

    fn motion(&mut self, code: &'static str) {
        if self.motion != Some(code) || self.random.chance(0.5) {
            self.code(code);
        }
        self.motion = Some(code);
    }

    fn rotary(&mut self) {
        if self.random.chance(0.85) {
            return;
        }
        let before = self.rotary.unwrap_or_default();
        let mut degrees = before.map(f64::to_degrees);
        for (axis, letter) in ["A", "B", "C"].into_iter().enumerate() {
            if self.random.chance(0.5) {
                let to = self.random.between(-400.0, 400.0);
                let from = if self.incremental { degrees[axis] } else { 0.0 };
                self.word(letter, to - from);
                degrees[axis] = to;
                self.rotary = Some(degrees.map(f64::to_radians));
            }
        }
    }

    fn feed(&mut self) -> MoveKind {
        if self.random.chance(0.1) {
            self.inverse_time = !self.inverse_time;
            self.code(if self.inverse_time { "G93" } else { "G94" });
            self.feed = None;
        }
        if self.inverse_time {
            let seconds = self.random.log(0.01, 100.0);
            self.word("F", 60.0 / seconds);
            return MoveKind::InverseTime { seconds };
        }
        let speed = match self.feed {
            Some(speed) if self.random.chance(0.7) => speed,
            _ => {
                let speed = self.random.log(1e-4, 1.0);
                self.word("F", speed * 60.0 / self.unit);
                speed
            }
        };
        self.feed = Some(speed);
        MoveKind::Feed { speed }
    }

    fn finish(&mut self, kind: MoveKind, shape: MoveShape) {
        let (line, number) = self.end_block();
        self.push(line, number, kind, shape);
    }

    fn push(&mut self, line: u64, number: Option<u32>, kind: MoveKind, shape: MoveShape) {
        let step = GcodeMove { line, number, kind, shape, control: None, rotary: self.rotary };
        self.position = step.end();
        self.moves.push(step);
    }

    pub fn line(&mut self) {
        let mut to = self.point();
        if self.random.chance(0.4) {
            to[self.random.below(3)] = self.position[0];
        }
        let rapid = self.random.chance(0.4);
        self.motion(if rapid { "G0" } else { "G1" });
        self.target(to);
        self.rotary();
        let kind = if rapid { MoveKind::Rapid } else { self.feed() };
        self.finish(kind, MoveShape::Line { to });
    }

    pub fn arc(&mut self) {
        if self.random.chance(0.4) {
            self.plane = self.random.below(3);
            self.code(["G17", "G18", "G19"][self.plane]);
        }
        let [a, b, n] = [[0, 1, 2], [2, 0, 1], [1, 2, 0]][self.plane];
        let clockwise = self.random.chance(0.5);
        let full = self.random.chance(0.2);
        // Not near a half or a full turn, where a radius does not determine the centre well.
        let angle = match self.random.below(2) {
            0 => self.random.between(0.1, PI - 0.1),
            _ => self.random.between(PI + 0.1, TAU - 0.1),
        };
        let angle = if full { TAU } else { angle };
        let turns = if self.random.chance(0.3) { 1.0 + self.random.below(4) as f64 } else { 1.0 };
        let radius = self.random.log(1e-3, 0.5);
        let heading = self.random.between(0.0, TAU);
        let sign = if clockwise { -1.0 } else { 1.0 };
        let mut centre = self.position;
        centre[a] -= radius * heading.cos();
        centre[b] -= radius * heading.sin();
        let mut to = self.position;
        if !full {
            to[a] = centre[a] + radius * (heading + sign * angle).cos();
            to[b] = centre[b] + radius * (heading + sign * angle).sin();
        }
        let rise = if self.random.chance(0.4) { 0.1 * self.random.signed() } else { 0.0 };
        to[n] += rise;

        self.motion(if clockwise { "G2" } else { "G3" });
        self.target(to);
        if !full && self.random.chance(0.4) {
            self.length("R", if angle > PI { -radius } else { radius });
        } else {
            let from = if self.absolute_centres { Vector3::zeros() } else { self.position };
            self.length(["I", "J", "K"][a], centre[a] - from[a]);
            self.length(["I", "J", "K"][b], centre[b] - from[b]);
        }
        if turns > 1.0 || self.random.chance(0.2) {
            self.word("P", turns);
        }
        self.rotary();
        let kind = self.feed();
        let normal = Unit::new_normalize(Vector3::from_fn(|i, _| if i == n { 1.0 } else { 0.0 }));
        self.finish(kind, MoveShape::Arc { centre, normal, sweep: sign * (angle + TAU * (turns - 1.0)), rise, to });
    }

    /// G5 or G5.1, which need the XY plane.
    pub fn spline(&mut self) {
        if self.plane != 0 {
            self.plane = 0;
            self.code("G17");
        }
        let offset = |random: &mut Random| vector![random.between(0.01, 0.1), random.between(-0.1, -0.01), 0.0];
        let (first, second) = (offset(&mut self.random), offset(&mut self.random));
        let (start, mut to) = (self.position, self.point());
        to.z = start.z;
        let cubic = self.random.chance(0.5);
        self.code(if cubic { "G5" } else { "G5.1" });
        self.motion = None;
        for (axis, letter) in ["X", "Y"].into_iter().enumerate() {
            let from = if self.incremental { start[axis] } else { 0.0 };
            self.length(letter, to[axis] - from);
        }
        self.length("I", first.x);
        self.length("J", first.y);
        let kind = self.feed();
        let curve = if cubic {
            self.length("P", second.x);
            self.length("Q", second.y);
            let points = vec![start, start + first, to + second, to];
            NurbsCurve::bspline(3, points, vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0])
        } else {
            NurbsCurve::bspline(2, vec![start, start + first, to], vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
        };
        self.finish(kind, MoveShape::Curve(Box::new(curve.expect("a curve"))));
    }

    /// A NURBS block, with knots of its own (G6.2) or with uniform ones (G5.2).
    pub fn nurbs(&mut self) {
        if self.incremental {
            if !self.words.is_empty() {
                self.end_block();
            }
            self.incremental = false;
            self.code("G90");
        }
        let explicit = self.random.chance(0.5);
        let order = if explicit { 2 + self.random.below(4) } else { 3 + self.random.below(3) };
        let count = order + self.random.below(5);
        let mut points = vec![self.position];
        let mut weights = vec![1.0];
        let mut inner = Vec::new();
        for i in 1..count {
            points.push(self.point());
            weights.push(self.random.between(0.5, 2.0));
            if i > count - order {
                continue;
            }
            inner.push(if explicit { inner.last().unwrap_or(&0.0) + self.random.between(0.1, 2.0) } else { i as f64 });
        }
        let last = if explicit { inner.last().unwrap_or(&0.0) + 1.0 } else { (count - order + 1) as f64 };
        let mut knots = vec![0.0; order];
        knots.extend(inner);
        knots.extend(vec![last; order]);
        let kind = self.nurbs_opening(explicit, order, &knots, &mut weights);
        let (line, number) = self.end_block();
        for i in 1..count {
            for (axis, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
                self.length(letter, points[i][axis]);
            }
            self.word(if explicit { "R" } else { "P" }, weights[i]);
            if explicit {
                self.word("K", knots[i]);
            }
            self.end_block();
        }
        if explicit {
            for &knot in &knots[count..] {
                self.word("K", knot);
                self.end_block();
            }
        } else {
            self.code("G5.3");
            self.end_block();
        }
        let curve = NurbsCurve::new(order - 1, points, weights, knots).expect("a curve");
        self.motion = None;
        self.push(line, number, kind, MoveShape::Curve(Box::new(curve)));
    }

    fn nurbs_opening(&mut self, explicit: bool, order: usize, knots: &[f64], weights: &mut [f64]) -> MoveKind {
        self.code(if explicit { "G6.2" } else { "G5.2" });
        let kind = self.feed();
        if explicit {
            for (axis, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
                self.length(letter, self.position[axis]);
            }
            self.word("P", order as f64);
            self.word("K", knots[0]);
        } else {
            self.word("L", order as f64);
            weights[0] = self.random.between(0.5, 2.0);
            self.word("P", weights[0]);
        }
        kind
    }
}
