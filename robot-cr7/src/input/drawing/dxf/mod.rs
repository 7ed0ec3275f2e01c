//! Drawings in DXF.
//!
//! A DXF file consists of groups: a code on one line, and its value on the next. The codes of the entities are those of the DXF
//! reference of AutoCAD 2018.

mod entities;
mod groups;
mod insert;
mod ocs;
mod polyline;
mod reader;
mod record;
mod tables;

pub(super) use reader::read_dxf;
