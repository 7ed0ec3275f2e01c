//! Declarations of CSS, in the attribute `style` and in style sheets.

use std::borrow::Cow;

use roxmltree::Node;

/// Properties that move an element.
pub(super) const TRANSFORMS: [&str; 6] =
    ["transform", "transform-origin", "transform-box", "translate", "rotate", "scale"];
/// Properties that give a shape its place and its size.
pub(super) const GEOMETRY: [&str; 10] = ["x", "y", "cx", "cy", "r", "rx", "ry", "width", "height", "d"];
/// Properties that show and hide.
const SHOWING: [&str; 4] = ["display", "visibility", "clip-path", "mask"];

/// The declarations of an element on which its drawing depends.
#[derive(Debug)]
pub(super) struct Style<'n> {
    node: Node<'n, 'n>,
    declared: Vec<Declaration>,
}

#[derive(Debug)]
struct Declaration {
    name: &'static str,
    value: String,
    important: bool,
}

impl<'n> Style<'n> {
    pub fn of(node: Node<'n, 'n>) -> Self {
        let mut style = Self { node, declared: Vec::new() };
        let text = without_comments(node.attribute("style").unwrap_or(""));
        for (key, value) in text.split(';').filter_map(|part| part.split_once(':')) {
            if let Some(name) = property_named(key) {
                style.declare(name, value.trim());
            }
        }
        style
    }

    /// The last declaration of a property holds, unless one before it is important.
    fn declare(&mut self, name: &'static str, text: &str) {
        let (value, important) = match text.rsplit_once('!') {
            Some((value, word)) if word.trim().eq_ignore_ascii_case("important") => (value.trim(), true),
            _ => (text, false),
        };
        let declaration = Declaration { name, value: value.to_owned(), important };
        match self.declared.iter_mut().find(|other| other.name == name) {
            Some(other) if important || !other.important => *other = declaration,
            Some(_) => {}
            None => self.declared.push(declaration),
        }
    }

    /// The value in the attribute `style`.
    pub fn declared(&self, name: &str) -> Option<&str> {
        self.declared.iter().find(|declaration| declaration.name == name).map(|declaration| declaration.value.as_str())
    }

    /// The value in the attribute `style` or, where it is not there, in the attribute of that name.
    pub fn property(&self, name: &str) -> Option<&str> {
        self.declared(name).or_else(|| self.node.attribute(name).map(str::trim))
    }

    /// True where a property is one of these keywords, in any case.
    pub fn is(&self, name: &str, keywords: &[&str]) -> bool {
        let value = self.property(name);
        value.is_some_and(|value| keywords.iter().any(|keyword| value.eq_ignore_ascii_case(keyword)))
    }
}

/// The properties in the rules of a style sheet on which a drawing depends.
pub(super) fn properties_of_rules(sheet: &str) -> Vec<&'static str> {
    let mut found = Vec::new();
    for (key, _) in without_comments(sheet).split(['{', '}', ';']).filter_map(|part| part.split_once(':')) {
        if let Some(name) = property_named(key).filter(|name| !found.contains(name)) {
            found.push(name);
        }
    }
    found
}

fn property_named(key: &str) -> Option<&'static str> {
    let known = SHOWING.iter().chain(&TRANSFORMS).chain(&GEOMETRY);
    known.copied().find(|name| name.eq_ignore_ascii_case(key.trim()))
}

/// The text with a blank in place of each comment.
fn without_comments(text: &str) -> Cow<'_, str> {
    let Some((first, mut rest)) = text.split_once("/*") else { return Cow::Borrowed(text) };
    let mut plain = first.to_owned();
    while let Some((_, after)) = rest.split_once("*/") {
        let (next, comment) = after.split_once("/*").unwrap_or((after, ""));
        plain.push(' ');
        plain.push_str(next);
        rest = comment;
    }
    Cow::Owned(plain)
}
