//! The groups of a DXF file.

use std::path::Path;

use crate::input::error::InputError;
use crate::text::clip;

/// One group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Group<'a> {
    pub code: i32,
    /// Without blanks at its ends.
    pub value: &'a str,
    /// The line of its value.
    pub line: u64,
}

/// A reader of groups, which can be kept to read on from its place later.
#[derive(Debug, Clone, Copy)]
pub(super) struct Groups<'a> {
    file: &'a Path,
    rest: &'a str,
    line: u64,
}

impl<'a> Groups<'a> {
    pub fn new(text: &'a str, file: &'a Path) -> Self {
        Self { file, rest: text, line: 0 }
    }

    /// Bytes behind the present place.
    pub fn left(&self) -> usize {
        self.rest.len()
    }

    fn line(&mut self) -> Option<&'a str> {
        if self.rest.is_empty() {
            return None;
        }
        let (line, rest) = self.rest.split_once('\n').unwrap_or((self.rest, ""));
        self.rest = rest;
        self.line += 1;
        Some(line.trim())
    }

    /// The next group; `None` at the end of the file.
    pub fn next(&mut self) -> Result<Option<Group<'a>>, InputError> {
        let Some(code) = self.line() else { return Ok(None) };
        if code.is_empty() && self.rest.trim().is_empty() {
            return Ok(None);
        }
        let number = code.parse::<i32>();
        let Ok(code) = number else {
            let message = format!("\"{}\" is not a group code", clip(code, 40));
            return Err(
                self.error(message, "; a DXF file has a whole number here: save the drawing as ASCII DXF again")
            );
        };
        match self.line() {
            Some(value) => Ok(Some(Group { code, value, line: self.line })),
            None => Err(self.error("the file ends within a group".to_owned(), TRUNCATED)),
        }
    }

    /// The error of the grammar at the present line.
    pub fn error(&self, message: String, hint: &str) -> InputError {
        let line = usize::try_from(self.line).unwrap_or(usize::MAX);
        InputError::Syntax { file: self.file.to_owned(), line, column: 1, message, hint: hint.to_owned() }
    }
}

/// What to do about a file that ends too early.
pub(super) const TRUNCATED: &str = "; the file is cut off: save or copy it again";
