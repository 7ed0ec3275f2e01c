//! Turns blocks with coordinates into moves.

use nalgebra::Vector3;

use super::arc::{ArcWords, Plane, SAME_POINT};
use super::block::Block;
use super::codes::{self, Group};
use super::expression::{LARGEST_WORD, whole};
use super::fault::{GcodeFault, Located};
use super::modal::Modal;
use super::nurbs::{NurbsBlock, spline};
use super::program::{GcodeMove, GcodeProgram, MoveKind, MoveShape};
use super::shape_words::{arc_form, cubic, quadratic, refuse_axes};

/// Rotary axes that turn by less than this, in rad, rest.
const SAME_ANGLE: f64 = 1e-9;
/// Farthest coordinate, in metres.
const FARTHEST: f64 = LARGEST_WORD / 1000.0;
/// Most turns of an arc (P).
const MOST_TURNS: f64 = 10_000.0;

/// Where the program stands.
#[derive(Debug)]
pub(super) struct Motion {
    /// Position that the program counts from, in metres.
    position: Vector3<f64>,
    /// Rotary axes, in rad.
    rotary: Vector3<f64>,
    /// True once an A, B or C word was read.
    rotary_named: bool,
    /// Where the last move ends, with its rotary axes. Moves that are left out change `position` only.
    end: (Vector3<f64>, Vector3<f64>),
    /// Which of X, Y and Z the program has given.
    named: [bool; 3],
    /// Number of moves left out, because they have no length.
    left_out: u64,
    /// Line of the first of them.
    first_left_out: Option<u64>,
    /// True once the program had a motion.
    moved: bool,
    /// True once a feed move was made.
    fed: bool,
    /// Offset of the first inner control point of a G5 that continues the last one.
    continuation: Option<Vector3<f64>>,
    open: Option<NurbsBlock>,
}

impl Motion {
    pub(super) fn new(start: Vector3<f64>) -> Self {
        Self {
            position: start,
            rotary: Vector3::zeros(),
            rotary_named: false,
            end: (start, Vector3::zeros()),
            named: [false; 3],
            left_out: 0,
            first_left_out: None,
            moved: false,
            fed: false,
            continuation: None,
            open: None,
        }
    }

    /// True once the program had a motion, even one without length.
    pub(super) fn has_moved(&self) -> bool {
        self.moved
    }

    /// True within a NURBS block.
    pub(super) fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// True where a block moves although it has no code of a motion.
    pub(super) fn continues(block: &Block) -> bool {
        block.has_any(b"xyzabcijk") || (block.has_any(b"r") && block.miscellaneous.is_empty())
    }

    /// Executes the motion of a block, if it has one.
    pub(super) fn execute(
        &mut self,
        line: u64,
        block: &mut Block,
        modal: &mut Modal,
        program: &mut GcodeProgram,
    ) -> Result<(), Located> {
        let mut codes = block.general.iter().filter(|c| codes::general(c.code) == Ok(Group::Motion)).map(|c| c.code);
        let explicit = codes.clone().find(|&c| c != 800).or(codes.next());
        if explicit.is_some() {
            modal.motion = explicit.filter(|&c| c != 800);
        }
        let needs_words = matches!(explicit, Some(20 | 30 | 50 | 51 | 52 | 53 | 62));
        if !needs_words && !Self::continues(block) {
            return Ok(());
        }
        let Some(code) = modal.motion else {
            let needs = "no motion is in force";
            return Err(block.fault(GcodeFault::Missing { needs, remedy: "write G0, G1, G2 or G3 in the block" }));
        };
        self.dispatch((line, code), block, modal, program)?;
        self.name_axes(block, modal);
        self.moved = true;
        Ok(())
    }

    /// Executes the motion `code` (in tenths).
    fn dispatch(
        &mut self,
        (line, code): (u64, u16),
        block: &mut Block,
        modal: &mut Modal,
        program: &mut GcodeProgram,
    ) -> Result<(), Located> {
        let continuation = self.continuation.take();
        match code {
            0 | 10 => self.line(line, block, modal, program, code == 10),
            20 | 30 => self.arc((line, code), block, modal, program),
            50 => {
                let ends = self.ends_of_spline(block, modal)?;
                let (points, next) = cubic(block, modal, ends, continuation)?;
                self.continuation = Some(next);
                let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
                self.spline(line, block, modal, program, (points, knots))
            }
            51 => {
                let ends = self.ends_of_spline(block, modal)?;
                let points = quadratic(block, modal, ends)?;
                self.spline(line, block, modal, program, (points, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0]))
            }
            53 => {
                let needs = "G5.3 ends a block of G5.2, and none is open";
                Err(block.code_fault(53, GcodeFault::Missing { needs, remedy: "begin with G5.2" }))
            }
            _ => self.open_nurbs((line, code), block, modal, program),
        }
    }

    fn line(
        &mut self,
        line: u64,
        block: &mut Block,
        modal: &Modal,
        program: &mut GcodeProgram,
        feed: bool,
    ) -> Result<(), Located> {
        let to = self.coordinates(block, modal)?;
        let rests = (to - self.end.0).norm() < SAME_POINT;
        let turned = self.turn(block, modal)?;
        if rests && !turned {
            if feed {
                modal.feed_kind(block, false)?;
            }
            self.first_left_out.get_or_insert(line);
            self.left_out += 1;
            self.position = to;
            return Ok(());
        }
        let kind = if feed { modal.feed_kind(block, rests)? } else { MoveKind::Rapid };
        self.push((line, block.number), kind, MoveShape::Line { to }, (modal, program));
        Ok(())
    }

    fn arc(
        &mut self,
        (line, code): (u64, u16),
        block: &mut Block,
        modal: &Modal,
        program: &mut GcodeProgram,
    ) -> Result<(), Located> {
        let form = arc_form(block, modal, self.position, code)?;
        let turns = match block.take(b'p') {
            None => 0.0,
            Some(word) => match whole(word.value) {
                Some(turns) if (1.0..=MOST_TURNS).contains(&turns) => turns - 1.0,
                _ => return Err(word.refuse("the turns of an arc are a whole number from 1 to 10000", "correct P")),
            },
        };
        let to = self.coordinates(block, modal)?;
        self.turn(block, modal)?;
        let kind = modal.feed_kind(block, false)?;
        let words = ArcWords {
            plane: modal.plane,
            start: self.position,
            to,
            form,
            clockwise: code == 20,
            turns,
            unit: modal.unit,
        };
        let shape = words.shape().map_err(|fault| block.code_fault(code, fault))?;
        self.push((line, block.number), kind, shape, (modal, program));
        Ok(())
    }

    /// Start and end of a spline of G5 or G5.1, which lies in the XY plane.
    fn ends_of_spline(&self, block: &mut Block, modal: &Modal) -> Result<(Vector3<f64>, Vector3<f64>), Located> {
        if modal.plane != Plane::Xy {
            let needs = "G5 and G5.1 need the XY plane";
            return Err(block.fault(GcodeFault::Missing { needs, remedy: "select it with G17" }));
        }
        refuse_axes(block, b"zabc", "a spline moves X and Y only")?;
        Ok((self.position, self.coordinates(block, modal)?))
    }

    fn spline(
        &mut self,
        line: u64,
        block: &Block,
        modal: &Modal,
        program: &mut GcodeProgram,
        (points, knots): (Vec<Vector3<f64>>, Vec<f64>),
    ) -> Result<(), Located> {
        let kind = modal.feed_kind(block, false)?;
        let weights = vec![1.0; points.len()];
        let shape = spline(points, weights, knots).map_err(|fault| block.fault(fault))?;
        self.push((line, block.number), kind, shape, (modal, program));
        Ok(())
    }

    fn open_nurbs(
        &mut self,
        (line, code): (u64, u16),
        block: &mut Block,
        modal: &mut Modal,
        program: &mut GcodeProgram,
    ) -> Result<(), Located> {
        let kind = modal.feed_kind(block, false)?;
        let to = self.control_point(block, modal)?;
        let nurbs = NurbsBlock::open(block, (line, kind), self.position, code == 62, to)?;
        self.open = Some(nurbs);
        self.position = to.unwrap_or(self.position);
        self.close_if(false, block, modal, program)
    }

    /// Executes a block within a NURBS block.
    pub(super) fn continue_nurbs(
        &mut self,
        block: &mut Block,
        modal: &mut Modal,
        program: &mut GcodeProgram,
    ) -> Result<(), Located> {
        let Some(mut nurbs) = self.open.take() else { return Ok(()) };
        let own = if nurbs.is_explicit() { 62 } else { 52 };
        let ends = own == 52 && block.has_code(53);
        let foreign = block.general.iter().find(|c| c.code != own && !(ends && c.code == 53));
        if let Some(foreign) = foreign.or(block.miscellaneous.first()) {
            let (rule, remedy) = if own == 52 {
                ("a block of G5.2 holds X Y Z, P and L only, and ends with G5.3", "write G5.3 before it")
            } else {
                ("a block of G6.2 ends with as many knots alone as its order P", "add the missing lines with K")
            };
            let name = block.general.iter().find(|c| *c == foreign).map_or("M".to_owned(), |c| codes::name(c.code));
            return Err(Located::new(foreign.column, name, GcodeFault::Syntax { rule, remedy }));
        }
        if !ends {
            let to = self.control_point(block, modal)?;
            nurbs.add(block, to)?;
            self.position = to.unwrap_or(self.position);
            self.name_axes(block, modal);
        }
        self.open = Some(nurbs);
        self.close_if(ends, block, modal, program)
    }

    /// Makes a move of an open NURBS block that is complete or `ends`.
    fn close_if(
        &mut self,
        ends: bool,
        block: &Block,
        modal: &mut Modal,
        program: &mut GcodeProgram,
    ) -> Result<(), Located> {
        let Some(nurbs) = self.open.take_if(|nurbs| ends || nurbs.is_complete()) else { return Ok(()) };
        let (place, kind) = ((nurbs.line, nurbs.number), nurbs.kind);
        let shape = nurbs.curve().map_err(|fault| block.fault(fault))?;
        self.push(place, kind, shape, (modal, program));
        modal.motion = None;
        Ok(())
    }

    /// Refuses an open NURBS block and tells of the moves left out, at the end of the program.
    pub(super) fn close(&self, program: &mut GcodeProgram) -> Result<(), Located> {
        if self.open.is_some() {
            let needs = "the program ends within a NURBS block";
            let remedy = "end G5.2 with G5.3, and G6.2 with its last knots";
            return Err(Located::new(1, "the end", GcodeFault::Missing { needs, remedy }));
        }
        if let Some(line) = self.first_left_out {
            let count = self.left_out;
            program.warnings.push(format!("line {line}: moves without length are left out, {count} in the program"));
        }
        Ok(())
    }

    /// The control point of a line in a NURBS block, if it has one.
    fn control_point(&self, block: &mut Block, modal: &Modal) -> Result<Option<Vector3<f64>>, Located> {
        refuse_axes(block, b"abc", "a spline moves X, Y and Z only")?;
        if !block.has_any(b"xyz") {
            return Ok(None);
        }
        if modal.incremental {
            let what = "a NURBS block in incremental coordinates";
            return Err(block.fault(GcodeFault::Unsupported { what, remedy: "write G90 and absolute coordinates" }));
        }
        self.coordinates(block, modal).map(Some)
    }

    /// Where the X, Y and Z words of a block lead to.
    fn coordinates(&self, block: &mut Block, modal: &Modal) -> Result<Vector3<f64>, Located> {
        let to = modal.target(block, b"xyz", self.position, |value| modal.unit.to_metres(value));
        if to.iter().any(|x| x.abs() > FARTHEST) {
            let value = to.amax();
            let rule = "coordinates are within 1e6 m of the origin (the value is in m)";
            return Err(block.fault(GcodeFault::Value { value, rule, remedy: "correct the increments" }));
        }
        Ok(to)
    }

    /// Turns the rotary axes. True where they leave their place of the last move.
    fn turn(&mut self, block: &mut Block, modal: &Modal) -> Result<bool, Located> {
        if block.has_any(b"abc") {
            self.rotary_named = true;
            self.rotary = modal.target(block, b"abc", self.rotary, f64::to_radians);
            if self.rotary.iter().any(|x| x.abs() > LARGEST_WORD) {
                let rule = "rotary axes stay within 1e9 rad";
                return Err(block.fault(GcodeFault::Value {
                    value: self.rotary.amax(),
                    rule,
                    remedy: "correct A, B, C",
                }));
            }
        }
        Ok((self.rotary - self.end.1).amax() >= SAME_ANGLE)
    }

    /// Notes which axes the program has given.
    fn name_axes(&mut self, block: &Block, modal: &Modal) {
        for (named, letter) in self.named.iter_mut().zip(*b"xyz") {
            *named |= !modal.incremental && block.word(letter).is_some();
        }
    }

    fn push(
        &mut self,
        (line, number): (u64, Option<u32>),
        kind: MoveKind,
        shape: MoveShape,
        (modal, program): (&Modal, &mut GcodeProgram),
    ) {
        if kind != MoveKind::Rapid && !self.fed {
            self.fed = true;
            let unknown: Vec<&str> =
                ["X", "Y", "Z"].into_iter().zip(self.named).filter(|a| !a.1).map(|a| a.0).collect();
            if !unknown.is_empty() {
                let (axes, verb) = (unknown.join(" "), if unknown.len() == 1 { "is" } else { "are" });
                let text = "the first feed move starts before";
                program.warnings.push(format!("line {line}: {text} {axes} {verb} given: the start is assumed"));
            }
        }
        let rotary = self.rotary_named.then_some(self.rotary);
        let step = GcodeMove { line, number, kind, shape, control: modal.control, rotary };
        self.position = step.end();
        self.end = (self.position, self.rotary);
        program.moves.push(step);
    }
}
