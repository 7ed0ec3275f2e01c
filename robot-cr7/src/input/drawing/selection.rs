//! The layers of a drawing that are read.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use crate::input::error::InputError;
use crate::text::clip;

/// Names of layers that are kept for a message.
const KEPT: usize = 1000;
/// Names of layers in a message.
const LISTED: usize = 20;

/// The layers that are wanted, and those that were seen.
#[derive(Debug)]
pub(super) struct Selection {
    wanted: Vec<Wanted>,
    /// As they are written, by what they are compared by.
    seen: BTreeMap<String, String>,
    any_case: bool,
}

#[derive(Debug)]
struct Wanted {
    written: String,
    /// What it is compared by.
    key: String,
    found: bool,
}

/// What names of DXF are compared by: upper and lower case are the same.
pub(super) fn folded(name: &str) -> String {
    name.to_uppercase()
}

impl Selection {
    /// All layers where `wanted` is empty. With `any_case`, upper and lower case are the same.
    pub fn new(wanted: &[String], any_case: bool) -> Self {
        let key = |name: &String| if any_case { folded(name) } else { name.clone() };
        let wanted = wanted.iter().map(|name| Wanted { written: name.clone(), key: key(name), found: false });
        Self { wanted: wanted.collect(), seen: BTreeMap::new(), any_case }
    }

    pub fn takes_all(&self) -> bool {
        self.wanted.is_empty()
    }

    /// Notes that the drawing has this layer; true where it is wanted by name.
    pub fn names(&mut self, layer: &str) -> bool {
        let key = if self.any_case { Cow::Owned(folded(layer)) } else { Cow::Borrowed(layer) };
        if self.seen.len() < KEPT && !self.seen.contains_key(&*key) {
            self.seen.insert(key.clone().into_owned(), layer.to_owned());
        }
        let mut named = false;
        for wanted in self.wanted.iter_mut().filter(|wanted| wanted.key == key) {
            (wanted.found, named) = (true, true);
        }
        named
    }

    /// Refuses layers that the drawing does not have.
    pub fn check(&self, file: &Path) -> Result<(), InputError> {
        let Some(missing) = self.wanted.iter().find(|wanted| !wanted.found) else { return Ok(()) };
        let mut there: Vec<String> =
            self.seen.values().take(LISTED).map(|name| format!("\"{}\"", clip(name, 60))).collect();
        if self.seen.len() > LISTED {
            there.push(format!("{} more", self.seen.len() - LISTED));
        }
        let there = if there.is_empty() { "none".to_owned() } else { there.join(", ") };
        Err(InputError::Value {
            file: file.to_owned(),
            line: None,
            key: "a layer of path.layers".to_owned(),
            value: format!("\"{}\", and the layers of the drawing are {there}", clip(&missing.written, 60)),
            rule: "a layer has to be one of the drawing",
            remedy: "correct its name, or remove the key to read all layers",
        })
    }
}
