//! Drawings in SVG.
//!
//! The shapes and the units are those of SVG 1.1 and CSS 2.1: 96 px are an inch.

mod length;
mod path;
mod reader;
mod shapes;
mod state;
mod style;
mod viewport;
mod walk;

pub(super) use reader::read_svg;
