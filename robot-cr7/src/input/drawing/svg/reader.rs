//! From the text of an SVG file to the elements of its drawing.

use roxmltree::{Document, ParsingOptions};

use super::state::State;
use super::viewport::page_map;
use super::walk::Walk;
use crate::input::drawing::sink::Sink;
use crate::input::error::{InputError, text_of};
use crate::input::unit::LengthUnit;
use crate::text::clip;

const EXPECTED: &str = "an SVG drawing";
/// Most nodes of the text: elements, texts and comments.
const MOST_NODES: u32 = 3_000_000;

/// Reads the shapes of a drawing into `sink`; `unit` is that of a drawing that names none.
///
/// Entities of the text that name other entities without end are refused by the parser, and no other file is opened.
pub(in crate::input::drawing) fn read_svg(
    bytes: &[u8],
    unit: Option<LengthUnit>,
    sink: &mut Sink,
) -> Result<(), InputError> {
    if bytes.starts_with(&[0x1f, 0x8b]) {
        return Err(InputError::Value {
            file: sink.file.to_owned(),
            line: None,
            key: "the file".to_owned(),
            value: "compressed".to_owned(),
            rule: "a drawing has to be text",
            remedy: "save it as plain SVG",
        });
    }
    let text = text_of(bytes, sink.file, EXPECTED)?;
    let options = ParsingOptions { allow_dtd: true, nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(&text, options).map_err(|e| {
        let (at, mut message) = (e.pos(), clip(&e.to_string(), 200));
        // The parser repeats the place at the end of its message.
        if let Some(end) = message.rfind(" at ") {
            message.truncate(end);
        }
        let hint = match e {
            roxmltree::Error::NodesLimitReached => "; divide the drawing",
            _ => "; an SVG file is XML: correct it at this place",
        };
        let hint = hint.to_owned();
        InputError::Syntax { file: sink.file.to_owned(), line: at.row as usize, column: at.col as usize, message, hint }
    })?;
    let root = document.root_element();
    let mut walk = Walk::new(&document, sink);
    walk.style_sheets(&document);
    let map = walk.named(root, |walk, element| {
        if element.node.tag_name().name() != "svg" {
            let why = ("the outermost element has to be svg", "save the drawing as SVG");
            return Err(walk.sink().wrong(element.named, "the outermost element", element.named.name, why));
        }
        page_map(element, unit, walk.sink())
    })?;
    let state = State { map, taken: false, layer: None, hidden: false };
    let inside = walk.named(root, |walk, element| state.inside(element, walk.sink()))?;
    match inside {
        Some(state) => walk.children(root, &state, 1),
        None => Ok(()),
    }
}
