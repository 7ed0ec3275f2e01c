//! The elements of a drawing, in their order.

use std::collections::HashMap;

use roxmltree::{Document, Node};

use super::length::{Element, plane};
use super::shapes::pieces_of;
use super::state::State;
use super::style::properties_of_rules;
use crate::input::drawing::map::Map;
use crate::input::drawing::piece::Entity;
use crate::input::drawing::sink::{Named, Sink};
use crate::input::error::InputError;
use crate::text::clip;

const SVG: &str = "http://www.w3.org/2000/svg";
const XLINK: &str = "http://www.w3.org/1999/xlink";
/// How deep groups may lie in one another.
const DEEPEST: u32 = 200;
/// Most elements that are read, those that `use` shows as often as they are shown.
const MOST_ELEMENTS: u64 = 1_000_000;
/// Bytes that a node or an attribute counts beside those of its value: few enough that no file counts too much without copies.
const NODE_BYTES: u64 = 8;

/// Elements that are not drawn where they stand, and those that say nothing of shapes.
const UNDRAWN: [&str; 25] = [
    "defs",
    "symbol",
    "clipPath",
    "mask",
    "marker",
    "pattern",
    "linearGradient",
    "radialGradient",
    "filter",
    "metadata",
    "title",
    "desc",
    "script",
    "style",
    "view",
    "cursor",
    "font",
    "font-face",
    "color-profile",
    "animate",
    "animateMotion",
    "animateTransform",
    "animateColor",
    "set",
    "solidColor",
];

/// A walk over the elements of a drawing.
pub(super) struct Walk<'n, 's, 'f> {
    ids: HashMap<&'n str, Node<'n, 'n>>,
    /// Offsets of the ends of lines.
    line_ends: Vec<usize>,
    sink: &'s mut Sink<'f>,
    read: u64,
}

/// What an element is in messages.
fn name_of(node: Node) -> String {
    let tag = clip(node.tag_name().name(), 40);
    node.attribute("id").map_or_else(|| tag.clone(), |id| format!("{tag} \"{}\"", clip(id, 40)))
}

impl<'n, 's, 'f> Walk<'n, 's, 'f> {
    pub fn new(document: &'n Document<'n>, sink: &'s mut Sink<'f>) -> Self {
        let mut ids = HashMap::new();
        for node in document.descendants() {
            if let Some(id) = node.attribute("id") {
                ids.entry(id).or_insert(node);
            }
        }
        let ends = document.input_text().bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Self { ids, line_ends: ends.map(|(at, _)| at).collect(), sink, read: 0 }
    }

    /// Runs `f` on an element with its name and line.
    pub fn named<T>(&mut self, node: Node<'n, 'n>, f: impl FnOnce(&mut Self, &Element<'_, 'n>) -> T) -> T {
        let name = name_of(node);
        let line = self.line_of(node);
        f(self, &Element { node, named: Named { name: &name, line } })
    }

    pub fn sink(&mut self) -> &mut Sink<'f> {
        self.sink
    }

    fn line_of(&self, node: Node) -> u64 {
        1 + self.line_ends.partition_point(|&end| end < node.range().start) as u64
    }

    /// Reads the elements in a node.
    pub fn children(&mut self, node: Node<'n, 'n>, state: &State, depth: u32) -> Result<(), InputError> {
        for child in node.children() {
            self.count_bytes(child)?;
            if child.is_element() {
                self.element(child, state, depth)?;
            }
        }
        Ok(())
    }

    /// Counts what is read of a node: elements that `use` shows are read again.
    fn count_bytes(&mut self, node: Node<'n, 'n>) -> Result<(), InputError> {
        let attributes: u64 = node.attributes().map(|attribute| NODE_BYTES + attribute.value().len() as u64).sum();
        if self.sink.reads(NODE_BYTES + attributes) {
            return Ok(());
        }
        let element = if node.is_element() { node } else { node.parent_element().unwrap_or(node) };
        let (name, line) = (name_of(element), self.line_of(element));
        Err(self.sink.too_much(Named { name: &name, line }))
    }

    fn element(&mut self, node: Node<'n, 'n>, around: &State, depth: u32) -> Result<(), InputError> {
        let tag = node.tag_name();
        // Elements of editors, such as the settings of Inkscape.
        let foreign = tag.namespace().is_some_and(|space| space != SVG);
        if foreign || UNDRAWN.contains(&tag.name()) {
            return Ok(());
        }
        self.read += 1;
        self.named(node, |walk, element| {
            walk.check_counts(element, depth)?;
            let Some(state) = around.inside(element, walk.sink)? else { return Ok(()) };
            match tag.name() {
                "g" | "a" => walk.children(node, &state, depth + 1),
                "switch" => walk.switch(node, &state, depth),
                "use" => walk.shown(element, &state, depth),
                "svg" => {
                    let why = ("a page within the page is not read", "draw its elements as a group (g)");
                    Err(walk.sink.wrong(element.named, "the element", "svg within svg", why))
                }
                _ => walk.shape(element, &state),
            }
        })
    }

    fn check_counts(&self, element: &Element, depth: u32) -> Result<(), InputError> {
        let (value, why) = if depth > DEEPEST {
            let remedy = "ungroup elements, or remove a use that shows itself";
            ("more than 200".to_owned(), ("elements may lie 200 deep in one another", remedy))
        } else if self.read > MOST_ELEMENTS {
            let remedy = "divide the drawing, or show fewer elements by use";
            (format!("more than {MOST_ELEMENTS}"), ("a drawing may not have more elements", remedy))
        } else {
            return Ok(());
        };
        let key = if depth > DEEPEST { "the depth" } else { "elements of the drawing" };
        Err(self.sink.wrong(element.named, key, &value, why))
    }

    /// The rules of style sheets are not applied; those that would matter are named.
    pub fn style_sheets(&mut self, document: &'n Document<'n>) {
        for sheet in document.descendants().filter(|node| node.is_element() && node.tag_name().name() == "style") {
            let text: String = sheet.children().filter(Node::is_text).filter_map(|part| part.text()).collect();
            let line = self.line_of(sheet);
            for name in properties_of_rules(&text) {
                let what = format!("rule for \"{name}\" in <style>, which is not applied");
                self.sink.omitted.note(&what, None, line);
            }
        }
    }

    /// The first child that every reader draws.
    fn switch(&mut self, node: Node<'n, 'n>, state: &State, depth: u32) -> Result<(), InputError> {
        let mut conditional = Vec::new();
        for child in node.children() {
            self.count_bytes(child)?;
            if child.is_element() && unconditional(child) {
                return self.element(child, state, depth + 1);
            }
            conditional.extend(child.is_element().then_some(child));
        }
        if !state.hidden && (state.taken || self.sink.layers.takes_all()) {
            for child in conditional {
                let line = self.line_of(child);
                self.sink.omitted.note("conditional child of <switch>", state.layer.as_deref(), line);
            }
        }
        Ok(())
    }

    /// What a `use` shows.
    fn shown(&mut self, element: &Element<'_, 'n>, state: &State, depth: u32) -> Result<(), InputError> {
        let link = element.node.attribute("href").or_else(|| element.node.attribute((XLINK, "href"))).unwrap_or("");
        let Some(id) = link.trim().strip_prefix('#') else {
            self.sink.omitted.note("use of another file", state.layer.as_deref(), element.named.line);
            return Ok(());
        };
        let Some(target) = self.ids.get(id).copied() else {
            let why = ("an element with that id has to be in the file", "correct the id, or remove the use");
            return Err(element.wrong(self.sink, "href", link, why));
        };
        let [x, y] = ["x", "y"].map(|name| element.length_or_zero(name, self.sink));
        let state = State { map: state.map.after(&Map::translation(plane(x?, y?))), ..state.clone() };
        match target.tag_name().name() {
            "symbol" if target.attribute("viewBox").is_some() => {
                let why = ("a symbol with a viewBox is not read", "draw its elements as a group (g)");
                Err(element.wrong(self.sink, "href", link, why))
            }
            "symbol" => self.children(target, &state, depth + 1),
            _ => {
                self.count_bytes(target)?;
                self.element(target, &state, depth + 1)
            }
        }
    }

    fn shape(&mut self, element: &Element, state: &State) -> Result<(), InputError> {
        if state.hidden || !(state.taken || self.sink.layers.takes_all()) {
            return Ok(());
        }
        let layer = state.layer.as_deref();
        match pieces_of(element, &state.map, self.sink)? {
            None => self.sink.omitted.note(&format!("<{}>", element.node.tag_name().name()), layer, element.named.line),
            Some(pieces) if pieces.is_empty() => {
                let what = format!("<{}> without a size", element.node.tag_name().name());
                self.sink.omitted.note(&what, layer, element.named.line);
            }
            Some(pieces) => {
                let (name, line) = (element.named.name.to_owned(), element.named.line);
                self.sink.add(Entity { name, layer: state.layer.clone(), line, pieces })?;
            }
        }
        Ok(())
    }
}

/// A child of `switch` that is drawn by every reader.
fn unconditional(node: Node) -> bool {
    ["requiredExtensions", "requiredFeatures", "systemLanguage"].iter().all(|name| !node.has_attribute(*name))
}
