//! The header and the layers of a DXF file.

use std::collections::BTreeMap;

use super::record::Record;
use crate::input::drawing::map::Map;
use crate::input::drawing::selection::folded;
use crate::input::drawing::sink::Sink;
use crate::input::error::InputError;
use crate::input::unit::LengthUnit;

/// Layers that are kept in mind.
const MOST_LAYERS: usize = 100_000;

/// A layer that CAD does not show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Hidden {
    Off,
    Frozen,
}

/// The layers that are not shown.
#[derive(Debug, Default)]
pub(super) struct LayerTable {
    hidden: BTreeMap<String, Hidden>,
}

impl LayerTable {
    /// Reads an entry of the table; other records are passed over.
    pub fn read(&mut self, record: &Record, sink: &mut Sink) -> Result<(), InputError> {
        let (true, Some(name)) = (record.kind == "LAYER", record.text(2)) else { return Ok(()) };
        sink.layers.names(name);
        let hidden = if record.flags(70, sink)? & 1 != 0 {
            Hidden::Frozen
        } else if record.flags(62, sink)? < 0 {
            Hidden::Off
        } else {
            return Ok(());
        };
        if self.hidden.len() < MOST_LAYERS {
            self.hidden.insert(folded(name), hidden);
        }
        Ok(())
    }

    pub fn hidden(&self, layer: &str) -> Option<Hidden> {
        self.hidden.get(&folded(layer)).copied()
    }
}

/// The map from the units of the drawing to metres: by `$INSUNITS`, else by `unit`, else millimetres with a warning.
pub(super) fn scale(header: Option<&Record>, unit: Option<LengthUnit>, sink: &mut Sink) -> Result<Map, InputError> {
    let units = header.and_then(|header| {
        let at = header.groups.iter().position(|group| group.code == 9 && group.value == "$INSUNITS")?;
        header.groups.get(at + 1).filter(|group| group.code == 70)
    });
    let number = match (header, units) {
        (Some(header), Some(group)) => {
            let code = group.value.parse::<i64>().ok();
            let Some(code) = code.filter(|code| *code == 0 || metres(*code).is_some()) else {
                let rule = "a unit is 0 (none), 1 (in), 2 (ft), 4 (mm), 5 (cm), 6 (m), 7 (km), 8 (uin), 9 (mil), 10 (yd), 13 (um), 14 (dm)";
                let why = (rule, "set the unit of the drawing in CAD, or $INSUNITS to 0 and path.csv_unit in the job");
                return Err(header.wrong(sink, "$INSUNITS", group.value, why));
            };
            code
        }
        _ => 0,
    };
    if let Some(metres) = metres(number) {
        return Ok(Map::scale(metres));
    }
    let unit = unit.unwrap_or_else(|| {
        sink.warnings.push(
            "the drawing names no unit ($INSUNITS): its numbers are read in mm; set path.csv_unit in the job for another one"
                .to_owned(),
        );
        LengthUnit::Millimetre
    });
    Ok(Map::scale(unit.to_metres(1.0)))
}

/// The length in metres of a unit of `$INSUNITS`.
fn metres(number: i64) -> Option<f64> {
    Some(match number {
        1 => 0.0254,
        2 => 0.3048,
        4 => 1e-3,
        5 => 1e-2,
        6 => 1.0,
        7 => 1e3,
        8 => 2.54e-8,
        9 => 2.54e-5,
        10 => 0.9144,
        13 => 1e-6,
        14 => 0.1,
        _ => return None,
    })
}
