//! Reads programs from files, line by line.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use super::block::Block;
use super::expression::Parameters;
use super::fault::Located;
use super::interpreter::Interpreter;
use super::program::{GcodeOptions, GcodeProgram};
use super::text::{Lines, Text};
use crate::input::error::{InputError, unreadable};

const EXPECTED: &str = "a G-code program such as data/gcode/square.ngc";

impl GcodeProgram {
    /// Reads a program from a file.
    ///
    /// # Errors
    /// Fails when the file cannot be read or is empty, and at the first line that is not understood
    /// ([`InputError::Gcode`]).
    pub fn read(file: &Path, options: &GcodeOptions) -> Result<Self, InputError> {
        let reader = File::open(file).map_err(|source| unreadable(file, source))?;
        Self::from_reader(BufReader::new(reader), file, options)
    }

    /// Reads a program from memory. `file` is its name in messages.
    ///
    /// # Errors
    /// As [`GcodeProgram::read`].
    pub fn from_bytes(bytes: &[u8], file: &Path, options: &GcodeOptions) -> Result<Self, InputError> {
        Self::from_reader(bytes, file, options)
    }

    /// Reads a program from a stream, one line at a time. `file` is its name in messages.
    ///
    /// # Errors
    /// As [`GcodeProgram::read`].
    pub fn from_reader(reader: impl BufRead, file: &Path, options: &GcodeOptions) -> Result<Self, InputError> {
        let mut lines = Lines::new(reader);
        let mut interpreter = Interpreter::new(options, file.to_owned());
        let (mut text, mut block, mut parameters) = (Text::default(), Block::default(), Parameters::default());
        let mut blank = true;
        let mut percent = false;
        while let Some(line) = lines.next().map_err(|source| unreadable(file, source))? {
            let scanned = line.and_then(|line| text.scan(line));
            let number = lines.number;
            scanned.map_err(|e| at(file, number, e))?;
            if text.bytes() == b"%" {
                // The first % may only stand before everything else. Any other one ends the program.
                if percent || !blank {
                    break;
                }
                percent = true;
                continue;
            }
            blank &= text.bytes().is_empty() && text.messages.is_empty();
            if text.deleted && options.block_delete {
                continue;
            }
            interpreter.messages(number, &mut text.messages);
            let ended = block.read(&text, &mut parameters).and_then(|()| interpreter.execute(number, &mut block));
            parameters.commit();
            if ended.map_err(|e| at(file, number, e))? {
                break;
            }
        }
        if blank {
            return Err(InputError::Empty { file: file.to_owned(), expected: EXPECTED });
        }
        let number = lines.number;
        interpreter.program(number).map_err(|e| at(file, number, e))
    }
}

fn at(file: &Path, line: u64, located: Located) -> InputError {
    let Located { column, word, fault } = located;
    InputError::Gcode { file: file.to_owned(), line, column, word, fault: Box::new(fault) }
}
