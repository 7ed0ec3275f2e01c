//! Errors in the files that a person hands in, each with its remedy.

use std::path::{Path, PathBuf};

use arcfeed_geometry::GeometryError;
use thiserror::Error;

use super::gcode::fault::GcodeFault;
use crate::text::shortened;

/// Everything that can be wrong with an input file (path, job or trajectory), or with writing an output file.
///
/// Every message names the file, the key or the line, the value found, the rule it breaks and the way out.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum InputError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}; {remedy}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
        /// The remedy.
        remedy: &'static str,
    },
    /// An output file cannot be written.
    #[error("{}: cannot be written: {source}; check that the folder exists, that it is writable and that the disk is not full", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// Another run writes into the folder, or a program holds its lock.
    #[error("{}: another run writes into this folder, or a program holds its lock (flock): wait for its end, or choose another folder with --out", folder.display())]
    Busy {
        /// The folder.
        folder: PathBuf,
    },
    /// A file that is read has the name of one that is to be written.
    #[error("{}: is read, and would be overwritten: choose another folder with --out", file.display())]
    Overwritten {
        /// The file.
        file: PathBuf,
    },
    /// The file is not UTF-8 text.
    #[error("{}:{line}: the line is not UTF-8 text: save the file as plain UTF-8 text", file.display())]
    NotText {
        /// The file.
        file: PathBuf,
        /// First line that is not text, from 1.
        line: usize,
    },
    /// The file holds nothing.
    #[error("{}: the file is empty, but {expected} is needed", file.display())]
    Empty {
        /// The file.
        file: PathBuf,
        /// The content that it should have, with a pointer to an example.
        expected: &'static str,
    },
    /// The extension of a path file is not a known one.
    #[error("{}: extension \"{extension}\" is not a known kind of path file: use .json (a NURBS curve), .csv (points), .ngc, .nc, .gcode, .cnc, .tap (G-code) or .dxf, .svg (a drawing)", file.display())]
    Extension {
        /// The file.
        file: PathBuf,
        /// Its extension, empty when there is none.
        extension: String,
    },
    /// The text breaks the grammar of JSON or TOML, has an unknown or a missing key, or a value of the wrong kind.
    #[error("{}:{line}:{column}: {}{hint}", file.display(), shortened(message))]
    Syntax {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The rule, as the parser words it.
        message: String,
        /// The remedy, starting with a separator; empty when the message says it already.
        hint: String,
    },
    /// No unit of length is given.
    #[error("{}: {} names no unit of length: {remedy}", file.display(), shortened(place))]
    MissingUnit {
        /// The file.
        file: PathBuf,
        /// Key or line where the unit is expected.
        place: String,
        /// The way to give one.
        remedy: &'static str,
    },
    /// The unit of length is not a known one.
    #[error("{}: {} is \"{}\", which is not a known unit of length: use \"mm\", \"cm\", \"m\" or \"in\"", file.display(), shortened(place), shortened(unit))]
    UnknownUnit {
        /// The file.
        file: PathBuf,
        /// Key or line that holds it.
        place: String,
        /// The unit found.
        unit: String,
    },
    /// The file says one unit and the caller another.
    #[error("{}: {} says \"{found}\", but \"{asked}\" was asked for: remove one of the two, or make them agree", file.display(), shortened(place))]
    UnitConflict {
        /// The file.
        file: PathBuf,
        /// Line of the header.
        place: String,
        /// Unit in the file.
        found: &'static str,
        /// Unit asked for.
        asked: &'static str,
    },
    /// A column of a CSV header has a name nobody knows.
    #[error("{}:{line}: column {column} is named \"{}\": {rule}", file.display(), shortened(name))]
    Column {
        /// The file.
        file: PathBuf,
        /// Line of the header, from 1.
        line: u64,
        /// Column, from 1.
        column: usize,
        /// The name found.
        name: String,
        /// Which names are known and what to do.
        rule: &'static str,
    },
    /// A cell of a CSV file is not a finite number.
    #[error("{}:{line}: column {column} is \"{}\", which is not a finite number: {remedy}", file.display(), shortened(cell))]
    Cell {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: u64,
        /// Column, from 1.
        column: usize,
        /// The text found.
        cell: String,
        /// The remedy.
        remedy: &'static str,
    },
    /// A row has a different number of columns.
    #[error("{}:{line}: {found} columns, but line {first_line} has {expected}: give every row the same columns ({rule})", file.display())]
    ColumnCount {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: u64,
        /// Columns found there.
        found: usize,
        /// Columns of the first row.
        expected: usize,
        /// Line of the first row.
        first_line: u64,
        /// Which columns are meant.
        rule: &'static str,
    },
    /// Two consecutive points coincide.
    #[error(
        "{}:{second_line}: the point repeats the one of line {first_line} (distance {distance_m:e} m, at least 1e-9 m is needed): remove one of the two lines",
        file.display()
    )]
    DuplicatePoints {
        /// The file.
        file: PathBuf,
        /// Line of the first of the two, from 1.
        first_line: u64,
        /// Line of the second.
        second_line: u64,
        /// Their distance in metres.
        distance_m: f64,
    },
    /// Too few points for a path.
    #[error("{}: {found} points in the file, but a path needs at least {needed}: add points", file.display())]
    TooFewPoints {
        /// The file.
        file: PathBuf,
        /// Points found.
        found: usize,
        /// Points needed.
        needed: usize,
    },
    /// A mesh of an arm cannot be drawn.
    #[cfg(feature = "html")]
    #[error("{}: {fault}", crate::text::clip(&file.to_string_lossy(), 200))]
    Mesh {
        /// The mesh as the URDF names it, or the URDF.
        file: PathBuf,
        /// What is wrong with it.
        fault: super::meshes::MeshFault,
    },
    /// A value breaks a rule.
    #[error("{}: {} is {}: {rule}; {remedy}", Place(file, *line), shortened(key), shortened(value))]
    Value {
        /// The file.
        file: PathBuf,
        /// Line, from 1, where it is known.
        line: Option<usize>,
        /// The key, such as `feed.feed_mm_s` or `weights[3]`.
        key: String,
        /// The value as it stands in the file.
        value: String,
        /// The rule it breaks.
        rule: &'static str,
        /// The remedy.
        remedy: &'static str,
    },
    /// The numbers of a path file do not make a curve.
    #[error("{}: {}: {source}", file.display(), shortened(key))]
    Curve {
        /// The file.
        file: PathBuf,
        /// The key, such as `knots[7]`, or the line.
        key: String,
        /// The rule, with indices counted from 0 and lengths in metres.
        source: GeometryError,
    },
    /// A word of a G-code program cannot be executed.
    #[error("{}:{line}:{column}: {}: {fault}", file.display(), shortened(word))]
    Gcode {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: u64,
        /// Column, from 1.
        column: usize,
        /// The word or the text found there.
        word: String,
        /// The rule and the remedy.
        fault: Box<GcodeFault>,
    },
}

/// `file` or `file:line`.
struct Place<'a>(&'a Path, Option<usize>);

impl std::fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.1 {
            Some(line) => write!(f, "{}:{line}", self.0.display()),
            None => write!(f, "{}", self.0.display()),
        }
    }
}

/// Reads a whole text file; a byte order mark at its start is dropped.
pub(crate) fn read_text(file: &Path, expected: &'static str) -> Result<String, InputError> {
    let bytes = std::fs::read(file).map_err(|source| unreadable(file, source))?;
    text_of(&bytes, file, expected)
}

/// The error of a file that cannot be read.
pub(crate) fn unreadable(file: &Path, source: std::io::Error) -> InputError {
    let remedy = match source.kind() {
        std::io::ErrorKind::NotFound => "check the name and the folder it is looked for in",
        std::io::ErrorKind::PermissionDenied => "check the permissions of the file",
        _ => "give a plain readable file",
    };
    InputError::Read { file: file.to_owned(), source, remedy }
}

/// The text of the bytes of `file`, refused when it is not UTF-8 or blank.
pub(crate) fn text_of(bytes: &[u8], file: &Path, expected: &'static str) -> Result<String, InputError> {
    let text = std::str::from_utf8(bytes).map_err(|e| InputError::NotText {
        file: file.to_owned(),
        line: 1 + bytes[..e.valid_up_to()].iter().filter(|&&b| b == b'\n').count(),
    })?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.trim().is_empty() {
        return Err(InputError::Empty { file: file.to_owned(), expected });
    }
    Ok(text.to_owned())
}

/// Line and column, both from 1, of a byte offset; offsets behind the end or inside a character are taken back.
pub(crate) fn line_column(text: &str, offset: usize) -> (usize, usize) {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    let before = &text[..offset];
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (1 + before.matches('\n').count(), 1 + before[line_start..].chars().count())
}
