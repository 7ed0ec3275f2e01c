//! What an element takes from those around it.

use std::rc::Rc;

use roxmltree::Node;
use svgtypes::Transform;

use super::length::Element;
use super::style::{GEOMETRY, Style, TRANSFORMS};
use crate::input::drawing::map::Map;
use crate::input::drawing::sink::Sink;
use crate::input::error::InputError;

/// The namespace of the labels that Inkscape gives to layers.
const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";

/// Elements with a place and a size that a style can give.
const SIZED: [&str; 8] = ["path", "rect", "circle", "ellipse", "line", "polyline", "polygon", "use"];

/// What an element takes from those around it.
#[derive(Debug, Clone)]
pub(super) struct State {
    /// Into metres.
    pub map: Map,
    /// One of the layers that it is in is read.
    pub taken: bool,
    /// The innermost layer.
    pub layer: Option<Rc<str>>,
    pub hidden: bool,
}

impl State {
    /// The state inside an element. `None` where it is not drawn (`display: none`).
    pub fn inside(&self, element: &Element, sink: &mut Sink) -> Result<Option<Self>, InputError> {
        let node = element.node;
        let style = Style::of(node);
        if style.is("display", &["none"]) {
            return Ok(None);
        }
        refuse_style(element, &style, sink)?;
        let mut state = self.clone();
        if let Some(text) = node.attribute("transform") {
            state.map = self.map.after(&transform(element, text, sink)?);
        }
        if style.is("visibility", &["hidden", "collapse"]) {
            state.hidden = true;
        } else if style.is("visibility", &["visible"]) {
            state.hidden = false;
        }
        for name in ["clip-path", "mask"] {
            if style.property(name).is_some() && !style.is(name, &["none"]) {
                sink.omitted.note(
                    &format!("{name} of <{}>, which is drawn as a whole", clipped(node)),
                    None,
                    element.named.line,
                );
            }
        }
        if node.tag_name().name() == "g" {
            state.enter_layer(node, sink);
        }
        Ok(Some(state))
    }

    /// A group is a layer by its label in Inkscape, and by its id.
    fn enter_layer(&mut self, node: Node, sink: &mut Sink) {
        let label = node.attribute((INKSCAPE, "label"));
        for name in [label, node.attribute("id")].into_iter().flatten() {
            self.taken |= sink.layers.names(name);
        }
        if let Some(name) = label.or(node.attribute("id")) {
            self.layer = Some(name.into());
        }
    }
}

fn clipped<'n>(node: Node<'_, 'n>) -> String {
    crate::text::clip(node.tag_name().name(), 40)
}

/// Refuses what gives an element its place or its size otherwise than the attributes that are read.
fn refuse_style(element: &Element, style: &Style, sink: &Sink) -> Result<(), InputError> {
    if let Some(text) = element.node.attribute("transform-origin") {
        let why = ("a transform is about the origin of the user units", "remove it, or write transform as a matrix");
        return Err(element.wrong(sink, "transform-origin", text, why));
    }
    let moved = ("a transform in a style is not read", "write it as the attribute transform, or remove it");
    let sized = ("the place and the size in a style are not read", "write it as an attribute, or remove it");
    let drawn = SIZED.contains(&element.node.tag_name().name());
    let geometry = GEOMETRY.iter().filter(|_| drawn).map(|name| (name, sized));
    for (name, why) in TRANSFORMS.iter().map(|name| (name, moved)).chain(geometry) {
        if let Some(value) = style.declared(name) {
            return Err(element.wrong(sink, &format!("{name} in style"), value, why));
        }
    }
    Ok(())
}

fn transform(element: &Element, text: &str, sink: &Sink) -> Result<Map, InputError> {
    let parsed = text.parse::<Transform>().ok().map(|t| [t.a, t.b, t.c, t.d, t.e, t.f]);
    match parsed.filter(|numbers| numbers.iter().all(|v| v.is_finite())) {
        Some(numbers) if (numbers[0] * numbers[3] - numbers[1] * numbers[2]).abs() > 0.0 => Ok(Map::plane(numbers)),
        _ => {
            let rule = "it has to be a list of matrix, translate, scale, rotate, skewX and skewY with finite numbers that keeps areas above 0";
            Err(element.wrong(sink, "transform", text, (rule, "correct it, or remove it")))
        }
    }
}
