//! Random programs are written as G-code in many styles and read back; hostile texts and long programs are survived.

use std::f64::consts::{PI, TAU};
use std::io::{self, BufReader, Read};
use std::path::Path;

use arcfeed_geometry::NurbsCurve;
use arcfeed_geometry::nalgebra::{Unit, Vector3, vector};
use arcfeed_testing::Random;
use robot_cr7::{GcodeMove, GcodeOptions, GcodeProgram, InputError, MoveKind, MoveShape, PathControl};

const INCH: f64 = 0.0254;

/// Writes moves as G-code. Its fields are what the reader has to keep in mind too.
struct Writer {
    random: Random,
    text: String,
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
    moves: Vec<GcodeMove>,
}

impl Writer {
    fn new(seed: u64) -> Self {
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
    fn end_block(&mut self) -> (u64, Option<u32>) {
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
    fn chatter(&mut self) {
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
        let step = GcodeMove { line, number, kind, shape, control: PathControl::ExactPath, rotary: self.rotary };
        self.position = step.end();
        self.moves.push(step);
    }

    fn line(&mut self) {
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

    fn arc(&mut self) {
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
    fn spline(&mut self) {
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
    fn nurbs(&mut self) {
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

fn random_program(seed: u64) -> (String, Vec<GcodeMove>) {
    let mut writer = Writer::new(seed);
    writer.end_block();
    for _ in 0..1 + writer.random.below(25) {
        writer.chatter();
        match writer.random.below(8) {
            0..=2 => writer.line(),
            3..=5 => writer.arc(),
            6 => writer.spline(),
            _ => writer.nurbs(),
        }
    }
    (writer.text, writer.moves)
}

/// Largest difference of two moves in m, rad and relative speed, or infinity where they are of different kinds.
fn difference(a: &GcodeMove, b: &GcodeMove) -> f64 {
    let ratio = |a: f64, b: f64| (a / b - 1.0).abs();
    let kind = match (a.kind, b.kind) {
        (MoveKind::Rapid, MoveKind::Rapid) => 0.0,
        (MoveKind::Feed { speed: a }, MoveKind::Feed { speed: b }) => ratio(a, b),
        (MoveKind::InverseTime { seconds: a }, MoveKind::InverseTime { seconds: b }) => ratio(a, b),
        _ => f64::INFINITY,
    };
    let far = |a: &[f64], b: &[f64]| {
        if a.len() != b.len() {
            return f64::INFINITY;
        }
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let shape = match (&a.shape, &b.shape) {
        (MoveShape::Line { .. }, MoveShape::Line { .. }) => 0.0,
        (
            MoveShape::Arc { centre, normal, sweep, rise, .. },
            MoveShape::Arc { centre: c, normal: n, sweep: s, rise: r, .. },
        ) => (centre - c).norm() + (normal.into_inner() - n.into_inner()).norm() + (sweep - s).abs() + (rise - r).abs(),
        (MoveShape::Curve(a), MoveShape::Curve(b)) => {
            let points = a.control_points().iter().zip(b.control_points()).map(|(a, b)| (a - b).norm());
            let points = points.fold(0.0, f64::max);
            points + far(a.weights(), b.weights()) + far(a.knots().as_slice(), b.knots().as_slice())
        }
        _ => f64::INFINITY,
    };
    let rotary = match (a.rotary, b.rotary) {
        (None, None) => 0.0,
        (Some(a), Some(b)) => (a - b).norm(),
        _ => f64::INFINITY,
    };
    let places = if (a.line, a.number, a.control) == (b.line, b.number, b.control) { 0.0 } else { f64::INFINITY };
    kind + shape + rotary + places + (a.end() - b.end()).norm()
}

#[test]
fn random_programs_are_read_as_they_were_written() {
    for seed in 0..3000 {
        let (text, moves) = random_program(seed);
        let program = GcodeProgram::from_bytes(text.as_bytes(), Path::new("random.ngc"), &GcodeOptions::default())
            .unwrap_or_else(|e| panic!("seed {seed}: {e}\n{text}"));
        assert_eq!(program.moves.len(), moves.len(), "seed {seed}\n{text}");
        for (found, expected) in program.moves.iter().zip(&moves) {
            let difference = difference(found, expected);
            assert!(difference < 1e-9, "seed {seed}: {difference}: {found:?} is not {expected:?}\n{text}");
        }
    }
}

const SAMPLES: [&str; 9] = [
    include_str!("../../data/gcode/helix.ngc"),
    include_str!("../../data/gcode/inch.ngc"),
    include_str!("../../data/gcode/nurbs_g5.ngc"),
    include_str!("../../data/gcode/nurbs_g6.ngc"),
    include_str!("../../data/gcode/pocket.ngc"),
    include_str!("../../data/gcode/rotary.ngc"),
    include_str!("../../data/gcode/splines.ngc"),
    include_str!("../../data/gcode/square.ngc"),
    include_str!("../../data/gcode/variables.ngc"),
];

/// Random bytes, random pieces of words, or a sample with damage.
fn hostile_text(random: &mut Random) -> Vec<u8> {
    let pieces: [&[u8]; 48] = [
        b"G",
        b"G0",
        b"G1",
        b"G2",
        b"G3",
        b"G5",
        b"G5.1",
        b"G5.2",
        b"G5.3",
        b"G6.2",
        b"G90",
        b"G91",
        b"G20",
        b"G18",
        b"G93",
        b"G64",
        b"M3",
        b"M2",
        b"X",
        b"Y",
        b"Z1",
        b"I",
        b"J",
        b"K",
        b"R",
        b"P2",
        b"Q",
        b"L3",
        b"F1",
        b"A",
        b"1",
        b"-",
        b".5",
        b"999999999",
        b"[",
        b"]",
        b"#1",
        b"#1=",
        b"#<a>",
        b"=",
        b"**",
        b"/",
        b"SIN[",
        b"ATAN[1]/",
        b"(",
        b")",
        b"\n",
        b"0",
    ];
    match random.below(3) {
        0 => (0..random.below(300)).map(|_| random.bits() as u8).collect(),
        1 => (0..random.below(150)).flat_map(|_| random.one_of(&pieces).iter().copied()).collect(),
        _ => {
            let mut text = random.one_of(&SAMPLES).as_bytes().to_vec();
            for _ in 0..1 + random.below(6) {
                let at = random.below(text.len());
                let end = (at + random.below(20)).min(text.len());
                match random.below(5) {
                    0 => text[at] = random.bits() as u8,
                    1 => drop(text.drain(at..end)),
                    2 => text.splice(at..at, random.one_of(&pieces).iter().copied()).for_each(drop),
                    3 => text.splice(at..end, random.one_of(&pieces).iter().copied()).for_each(drop),
                    _ => text.extend_from_within(at..end),
                }
                if text.is_empty() {
                    break;
                }
            }
            text
        }
    }
}

/// Reads `count` hostile texts. What is read is finite and connected; what is not has a place. Returns how many were read.
fn read_hostile_texts(seed: u64, count: u64) -> u64 {
    let mut read = 0;
    for seed in seed..seed + count {
        let text = hostile_text(&mut Random::new(seed));
        match GcodeProgram::from_bytes(&text, Path::new("hostile.ngc"), &GcodeOptions::default()) {
            Ok(program) => {
                read += 1;
                for (start, step) in program.moves_with_starts() {
                    assert_sound(start, step, seed);
                }
                assert!(program.markers.iter().all(|m| m.after <= program.moves.len()), "seed {seed}");
            }
            Err(InputError::Gcode { line, column, word, .. }) => {
                let lines = 1 + text.iter().filter(|&&b| b == b'\n').count() as u64;
                assert!((1..=lines).contains(&line) && column >= 1 && !word.is_empty(), "seed {seed}");
            }
            Err(InputError::Empty { .. }) => {}
            Err(e) => panic!("seed {seed}: {e}"),
        }
    }
    read
}

fn assert_sound(start: Vector3<f64>, step: &GcodeMove, seed: u64) {
    let finite = |v: Vector3<f64>| v.iter().all(|x| x.is_finite());
    assert!(finite(step.end()) && step.rotary.is_none_or(finite), "seed {seed}: {step:?}");
    match step.kind {
        MoveKind::Rapid => {}
        MoveKind::Feed { speed: x } | MoveKind::RotaryFeed { speed: x } | MoveKind::InverseTime { seconds: x } => {
            assert!(x.is_finite() && x > 0.0, "seed {seed}: {step:?}");
        }
    }
    if let MoveShape::Arc { centre, normal, sweep, rise, to } = &step.shape {
        let arm = start - centre;
        let (sin, cos) = sweep.sin_cos();
        let end = centre + arm * cos + normal.cross(&arm) * sin + normal.into_inner() * *rise;
        let size = centre.norm() + start.norm() + to.norm() + 1.0;
        assert!((end - to).norm() < 1e-8 * size && sweep.abs() > 0.0, "seed {seed}: {step:?} ends in {end}");
    }
}

#[test]
fn hostile_texts_are_survived() {
    let read = read_hostile_texts(0, 10_000);
    assert!((500..9500).contains(&read), "{read} texts were read");
}

#[test]
#[ignore = "takes a minute"]
fn a_million_hostile_texts_are_survived() {
    read_hostile_texts(1_000_000, 1_000_000);
}

/// A program of many lines that is made while it is read: one line in `every` moves.
struct Endless {
    line: u64,
    lines: u64,
    every: u64,
    present: Vec<u8>,
}

impl Read for Endless {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.present.is_empty() && self.line < self.lines {
            let x = (self.line / self.every) % 1000;
            self.present = format!("N{} G1 X{x}.5 Y[2*{x}] F900 (line)\n", self.line % 100_000).into_bytes();
            self.line += 1;
        }
        let count = self.present.len().min(buffer.len());
        buffer[..count].copy_from_slice(&self.present[..count]);
        self.present.drain(..count);
        Ok(count)
    }
}

#[test]
fn a_million_lines_are_read_one_at_a_time() {
    let stream = Endless { line: 0, lines: 1_000_000, every: 5000, present: Vec::new() };
    let reader = BufReader::with_capacity(4096, stream);
    let program = GcodeProgram::from_reader(reader, Path::new("long.ngc"), &GcodeOptions::default()).expect("is read");
    assert_eq!(program.lines, 1_000_000);
    assert_eq!(program.moves.len(), 200);
    assert!(program.markers.is_empty());
    assert_eq!(program.moves[199].line, 995_001);
    assert!((program.moves[199].end() - vector![0.1995, 0.398, 0.0]).norm() < 1e-12);
}

#[test]
fn a_line_without_end_is_refused_without_being_stored() {
    let reader = BufReader::new(io::repeat(b'X'));
    let e = GcodeProgram::from_reader(reader, Path::new("endless.ngc"), &GcodeOptions::default());
    assert!(e.expect_err("too long").to_string().contains("more than 4096 bytes"));
    let reader = BufReader::new(io::repeat(b'\n').take(3_000_000));
    let e = GcodeProgram::from_reader(reader, Path::new("blank.ngc"), &GcodeOptions::default());
    assert!(e.expect_err("blank").to_string().contains("empty"));
}
