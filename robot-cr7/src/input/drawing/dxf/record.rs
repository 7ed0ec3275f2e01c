//! Records of a DXF file: an entity, a table entry or a mark of a section with its groups.

use arcfeed_geometry::GeometryError;
use nalgebra::Vector3;

use super::groups::{Group, Groups, TRUNCATED};
use crate::input::drawing::sink::{Named, Sink};
use crate::input::error::InputError;
use crate::text::clip;

/// Most groups of a record.
const MOST_GROUPS: usize = 1_000_000;
/// The code of a comment.
const COMMENT: i32 = 999;

/// A group 0 with the groups up to the next one.
#[derive(Debug, Clone)]
pub(super) struct Record<'a> {
    pub kind: &'a str,
    /// The line of its kind.
    pub line: u64,
    pub groups: Vec<Group<'a>>,
}

/// A reader of records.
#[derive(Debug, Clone, Copy)]
pub(super) struct Records<'a> {
    groups: Groups<'a>,
    /// Group 0 of the next record, where it was read already.
    ahead: Option<Group<'a>>,
}

impl<'a> Records<'a> {
    pub fn new(groups: Groups<'a>) -> Self {
        Self { groups, ahead: None }
    }

    /// Bytes behind the present place.
    pub fn left(&self) -> usize {
        self.groups.left()
    }

    /// The next record, without its comments; `None` at the end of the file.
    pub fn next(&mut self) -> Result<Option<Record<'a>>, InputError> {
        let first = match self.ahead.take() {
            Some(first) => first,
            None => match self.groups.next()? {
                Some(first) => first,
                None => return Ok(None),
            },
        };
        if first.code == COMMENT {
            return self.next_after_comment();
        }
        if first.code != 0 {
            let message = format!("group code {} where a section begins", first.code);
            return Err(self
                .groups
                .error(message, "; a DXF file begins with 0 and SECTION: save it as ASCII DXF again"));
        }
        let mut record = Record { kind: first.value, line: first.line, groups: Vec::new() };
        loop {
            let Some(group) = self.groups.next()? else {
                if matches!(record.kind, "EOF" | "ENDSEC") {
                    break;
                }
                return Err(self.groups.error(format!("the file ends within {}", clip(record.kind, 40)), TRUNCATED));
            };
            if group.code == 0 {
                self.ahead = Some(group);
                break;
            }
            if group.code == COMMENT {
                continue;
            }
            if record.groups.len() == MOST_GROUPS {
                let message = format!("{} has more than {MOST_GROUPS} groups", clip(record.kind, 40));
                return Err(self.groups.error(message, "; divide the entity"));
            }
            record.groups.push(group);
        }
        Ok(Some(record))
    }

    /// Comments may stand before the first section.
    fn next_after_comment(&mut self) -> Result<Option<Record<'a>>, InputError> {
        while let Some(group) = self.groups.next()? {
            if group.code != COMMENT {
                self.ahead = Some(group);
                return self.next();
            }
        }
        Ok(None)
    }

    /// The error of the grammar at the present line.
    pub fn error(&self, message: String, hint: &str) -> InputError {
        self.groups.error(message, hint)
    }
}

impl<'a> Record<'a> {
    /// The last value of a code.
    pub fn text(&self, code: i32) -> Option<&'a str> {
        self.groups.iter().rev().find(|group| group.code == code).map(|group| group.value)
    }

    /// The layer; "0" where the record names none.
    pub fn layer(&self) -> &'a str {
        self.text(8).unwrap_or("0")
    }

    /// What it is, with its handle.
    pub fn name(&self) -> String {
        let handle = self.groups.iter().find(|group| group.code == 5).map(|group| group.value);
        handle.map_or_else(|| self.kind.to_owned(), |handle| format!("{} (handle {})", self.kind, clip(handle, 40)))
    }

    /// A finite number of a group.
    pub fn number_of(&self, group: &Group, sink: &Sink) -> Result<f64, InputError> {
        group.value.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| {
            let key = format!("group {}", group.code);
            let named = Named { name: &self.name(), line: group.line };
            let why = ("it has to be a finite number", "correct it, or save the drawing again");
            sink.wrong(named, &key, &format!("\"{}\"", group.value), why)
        })
    }

    /// The number of a code, `default` where there is none.
    pub fn number_or(&self, code: i32, default: f64, sink: &Sink) -> Result<f64, InputError> {
        let group = self.groups.iter().rev().find(|group| group.code == code);
        group.map_or(Ok(default), |group| self.number_of(group, sink))
    }

    /// The number of a code that has to be there.
    pub fn number(&self, code: i32, sink: &Sink) -> Result<f64, InputError> {
        match self.groups.iter().rev().find(|group| group.code == code) {
            Some(group) => self.number_of(group, sink),
            None => {
                let why = ("the entity needs it", "save the drawing again");
                Err(self.wrong(sink, &format!("group {code}"), "missing", why))
            }
        }
    }

    /// The whole number of a code, 0 where there is none.
    pub fn flags(&self, code: i32, sink: &Sink) -> Result<i64, InputError> {
        let Some(group) = self.groups.iter().rev().find(|group| group.code == code) else { return Ok(0) };
        group.value.parse::<i64>().map_err(|_| {
            let why = ("it has to be a whole number", "correct it, or save the drawing again");
            let named = Named { name: &self.name(), line: group.line };
            sink.wrong(named, &format!("group {code}"), &format!("\"{}\"", group.value), why)
        })
    }

    /// The point of the codes `code`, `code + 10` and `code + 20`, of which the last may be left out.
    pub fn point(&self, code: i32, sink: &Sink) -> Result<Vector3<f64>, InputError> {
        Ok(Vector3::new(self.number(code, sink)?, self.number(code + 10, sink)?, self.number_or(code + 20, 0.0, sink)?))
    }

    /// The extrusion direction, which is +z where there is none.
    pub fn extrusion(&self, sink: &Sink) -> Result<Vector3<f64>, InputError> {
        let parts = [(210, 0.0), (220, 0.0), (230, 1.0)].map(|(code, default)| self.number_or(code, default, sink));
        let [x, y, z] = parts;
        Ok(Vector3::new(x?, y?, z?))
    }

    /// The points of the codes `code`, `code + 10` and `code + 20`, each with the line of its first number.
    pub fn points(&self, code: i32, sink: &Sink) -> Result<Vec<(u64, Vector3<f64>)>, InputError> {
        let mut points: Vec<(u64, Vector3<f64>)> = Vec::new();
        let mut complete = true;
        let missing = |line: u64| {
            let why = ("a point needs x and y", "save the drawing again");
            sink.wrong(Named { name: &self.name(), line }, "a point", "without y", why)
        };
        for group in &self.groups {
            if group.code == code {
                if let Some((line, _)) = points.last().filter(|_| !complete) {
                    return Err(missing(*line));
                }
                points.push((group.line, Vector3::new(self.number_of(group, sink)?, 0.0, 0.0)));
                complete = false;
            } else if group.code == code + 10
                && let Some((_, point)) = points.last_mut()
            {
                point.y = self.number_of(group, sink)?;
                complete = true;
            } else if group.code == code + 20
                && let Some((_, point)) = points.last_mut()
            {
                point.z = self.number_of(group, sink)?;
            }
        }
        match points.last().filter(|_| !complete) {
            Some((line, _)) => Err(missing(*line)),
            None => Ok(points),
        }
    }

    /// The error of an arc without area.
    pub fn flat(&self, sink: &Sink) -> InputError {
        let why = ("an arc needs an extent in both directions", "correct the entity, or remove it");
        self.wrong(sink, "the arc", "flat", why)
    }

    /// The error of numbers that are no curve.
    pub fn curve_error(&self, source: GeometryError, sink: &Sink) -> InputError {
        sink.curve_error(Named { name: &self.name(), line: self.line }, source)
    }

    /// The error of a value; `why` is the rule and the remedy.
    pub fn wrong(&self, sink: &Sink, key: &str, value: &str, why: (&'static str, &'static str)) -> InputError {
        sink.wrong(Named { name: &self.name(), line: self.line }, key, value, why)
    }
}
