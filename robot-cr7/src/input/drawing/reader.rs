//! From the bytes of a drawing to a program.

use std::io::Read;
use std::path::Path;

use nalgebra::Vector3;

use super::contour::Contours;
use super::dxf::read_dxf;
use super::options::DrawingOptions;
use super::piece::Entity;
use super::program::program_of;
use super::selection::Selection;
use super::sink::Sink;
use super::svg::read_svg;
use crate::input::error::{InputError, unreadable};
use crate::input::gcode::GcodeProgram;

/// The largest file, in bytes.
const MOST_BYTES: usize = 128 << 20;

/// Kind of a drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DrawingKind {
    Dxf,
    Svg,
}

impl DrawingKind {
    /// The kind of a file with this extension, in lower case.
    pub fn of_extension(extension: &str) -> Option<Self> {
        match extension {
            "dxf" => Some(Self::Dxf),
            "svg" => Some(Self::Svg),
            _ => None,
        }
    }
}

/// Reads a drawing file.
pub(crate) fn read_drawing_file(
    file: &Path,
    kind: DrawingKind,
    options: &DrawingOptions,
) -> Result<GcodeProgram, InputError> {
    let mut bytes = Vec::new();
    let source = std::fs::File::open(file).map_err(|source| unreadable(file, source))?;
    source.take(MOST_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(|source| unreadable(file, source))?;
    read_bytes(&bytes, file, kind, options)
}

/// Reads a drawing from bytes in memory: DXF, or SVG where the name of `file` ends in `.svg`. The other use of `file` is in messages.
///
/// ```
/// use std::path::Path;
///
/// use robot_cr7::{DrawingOptions, read_drawing};
///
/// let svg = br#"<svg width="40mm" height="20mm" viewBox="0 0 40 20"><circle cx="10" cy="5" r="4"/></svg>"#;
/// let program = read_drawing(svg, Path::new("ring.svg"), &DrawingOptions::default())?;
/// assert_eq!(program.moves.len(), 1);
/// // The origin is the lower left corner of the page.
/// assert!((program.start.x - 0.014).abs() < 1e-15 && (program.start.y - 0.015).abs() < 1e-15);
/// # Ok::<(), robot_cr7::InputError>(())
/// ```
///
/// # Errors
/// [`InputError`], with the line and the entity: text that is neither DXF nor SVG, a number that is not finite, a shape that is no curve, a
/// unit that is not known, a layer that is not there, a drawing with nothing to follow.
pub fn read_drawing(bytes: &[u8], file: &Path, options: &DrawingOptions) -> Result<GcodeProgram, InputError> {
    let extension = file.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    let kind = extension.as_deref().and_then(DrawingKind::of_extension).unwrap_or(DrawingKind::Dxf);
    read_bytes(bytes, file, kind, options)
}

/// Reads a drawing of a known kind.
pub(crate) fn read_bytes(
    bytes: &[u8],
    file: &Path,
    kind: DrawingKind,
    options: &DrawingOptions,
) -> Result<GcodeProgram, InputError> {
    options.check(file)?;
    let wrong = |key: &str, value: String, rule, remedy| InputError::Value {
        file: file.to_owned(),
        line: None,
        key: key.to_owned(),
        value,
        rule,
        remedy,
    };
    if bytes.len() > MOST_BYTES {
        let value = format!("more than {} MB", MOST_BYTES >> 20);
        return Err(wrong("the size of the file", value, "a drawing has 128 MB at the most", "divide the drawing"));
    }
    let mut sink = Sink::new(file, Selection::new(&options.layers, kind == DrawingKind::Dxf), options.most_pieces);
    match kind {
        DrawingKind::Dxf => read_dxf(bytes, options.unit, &mut sink)?,
        DrawingKind::Svg => read_svg(bytes, options.unit, &mut sink)?,
    }
    sink.layers.check(file)?;
    let Sink { omitted, mut warnings, entities, .. } = sink;
    let omitted = omitted.warnings();
    warnings.extend(omitted.iter().cloned());
    warnings.extend(size_warning(&entities));
    let contours = Contours::of(entities).map_err(|(line, source)| InputError::Curve {
        file: file.to_owned(),
        key: format!("line {line}"),
        source,
    })?;
    if let Some((count, first)) = contours.skipped {
        warnings.push(format!("{count} pieces shorter than 1e-9 m are left out, the first at line {first}"));
    }
    let lines = 1 + bytes.iter().filter(|&&b| b == b'\n').count() as u64;
    program_of(file, contours, options, lines, warnings).ok_or_else(|| {
        let value = match omitted.as_slice() {
            [] => "without a line, an arc or a curve".to_owned(),
            some => format!("without a line, an arc or a curve ({})", some.join("; ")),
        };
        let rule = "a path needs one on the layers that are read";
        wrong("the drawing", value, rule, "draw it, turn text into paths, or name other layers in path.layers")
    })
}

/// A size that an arm of this class cannot mean: a likely slip of the unit.
fn size_warning(entities: &[Entity]) -> Option<String> {
    let ends = || entities.iter().flat_map(|entity| &entity.pieces).flat_map(|piece| [piece.start, piece.end]);
    let low = ends().fold(Vector3::repeat(f64::INFINITY), |a, p| a.inf(&p));
    let high = ends().fold(Vector3::repeat(f64::NEG_INFINITY), |a, p| a.sup(&p));
    let size = (high - low).norm();
    let wide = size > 5.0 && size.is_finite();
    (wide || (size > 0.0 && size < 1e-4)).then(|| format!("the drawing is {size:e} m wide: check its unit"))
}
