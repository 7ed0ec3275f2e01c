//! Drawings (DXF and SVG) as programs.
//!
//! [`read_drawing`] turns a drawing into a [`GcodeProgram`](crate::GcodeProgram): its lines, arcs and curves become moves at one feed, in
//! metres, with y up and z = 0 where the drawing is flat.
//!
//! * **Order.** Entities keep the order and the direction of the file. Consecutive entities whose ends are within 1e-6 m of one another are
//!   one contour; their ends are then moved onto one another. A contour whose ends are as near is closed.
//! * **Lifts.** Between two contours the tool goes up along z to [`DrawingOptions::lift`] above the highest point of the drawing, across, and
//!   down by rapid moves. The ends of both contours are reached exactly. A marker names the entity that each contour begins with.
//! * **Lines.** The line of a move is that of its entity in the file, or of its vertex. Where several moves share a line, or an inserted
//!   block leads back in the file, the moves are counted from 1, with a warning.
//! * **What is left out** is counted by kind and layer, in one warning each: text, images and other kinds that are no path, and what CAD
//!   does not show. Left out without a word are layers that are not asked for and, in SVG, hidden elements, definitions that nothing shows,
//!   elements of other namespaces (such as those of editors), descriptions, scripts, animations, and the children of a switch that it does
//!   not show where it shows one.
//!
//! | DXF | |
//! |---|---|
//! | paths | LINE, ARC, CIRCLE, ELLIPSE, LWPOLYLINE and POLYLINE with bulges, SPLINE with control points, INSERT of blocks |
//! | unit | `$INSUNITS`, else [`DrawingOptions::unit`], else mm |
//! | layers | by name, in upper or lower case; those that are off or frozen only where they are named |
//! | refused | binary DXF, splines of fit points alone and of a degree above 15, units that are no length of a drawing, insertions of a block that is missing |
//! | counted | all other entities, paper space, external references |
//!
//! | SVG | |
//! |---|---|
//! | paths | path with all commands, rect, circle, ellipse, line, polyline, polygon; g, a, switch, use within the file; transforms |
//! | unit | width and height of the page with its viewBox, else [`DrawingOptions::unit`], else pixels of 1/96 in |
//! | origin | the lower left corner of the page; where the file states no height, the origin of the drawing |
//! | layers | groups by `inkscape:label` or `id`, with all that is in them |
//! | refused | svg within svg, symbols with a viewBox, transforms, places and sizes in styles, transform-origin, lengths in em, ex and % |
//! | counted | text, images, links to other files, conditional children of a switch, rules of style sheets; clip-path and mask, for their element is drawn as a whole |
//!
//! Arcs of circles stay arcs, and arcs of ellipses are rational curves, both exact. Bezier curves are exact, unless a handle
//! is retracted (1e-7 m or shorter): the curvature of a cubic has no limit there, and a parabola takes the place of its end. It is within
//! 1e-6 m of the curve, and so is a line in the place of a curve whose handles do not bend it.
//!
//! # Why these libraries
//!
//! `roxmltree` 0.21 and `svgtypes` 0.16 read XML, path data, transforms and lengths in double precision. They add 7 s of processor time to
//! a first build. `usvg` computes in single precision, which is good to a micrometre in ten metres at best.
//!
//! The groups of DXF are read here. The crate `dxf` 0.6 does not tell the lines of entities, and adds 80 s of processor time and 27 crates,
//! among them two for images, to a first build.

mod bezier;
mod conic;
mod contour;
mod dxf;
mod map;
mod omitted;
mod options;
mod piece;
mod program;
pub(crate) mod reader;
mod selection;
mod sink;
mod svg;

pub use options::DrawingOptions;
pub use reader::read_drawing;
