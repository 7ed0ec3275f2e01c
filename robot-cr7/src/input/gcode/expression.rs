//! Numbers, expressions and parameters.
//!
//! The grammar is that of LinuxCNC (G-code overview, "Expressions"): brackets are square, `**` binds before `* / MOD`,
//! and these before `+ -`; operators of one rank are taken from the left. A sign belongs to its value, so that `-2**2` is
//! 4. Angles of functions are in degrees.

use std::collections::HashMap;

use super::fault::{GcodeFault, Located};
use super::text::Text;

/// Largest magnitude of a word, in the unit of the program.
pub(super) const LARGEST_WORD: f64 = 1e9;
/// Deepest nesting of brackets.
const DEEPEST: usize = 32;
/// Parameters above this one belong to the machine (LinuxCNC, "Numbered Parameters").
const MOST_NUMBERED: f64 = 5000.0;
/// Most named parameters of a program.
const MOST_NAMED: usize = 5000;
/// A number that stands for a whole one may differ from it by this.
const WHOLE: f64 = 1e-6;

/// Ranks of operators, the weakest first.
const RANKS: [&[&str]; 3] = [&["+", "-"], &["*", "/", "mod"], &["**"]];

/// The whole number that `value` stands for.
pub(super) fn whole(value: f64) -> Option<f64> {
    let near = value.round();
    ((value - near).abs() <= WHOLE).then_some(near)
}

/// The name of a parameter: `#1` or `#<name>`.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Parameter {
    Numbered(u32),
    Named(String),
}

/// The parameters that a program has set.
#[derive(Debug, Default)]
pub(super) struct Parameters {
    values: HashMap<Parameter, f64>,
    named: usize,
    /// Assignments of the present block. They take effect behind it.
    pending: Vec<(Parameter, f64)>,
}

impl Parameters {
    /// Makes the assignments of the block effective.
    pub(super) fn commit(&mut self) {
        for (parameter, value) in self.pending.drain(..) {
            let named = matches!(parameter, Parameter::Named(_));
            if self.values.insert(parameter, value).is_none() && named {
                self.named += 1;
            }
        }
    }
}

/// A reader of values in a line.
pub(super) struct Cursor<'a> {
    pub(super) text: &'a Text,
    /// Index of the next byte.
    pub(super) at: usize,
    pub(super) parameters: &'a mut Parameters,
}

impl Cursor<'_> {
    /// The next byte, or 0 at the end of the line.
    pub(super) fn peek(&self) -> u8 {
        self.text.bytes().get(self.at).copied().unwrap_or(0)
    }

    /// A fault at the byte `start`, with the text up to the present place or one character.
    pub(super) fn fault(&self, start: usize, fault: GcodeFault) -> Located {
        Located::new(self.text.column(start), self.text.word(start, self.at.max(start + 1)), fault)
    }

    fn syntax(&self, start: usize, rule: &'static str, remedy: &'static str) -> Located {
        self.fault(start, GcodeFault::Syntax { rule, remedy })
    }

    fn takes(&mut self, text: &str) -> bool {
        let found = self.text.bytes()[self.at..].starts_with(text.as_bytes());
        if found {
            self.at += text.len();
        }
        found
    }

    /// The assignment that starts with the present `#`.
    pub(super) fn assignment(&mut self) -> Result<(), Located> {
        let start = self.at;
        self.at += 1;
        let parameter = self.parameter(start, 0)?;
        if !self.takes("=") {
            return Err(self.syntax(start, "a parameter stands without its word", "write #1=2, or X#1"));
        }
        let value = self.value(0)?;
        let new = matches!(&parameter, Parameter::Named(_)) && !self.parameters.values.contains_key(&parameter);
        if new && self.parameters.named + self.parameters.pending.len() >= MOST_NAMED {
            return Err(self.syntax(start, "a program has 5000 named parameters at most", "use fewer"));
        }
        self.parameters.pending.push((parameter, value));
        Ok(())
    }

    /// The value at the present place: a number, `[expression]`, `#parameter` or `function[..]`.
    pub(super) fn value(&mut self, depth: usize) -> Result<f64, Located> {
        let start = self.at;
        if depth > DEEPEST {
            return Err(self.syntax(start, "brackets are nested more than 32 deep", "divide the expression"));
        }
        let sign = match self.peek() {
            b'-' => -1.0,
            b'+' => 1.0,
            _ => 0.0,
        };
        if sign != 0.0 {
            self.at += 1;
        }
        let value = match self.peek() {
            b'0'..=b'9' | b'.' => self.number(start)?,
            b'[' => self.bracket(depth)?,
            b'#' => {
                self.at += 1;
                let parameter = self.parameter(start, depth)?;
                match self.parameters.values.get(&parameter) {
                    Some(&value) => value,
                    None => {
                        return Err(self.syntax(start, "the parameter has no value yet", "set it before it is used"));
                    }
                }
            }
            b'a'..=b'z' => self.function(depth)?,
            _ => return Err(self.syntax(start, "a number is missing", "write digits, #1 or [an expression]")),
        };
        Ok(if sign < 0.0 { -value } else { value })
    }

    fn number(&mut self, start: usize) -> Result<f64, Located> {
        let first = self.at;
        let mut digits = 0;
        let mut points = 0;
        while let b @ (b'0'..=b'9' | b'.') = self.peek() {
            if b == b'.' {
                points += 1;
            } else {
                digits += 1;
            }
            self.at += 1;
        }
        if digits == 0 {
            return Err(self.syntax(start, "the number has no digits", "write digits"));
        }
        if points > 1 {
            return Err(self.syntax(start, "the number has two decimal points", "remove one"));
        }
        let text = std::str::from_utf8(&self.text.bytes()[first..self.at]).unwrap_or_default();
        let value = text.parse().unwrap_or(f64::NAN);
        self.finite(start, value)
    }

    fn finite(&self, start: usize, value: f64) -> Result<f64, Located> {
        if value.is_finite() {
            return Ok(value);
        }
        let rule = "numbers must be finite";
        Err(self.fault(start, GcodeFault::Value { value, rule, remedy: "correct the number or its expression" }))
    }

    /// The expression in the brackets at the present place.
    fn bracket(&mut self, depth: usize) -> Result<f64, Located> {
        let start = self.at;
        if !self.takes("[") {
            return Err(self.syntax(start, "\"[\" is missing", "put the argument into square brackets"));
        }
        let value = self.operation(0, depth + 1)?;
        if !self.takes("]") {
            let place = self.at;
            let rule = "an expression goes on with + - * / ** MOD, or ends with \"]\"";
            return Err(self.syntax(place, rule, "correct the expression; comparisons are not supported"));
        }
        self.finite(start, value)
    }

    fn operation(&mut self, rank: usize, depth: usize) -> Result<f64, Located> {
        if rank == RANKS.len() {
            return self.value(depth);
        }
        let start = self.at;
        let mut left = self.operation(rank + 1, depth)?;
        while let Some(operator) = self.operator(rank) {
            let right = self.operation(rank + 1, depth)?;
            if right == 0.0 && (operator == "/" || operator == "mod") {
                return Err(self.syntax(start, "the expression divides by 0", "correct the divisor"));
            }
            let value = match operator {
                "+" => left + right,
                "-" => left - right,
                "*" => left * right,
                "/" => left / right,
                "mod" => left.rem_euclid(right),
                _ => left.powf(right),
            };
            left = self.finite(start, value)?;
        }
        Ok(left)
    }

    /// The operator of this rank at the present place. A stronger one, such as `**` before `*`, has been taken before.
    fn operator(&mut self, rank: usize) -> Option<&'static str> {
        RANKS[rank].iter().copied().find(|operator| self.takes(operator))
    }

    fn function(&mut self, depth: usize) -> Result<f64, Located> {
        let start = self.at;
        while self.peek().is_ascii_lowercase() {
            self.at += 1;
        }
        let name = self.text.bytes()[start..self.at].to_owned();
        let known = ["abs", "acos", "asin", "atan", "cos", "exp", "fix", "fup", "ln", "round", "sin", "sqrt", "tan"];
        if !known.iter().any(|k| k.as_bytes() == name) {
            let remedy = "write a number, or a function such as SIN[30] or ATAN[1]/[2]";
            return Err(self.syntax(start, "a value or a known function is expected", remedy));
        }
        let x = self.bracket(depth)?;
        let value = match name.as_slice() {
            b"abs" => x.abs(),
            b"acos" => x.acos().to_degrees(),
            b"asin" => x.asin().to_degrees(),
            b"atan" => {
                if !self.takes("/") {
                    return Err(self.syntax(start, "ATAN has two arguments", "write ATAN[y]/[x]"));
                }
                x.atan2(self.bracket(depth)?).to_degrees()
            }
            b"cos" => x.to_radians().cos(),
            b"exp" => x.exp(),
            b"fix" => x.floor(),
            b"fup" => x.ceil(),
            b"ln" if x == 0.0 => f64::NAN,
            b"ln" => x.ln(),
            b"round" => x.round(),
            b"sin" => x.to_radians().sin(),
            b"sqrt" => x.sqrt(),
            _ => x.to_radians().tan(),
        };
        if value.is_nan() {
            let rule = "the argument is outside the domain of the function";
            return Err(self.fault(start, GcodeFault::Value { value: x, rule, remedy: "correct the argument" }));
        }
        self.finite(start, value)
    }

    /// The parameter behind the `#` at `start`.
    fn parameter(&mut self, start: usize, depth: usize) -> Result<Parameter, Located> {
        if self.takes("<") {
            let name = self.at;
            while !matches!(self.peek(), b'>' | 0) {
                self.at += 1;
            }
            let name = self.text.bytes()[name..self.at].to_owned();
            if name.is_empty() || !self.takes(">") {
                return Err(self.syntax(start, "the name of the parameter has no end", "write #<name>"));
            }
            return Ok(Parameter::Named(String::from_utf8_lossy(&name).into_owned()));
        }
        let value = self.value(depth + 1)?;
        match whole(value) {
            Some(number) if (1.0..=MOST_NUMBERED).contains(&number) => Ok(Parameter::Numbered(number as u32)),
            _ => {
                let rule = "parameters have whole numbers from 1 to 5000; those above belong to a machine";
                Err(self.fault(start, GcodeFault::Value { value, rule, remedy: "use another parameter" }))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value of `expression`, where #1 is 4 and #<a b> is 2.5.
    fn evaluate(expression: &str) -> Result<f64, Located> {
        let mut text = Text::default();
        let mut parameters = Parameters::default();
        for line in ["#1=4", "#<A b>=2.5"] {
            text.scan(line.as_bytes())?;
            Cursor { text: &text, at: 0, parameters: &mut parameters }.assignment()?;
        }
        parameters.commit();
        text.scan(expression.as_bytes())?;
        let mut cursor = Cursor { text: &text, at: 0, parameters: &mut parameters };
        let value = cursor.value(0)?;
        assert_eq!(cursor.at, text.bytes().len(), "{expression} is read to its end");
        Ok(value)
    }

    #[test]
    fn expressions_have_the_ranks_of_linuxcnc() {
        let cases = [
            ("-.5", -0.5),
            ("+7.", 7.0),
            ("[1+2*3]", 7.0),
            ("[[1+2]*3]", 9.0),
            ("[2**3*2]", 16.0),
            ("[2*3**2]", 18.0),
            ("[2**3**2]", 64.0),
            ("[-2**2]", 4.0),
            ("[8/4/2]", 1.0),
            ("[10-4-3]", 3.0),
            ("[-7 mod 3]", 2.0),
            ("#1", 4.0),
            ("-#1", -4.0),
            ("##1", f64::NAN),
            ("#[2+2-3]", 4.0),
            ("#<AB>", 2.5),
            ("sin[30]", 0.5),
            ("COS[60]", 0.5),
            ("tan[45]", 1.0),
            ("asin[1]", 90.0),
            ("acos[0]", 90.0),
            ("atan[1]/[-1]", 135.0),
            ("sqrt[#1*4]", 4.0),
            ("abs[-3]", 3.0),
            ("round[-2.5]", -3.0),
            ("fix[-2.5]", -3.0),
            ("fup[-2.5]", -2.0),
            ("exp[0]", 1.0),
            ("ln[exp[2]]", 2.0),
        ];
        for (expression, expected) in cases {
            match evaluate(expression) {
                Ok(value) => {
                    assert!((value - expected).abs() < 1e-14 * expected.abs().max(1.0), "{expression}: {value}")
                }
                // #4 has no value.
                Err(e) => assert!(expected.is_nan(), "{expression}: {e:?}"),
            }
        }
    }

    #[test]
    fn bad_expressions_are_refused_at_their_column() {
        let deep = "[".repeat(40) + "1" + &"]".repeat(40);
        let cases = [
            ("", 1),
            (".", 1),
            ("1.2.3", 1),
            ("--1", 1),
            ("[1+]", 4),
            ("[1", 3),
            ("[1 eq 2]", 4),
            ("[1/0]", 2),
            ("[1 mod 0]", 2),
            ("sqrt[-1]", 1),
            ("ln[0]", 1),
            ("asin[2]", 1),
            ("atan[1]", 1),
            ("sine[1]", 1),
            ("sin 1", 5),
            ("#9", 1),
            ("#0", 1),
            ("#5001", 1),
            ("#1.5", 1),
            ("#<ab", 1),
            ("#<>", 1),
            ("[10**400]", 2),
            ("[-8**.5]", 2),
            ("exp[1000]", 1),
            (deep.as_str(), 34),
        ];
        for (expression, column) in cases {
            match evaluate(expression) {
                Ok(value) => panic!("{expression} is {value}"),
                Err(e) => assert_eq!(e.column, column, "{expression}: {e:?}"),
            }
        }
    }

    #[test]
    fn assignments_take_effect_behind_the_block() {
        let mut text = Text::default();
        let mut parameters = Parameters::default();
        text.scan(b"#1=3#1=#1").expect("text");
        let mut cursor = Cursor { text: &text, at: 0, parameters: &mut parameters };
        cursor.assignment().expect("the first is read");
        let e = cursor.assignment().expect_err("#1 has no value yet");
        assert_eq!(e.column, 8);
    }
}
