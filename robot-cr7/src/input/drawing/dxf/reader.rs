//! The sections of a DXF file, and its entities in their order.

use std::borrow::Cow;
use std::collections::HashMap;

use super::entities::pieces_of;
use super::groups::{Groups, TRUNCATED};
use super::insert::{Block, Insert};
use super::polyline::old_polyline;
use super::record::{Record, Records};
use super::tables::{Hidden, LayerTable, scale};
use crate::input::drawing::map::Map;
use crate::input::drawing::piece::{Entity, Piece};
use crate::input::drawing::selection::folded;
use crate::input::drawing::sink::{Named, Sink};
use crate::input::error::InputError;
use crate::input::unit::LengthUnit;
use crate::text::clip;

const EXPECTED: &str = "an ASCII DXF drawing";
/// How deep blocks may lie in one another.
const DEEPEST: u32 = 32;
/// Most groups that are read, those of inserted blocks as often as they are inserted.
const MOST_GROUPS: u64 = 10_000_000;
/// Most vertices of a polyline.
const MOST_VERTICES: usize = 1_000_000;

/// Reads the entities of a drawing into `sink`; `unit` is that of a drawing that names none.
pub(in crate::input::drawing) fn read_dxf(
    bytes: &[u8],
    unit: Option<LengthUnit>,
    sink: &mut Sink,
) -> Result<(), InputError> {
    let text = text_of(bytes, sink)?;
    let mut records = Records::new(Groups::new(&text, sink.file));
    let mut reader = Reader { blocks: HashMap::new(), layers: LayerTable::default(), sink, read: 0 };
    let (mut header, mut complete) = (None, false);
    while let Some(record) = records.next()? {
        let name = record.groups.iter().find(|group| group.code == 2).map(|group| group.value);
        match (record.kind, name) {
            ("SECTION", Some("HEADER")) => header = Some(record),
            ("SECTION", Some("TABLES")) => reader.tables(&mut records)?,
            ("SECTION", Some("BLOCKS")) => reader.blocks(&mut records)?,
            ("SECTION", Some("ENTITIES")) => {
                let map = scale(header.as_ref(), unit, reader.sink)?;
                let context = Context { map, layer: None, block: None, depth: 0 };
                reader.entities(&mut records, &context, "ENDSEC")?;
                complete = true;
            }
            ("SECTION", _) => while_in_section(&mut records, |_, _| Ok(()))?,
            ("EOF", _) => break,
            _ => {}
        }
    }
    if complete {
        return Ok(());
    }
    Err(records.error("the file has no section ENTITIES".to_owned(), "; save the drawing as ASCII DXF again"))
}

/// The text of the file; bytes that are not UTF-8 are read as Latin-1, which concerns names only.
fn text_of<'b>(bytes: &'b [u8], sink: &mut Sink) -> Result<Cow<'b, str>, InputError> {
    if bytes.starts_with(b"AutoCAD Binary DXF") {
        return Err(InputError::Value {
            file: sink.file.to_owned(),
            line: None,
            key: "the file".to_owned(),
            value: "binary DXF".to_owned(),
            rule: "a drawing has to be text",
            remedy: "save it as ASCII DXF",
        });
    }
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text.strip_prefix('\u{feff}').unwrap_or(text)),
        Err(e) => {
            let line = 1 + bytes[..e.valid_up_to()].iter().filter(|&&b| b == b'\n').count();
            sink.warnings.push(format!("line {line} is not UTF-8: the names in the drawing are read as Latin-1"));
            Cow::Owned(bytes.iter().map(|&b| char::from(b)).collect())
        }
    };
    if text.trim().is_empty() {
        return Err(InputError::Empty { file: sink.file.to_owned(), expected: EXPECTED });
    }
    Ok(text)
}

/// Hands on the records of a section, with those behind each.
fn while_in_section<'a>(
    records: &mut Records<'a>,
    mut take: impl FnMut(Record<'a>, &mut Records<'a>) -> Result<(), InputError>,
) -> Result<(), InputError> {
    while let Some(record) = records.next()? {
        if record.kind == "ENDSEC" {
            return Ok(());
        }
        take(record, records)?;
    }
    Err(records.error("the file ends within a section".to_owned(), TRUNCATED))
}

/// Where entities are read.
struct Context<'a> {
    /// Into metres.
    map: Map,
    /// The layer of the INSERT, which entities on the layer "0" of a block are on.
    layer: Option<&'a str>,
    /// Names the block in messages.
    block: Option<&'a str>,
    depth: u32,
}

struct Reader<'a, 's, 'f> {
    /// By what their names are compared by.
    blocks: HashMap<String, Block<'a>>,
    layers: LayerTable,
    sink: &'s mut Sink<'f>,
    read: u64,
}

impl<'a> Reader<'a, '_, '_> {
    fn tables(&mut self, records: &mut Records<'a>) -> Result<(), InputError> {
        while_in_section(records, |record, _| self.layers.read(&record, self.sink))
    }

    /// Notes where the entities of each block begin.
    fn blocks(&mut self, records: &mut Records<'a>) -> Result<(), InputError> {
        while_in_section(records, |record, records| {
            if record.kind == "BLOCK" {
                let (name, block) = Block::new(&record, *records, self.sink)?;
                self.blocks.insert(folded(name), block);
            }
            Ok(())
        })
    }

    /// Reads entities up to the record `end`.
    fn entities(&mut self, records: &mut Records<'a>, context: &Context<'a>, end: &str) -> Result<(), InputError> {
        loop {
            let left = records.left();
            let Some(record) = records.next()? else { break };
            self.count(&record, left - records.left())?;
            if record.kind == end {
                return Ok(());
            }
            match record.kind {
                "INSERT" => self.insert(&record, context)?,
                "POLYLINE" => {
                    let vertices = self.vertices(&record, records)?;
                    self.entity(&record, context, |map, sink| old_polyline(&record, &vertices, map, sink))?;
                }
                "SEQEND" => {}
                _ => self.entity(&record, context, |map, sink| pieces_of(&record, map, sink))?,
            }
        }
        Err(records.error(format!("the file ends before {end}"), TRUNCATED))
    }

    /// Reads the VERTEX records of a POLYLINE.
    fn vertices(&mut self, record: &Record, records: &mut Records<'a>) -> Result<Vec<Record<'a>>, InputError> {
        let mut vertices = Vec::new();
        let mut ahead = *records;
        while let Some(vertex) = ahead.next()?.filter(|record| record.kind == "VERTEX") {
            self.count(&vertex, records.left() - ahead.left())?;
            if vertices.len() == MOST_VERTICES {
                let why = ("a polyline has 1000000 vertices at the most", "divide the polyline");
                return Err(record.wrong(self.sink, "vertices", "more than 1000000", why));
            }
            vertices.push(vertex);
            *records = ahead;
        }
        Ok(vertices)
    }

    /// Counts what is read, with its bytes: blocks in blocks may hold more than fits into a memory.
    fn count(&mut self, record: &Record, bytes: usize) -> Result<(), InputError> {
        if !self.sink.reads(bytes as u64) {
            return Err(self.sink.too_much(Named { name: &record.name(), line: record.line }));
        }
        self.read += 1 + record.groups.len() as u64;
        if self.read <= MOST_GROUPS {
            return Ok(());
        }
        let why = ("blocks may not be inserted any more often", "insert fewer blocks, or explode them in CAD");
        Err(record.wrong(self.sink, "groups of the drawing", "more than 10000000", why))
    }

    /// Takes the pieces of an entity, where its layer is read.
    fn entity(
        &mut self,
        record: &Record<'a>,
        context: &Context<'a>,
        pieces: impl FnOnce(&Map, &Sink) -> Result<Option<Vec<Piece>>, InputError>,
    ) -> Result<(), InputError> {
        let layer = layer_of(record, context);
        let named = self.sink.layers.names(layer);
        if !named && !self.sink.layers.takes_all() {
            return Ok(());
        }
        if let Some(why) = self.unseen(record, layer, named)? {
            self.sink.omitted.note(&format!("{} {why}", record.kind), Some(layer), record.line);
            return Ok(());
        }
        match pieces(&context.map, self.sink)? {
            None => self.sink.omitted.note(record.kind, Some(layer), record.line),
            Some(pieces) => {
                let block = context.block.map(|block| format!(" of block \"{}\"", clip(block, 40))).unwrap_or_default();
                let (name, layer) = (record.name() + &block, Some(clip(layer, 60).into()));
                self.sink.add(Entity { name, layer, line: record.line, pieces })?;
            }
        }
        Ok(())
    }

    /// Why CAD does not show an entity, where it does not.
    fn unseen(&self, record: &Record, layer: &str, named: bool) -> Result<Option<&'static str>, InputError> {
        let hidden = self.layers.hidden(layer).filter(|_| !named);
        Ok(if record.flags(67, self.sink)? == 1 {
            Some("in paper space")
        } else if record.flags(60, self.sink)? == 1 {
            Some("that is invisible")
        } else {
            hidden.map(|hidden| match hidden {
                Hidden::Off => "on a layer that is off",
                Hidden::Frozen => "on a layer that is frozen",
            })
        })
    }

    /// Reads the entities of a block, as often as it is inserted.
    fn insert(&mut self, record: &Record<'a>, context: &Context<'a>) -> Result<(), InputError> {
        let layer = layer_of(record, context);
        let name = record.text(2).unwrap_or("");
        let named = self.sink.layers.names(layer);
        let unseen = self.unseen(record, layer, named)?.filter(|why| *why != "on a layer that is off");
        if let Some(why) = unseen {
            self.sink.omitted.note(&format!("INSERT {why}"), Some(layer), record.line);
            return Ok(());
        }
        let Some(block) = self.blocks.get(&folded(name)).copied() else {
            let why = ("the block has to be in the file", "save the drawing with its blocks, or remove the insertion");
            return Err(record.wrong(self.sink, "the block (2)", &format!("\"{name}\""), why));
        };
        if block.external {
            self.sink.omitted.note("INSERT of another file", Some(layer), record.line);
            return Ok(());
        }
        if context.depth == DEEPEST {
            let why = ("blocks may lie 32 deep in one another", "explode the blocks in CAD");
            return Err(record.wrong(self.sink, "the depth of the block", &format!("more for \"{name}\""), why));
        }
        let insert = Insert::new(record, &block, self.sink)?;
        for row in 0..insert.rows {
            for column in 0..insert.columns {
                let map = context.map.after(&insert.map(column, row));
                let inner = Context { map, layer: Some(layer), block: Some(name), depth: context.depth + 1 };
                // A block may be empty.
                self.count(record, 0)?;
                self.entities(&mut block.records.clone(), &inner, "ENDBLK")?;
            }
        }
        Ok(())
    }
}

/// The layer that an entity is on.
fn layer_of<'a>(record: &Record<'a>, context: &Context<'a>) -> &'a str {
    match (record.layer(), context.layer) {
        ("0", Some(layer)) => layer,
        (layer, _) => layer,
    }
}
