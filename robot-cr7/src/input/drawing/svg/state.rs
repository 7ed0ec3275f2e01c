//! What an element takes from those around it.

use std::rc::Rc;

use roxmltree::Node;
use svgtypes::Transform;

use super::length::Element;
use crate::input::drawing::map::Map;
use crate::input::drawing::sink::Sink;
use crate::input::error::InputError;

/// The namespace of the labels that Inkscape gives to layers.
const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";

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
        if property(node, "display") == Some("none") {
            return Ok(None);
        }
        let mut state = self.clone();
        if let Some(text) = node.attribute("transform") {
            state.map = self.map.after(&transform(element, text, sink)?);
        }
        if property(node, "transform").is_some() && node.attribute("transform").is_none() {
            let why = ("a transform in a style is not read", "write it as the attribute transform");
            return Err(element.wrong(sink, "style", node.attribute("style").unwrap_or(""), why));
        }
        match property(node, "visibility") {
            Some("hidden" | "collapse") => state.hidden = true,
            Some("visible") => state.hidden = false,
            _ => {}
        }
        for name in ["clip-path", "mask"] {
            if property(node, name).is_some_and(|value| value != "none") {
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

/// A property from the attribute of its name or, before that, from `style`.
pub(super) fn property<'n>(node: Node<'n, 'n>, name: &str) -> Option<&'n str> {
    let declaration = |text: &'n str| {
        let (key, value) = text.split_once(':')?;
        (key.trim() == name).then_some(value.trim())
    };
    let style = node.attribute("style").and_then(|style| style.split(';').filter_map(declaration).next_back());
    style.or_else(|| node.attribute(name).map(str::trim))
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
