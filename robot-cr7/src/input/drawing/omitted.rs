//! What a drawing holds and a motion does not.

use std::collections::BTreeMap;

use crate::text::clip;

/// Kinds that are named.
const NAMED: usize = 40;
/// Kinds that are counted apart.
const COUNTED: usize = 1000;

/// Entities that are left out, by kind and layer.
#[derive(Debug, Default)]
pub(super) struct Omitted {
    counts: BTreeMap<(String, Option<String>), Count>,
    others: u64,
}

#[derive(Debug)]
struct Count {
    count: u64,
    line: u64,
}

impl Omitted {
    /// Counts one entity, with its line in the file.
    pub fn note(&mut self, kind: &str, layer: Option<&str>, line: u64) {
        let key = (clip(kind, 60), layer.map(|layer| clip(layer, 60)));
        if let Some(count) = self.counts.get_mut(&key) {
            count.count += 1;
        } else if self.counts.len() < COUNTED {
            self.counts.insert(key, Count { count: 1, line });
        } else {
            self.others += 1;
        }
    }

    /// One warning for each kind and layer.
    pub fn warnings(&self) -> Vec<String> {
        let words = |((kind, layer), Count { count, line }): (&(String, Option<String>), &Count)| {
            let layer = layer.as_ref().map(|layer| format!(" on layer \"{layer}\"")).unwrap_or_default();
            format!("{count} x {kind}{layer}, first at line {line}: not a part of the motion")
        };
        let mut warnings: Vec<String> = self.counts.iter().take(NAMED).map(words).collect();
        let rest: u64 = self.counts.values().skip(NAMED).map(|count| count.count).sum::<u64>() + self.others;
        if rest > 0 {
            warnings.push(format!("{rest} more entities of other kinds or layers are not a part of the motion"));
        }
        warnings
    }
}
