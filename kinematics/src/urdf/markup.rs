//! The markup of a file: opening and closing tags in their order, with attributes as text and
//! numbers.

use crate::error::KinematicsError;
use quick_xml::{
    Reader,
    events::{BytesStart, Event},
};

/// Deepest nesting of elements; a URDF's are six deep at most.
const MAX_NESTING: usize = 100;
/// The most attributes of an element.
const MAX_ATTRIBUTES: usize = 100;
/// Greatest length of a name or another text in an attribute, bytes.
const MAX_TEXT: usize = 1000;
/// Greatest length of a file, bytes: a hundred times the largest arm with all its meshes' tags.
const MAX_FILE: usize = 1 << 26;

pub(super) fn unreadable(reason: String) -> KinematicsError {
    KinematicsError::Unreadable { format: "URDF", reason }
}

/// An element opens or closes; one without content does both in turn.
pub(super) enum Tag<'a> {
    Open(Attributes<'a>),
    Close,
}

/// The tags of a text.
pub(super) struct Markup<'a> {
    text: &'a str,
    reader: Reader<&'a [u8]>,
    depth: usize,
}

impl<'a> Markup<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut reader = Reader::from_str(text);
        let config = reader.config_mut();
        config.expand_empty_elements = true;
        config.allow_dangling_amp = true;
        Self { text, reader, depth: 0 }
    }

    /// The error at the place that was read last.
    pub(super) fn refused(&self, reason: &str) -> KinematicsError {
        self.refused_at(self.reader.buffer_position(), reason)
    }

    fn refused_at(&self, place: u64, reason: &str) -> KinematicsError {
        let end = usize::try_from(place).map_or(self.text.len(), |place| place.min(self.text.len()));
        let line = 1 + self.text.as_bytes()[..end].iter().filter(|byte| **byte == b'\n').count();
        unreadable(format!("line {line}: {reason}"))
    }

    /// The next tag; none at the end of the text.
    pub(super) fn next(&mut self) -> Result<Option<Tag<'a>>, KinematicsError> {
        if self.text.len() > MAX_FILE {
            return Err(unreadable(format!("it has {} bytes, more than {MAX_FILE}", self.text.len())));
        }
        loop {
            let event = match self.reader.read_event() {
                Ok(event) => event,
                Err(error) => return Err(self.refused_at(self.reader.error_position(), &error.to_string())),
            };
            let is_text = match event {
                Event::Start(element) => {
                    self.depth += 1;
                    if self.depth > MAX_NESTING {
                        return Err(self.refused(&format!("elements are nested more than {MAX_NESTING} deep")));
                    }
                    return Ok(Some(Tag::Open(Attributes { element })));
                }
                Event::End(_) => {
                    self.depth = self.depth.saturating_sub(1);
                    return Ok(Some(Tag::Close));
                }
                Event::Eof if self.depth == 0 => return Ok(None),
                Event::Eof => return Err(self.refused("the file ends inside an element")),
                Event::Text(text) => !text.iter().all(u8::is_ascii_whitespace),
                Event::CData(_) | Event::GeneralRef(_) => true,
                _ => false,
            };
            if is_text && self.depth == 0 {
                return Err(self.refused("there is text outside the <robot> element"));
            }
        }
    }
}

/// An opening tag.
pub(super) struct Attributes<'a> {
    element: BytesStart<'a>,
}

impl Attributes<'_> {
    /// The name with its prefix; empty if it is no text.
    pub(super) fn name(&self) -> &str {
        std::str::from_utf8(self.element.name().into_inner()).unwrap_or_default()
    }

    /// The text of an attribute, if it is there.
    pub(super) fn get(&self, name: &str) -> Result<Option<String>, String> {
        let wrong = |reason: String| format!("<{}>: {reason}", self.name());
        let mut found = None;
        for (count, attribute) in self.element.attributes().with_checks(false).enumerate() {
            if count >= MAX_ATTRIBUTES {
                return Err(wrong(format!("there are more than {MAX_ATTRIBUTES} attributes")));
            }
            let attribute = attribute.map_err(|error| wrong(error.to_string()))?;
            if attribute.key.into_inner() != name.as_bytes() {
                continue;
            }
            if found.is_some() {
                return Err(wrong(format!("there are two attributes {name}")));
            }
            if attribute.value.len() > MAX_TEXT {
                return Err(wrong(too_long(name)));
            }
            let value = attribute.decode_and_unescape_value(self.element.decoder());
            let value = value.map_err(|error| wrong(format!("{name}: {error}")))?;
            found = Some(usable(name, &value).map_err(wrong)?.to_owned());
        }
        Ok(found)
    }

    /// The text of an attribute that must be there.
    pub(super) fn need(&self, name: &str) -> Result<String, String> {
        match self.get(name)? {
            Some(text) if !text.is_empty() => Ok(text),
            _ => Err(self.without(name)),
        }
    }

    /// The words for an attribute that is not there.
    pub(super) fn without(&self, name: &str) -> String {
        format!("<{}> has no {name}", self.name())
    }

    /// A number, if it is there.
    pub(super) fn number(&self, name: &str) -> Result<Option<f64>, String> {
        Ok(self.vector::<1>(name)?.map(|[value]| value))
    }

    /// `K` numbers with blanks between them, if they are there.
    pub(super) fn vector<const K: usize>(&self, name: &str) -> Result<Option<[f64; K]>, String> {
        let wrong = |reason: String| format!("<{}>: {reason}", self.name());
        self.get(name)?.map(|text| numbers(name, &text).map_err(wrong)).transpose()
    }
}

fn too_long(name: &str) -> String {
    format!("{name} is longer than {MAX_TEXT} bytes")
}

/// The text of the attribute `name`, refused where it is no text for an error.
pub(super) fn usable<'t>(name: &str, text: &'t str) -> Result<&'t str, String> {
    if text.len() > MAX_TEXT {
        return Err(too_long(name));
    }
    if text.chars().any(|c| c.is_control() && !c.is_ascii_whitespace()) {
        return Err(format!("{name} holds a control character"));
    }
    Ok(text)
}

/// `K` numbers with blanks between them, as the attribute `name` holds them.
pub(super) fn numbers<const K: usize>(name: &str, text: &str) -> Result<[f64; K], String> {
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(|part| part.parse().ok()).collect();
    numbers.and_then(|numbers| <[f64; K]>::try_from(numbers).ok()).ok_or_else(|| {
        let rule = if K == 1 { "a number".to_owned() } else { format!("{K} numbers") };
        let remedy = if text.contains("${") { " (run xacro on the file and give its output)" } else { "" };
        format!("{name} is \"{text}\", it must be {rule}{remedy}")
    })
}
