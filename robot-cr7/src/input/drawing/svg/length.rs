//! Numbers and lengths of attributes.

use arcfeed_geometry::GeometryError;
use nalgebra::Vector3;
use roxmltree::Node;
use svgtypes::{Length, LengthUnit, NumberListParser};

use crate::input::drawing::piece::Piece;
use crate::input::drawing::sink::{Named, Sink};
use crate::input::error::InputError;

/// Most numbers of a list.
const MOST_NUMBERS: usize = 2_000_000;

/// An element with what messages about it need.
#[derive(Debug, Clone, Copy)]
pub(super) struct Element<'a, 'n> {
    pub node: Node<'n, 'n>,
    /// Its name and its line.
    pub named: Named<'a>,
}

/// Pixels of a length in CSS; `None` for units that depend on a font or a box.
pub(super) fn pixels(length: &Length) -> Option<f64> {
    let n = length.number;
    Some(match length.unit {
        LengthUnit::None | LengthUnit::Px => n,
        LengthUnit::In => n * 96.0,
        LengthUnit::Cm => n * 96.0 / 2.54,
        LengthUnit::Mm => n * 96.0 / 25.4,
        LengthUnit::Pt => n * 96.0 / 72.0,
        LengthUnit::Pc => n * 16.0,
        LengthUnit::Em | LengthUnit::Ex | LengthUnit::Percent => return None,
    })
}

impl Element<'_, '_> {
    /// A length in user units; `None` where the attribute is missing or `auto`.
    pub fn length(&self, attribute: &str, sink: &Sink) -> Result<Option<f64>, InputError> {
        let Some(text) = self.node.attribute(attribute).filter(|text| text.trim() != "auto") else { return Ok(None) };
        let length = text.trim().parse::<Length>().ok().and_then(|length| pixels(&length));
        match length.filter(|v| v.is_finite()) {
            Some(v) => Ok(Some(v)),
            None => {
                let rule = "it has to be a number, or a length in px, mm, cm, in, pt or pc";
                Err(self.wrong(sink, attribute, text, (rule, "correct it")))
            }
        }
    }

    /// The same, 0 where it is missing.
    pub fn length_or_zero(&self, attribute: &str, sink: &Sink) -> Result<f64, InputError> {
        Ok(self.length(attribute, sink)?.unwrap_or(0.0))
    }

    /// A length that is not below 0.
    pub fn size(&self, attribute: &str, sink: &Sink) -> Result<Option<f64>, InputError> {
        match self.length(attribute, sink)? {
            Some(v) if v < 0.0 => {
                Err(self.wrong(sink, attribute, &v.to_string(), ("it may not be below 0", "correct it")))
            }
            size => Ok(size),
        }
    }

    /// Finite numbers.
    pub fn numbers(&self, attribute: &str, sink: &Sink) -> Result<Vec<f64>, InputError> {
        let text = self.node.attribute(attribute).unwrap_or("");
        let numbers: Result<Vec<f64>, _> = NumberListParser::from(text).take(MOST_NUMBERS + 1).collect();
        match numbers.map(|numbers| (numbers.iter().all(|v| v.is_finite()), numbers)) {
            Ok((_, numbers)) if numbers.len() > MOST_NUMBERS => {
                let why = ("a list has 2000000 numbers at the most", "divide the element");
                Err(sink.wrong(self.named, attribute, "longer", why))
            }
            Ok((true, numbers)) => Ok(numbers),
            _ => Err(self.wrong(sink, attribute, text, ("it has to be a list of finite numbers", "correct it"))),
        }
    }

    /// The piece of an arc, which may be flat.
    pub fn arc_piece(&self, arc: Option<Result<Piece, GeometryError>>, sink: &Sink) -> Result<Piece, InputError> {
        match arc {
            Some(piece) => piece.map_err(|source| sink.curve_error(self.named, source)),
            None => {
                let why = ("an arc needs an extent in both directions", "correct the radii, or the transform");
                Err(sink.wrong(self.named, "an arc", "flat", why))
            }
        }
    }

    /// The error of an attribute; `why` is the rule and the remedy.
    pub fn wrong(&self, sink: &Sink, key: &str, value: &str, why: (&'static str, &'static str)) -> InputError {
        sink.wrong(self.named, key, &format!("\"{value}\""), why)
    }
}

/// A point of the page.
pub(super) fn plane(x: f64, y: f64) -> Vector3<f64> {
    Vector3::new(x, y, 0.0)
}
