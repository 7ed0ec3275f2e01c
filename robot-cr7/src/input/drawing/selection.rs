//! The layers of a drawing that are read.

use std::collections::BTreeSet;
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
    wanted: Vec<(String, bool)>,
    seen: BTreeSet<String>,
}

impl Selection {
    /// All layers where `wanted` is empty.
    pub fn new(wanted: &[String]) -> Self {
        Self { wanted: wanted.iter().map(|name| (name.clone(), false)).collect(), seen: BTreeSet::new() }
    }

    pub fn takes_all(&self) -> bool {
        self.wanted.is_empty()
    }

    /// Notes that the drawing has this layer; true where it is wanted by name.
    pub fn names(&mut self, layer: &str) -> bool {
        if self.seen.len() < KEPT && !self.seen.contains(layer) {
            self.seen.insert(layer.to_owned());
        }
        let wanted = self.wanted.iter_mut().find(|(name, _)| name == layer);
        wanted.map(|(_, found)| *found = true).is_some()
    }

    /// Refuses layers that the drawing does not have.
    pub fn check(&self, file: &Path) -> Result<(), InputError> {
        let Some((missing, _)) = self.wanted.iter().find(|(_, found)| !found) else { return Ok(()) };
        let mut there: Vec<String> =
            self.seen.iter().take(LISTED).map(|name| format!("\"{}\"", clip(name, 60))).collect();
        if self.seen.len() > LISTED {
            there.push(format!("{} more", self.seen.len() - LISTED));
        }
        let there = if there.is_empty() { "none".to_owned() } else { there.join(", ") };
        Err(InputError::Value {
            file: file.to_owned(),
            line: None,
            key: "a layer of path.layers".to_owned(),
            value: format!("\"{}\", and the layers of the drawing are {there}", clip(missing, 60)),
            rule: "a layer has to be one of the drawing",
            remedy: "correct its name, or remove the key to read all layers",
        })
    }
}
