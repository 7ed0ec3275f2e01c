//! Random contours, written as SVG and DXF and read back.

use std::f64::consts::TAU;

use arcfeed_geometry::nalgebra::{Rotation2, Vector2, Vector3};
use arcfeed_testing::Random;
use robot_cr7::{GcodeProgram, MoveKind};

use crate::drawing_texts::{dxf_in, entity, place, read, svg};

type Point = Vector2<f64>;

/// A piece of a contour in mm, from where the one before it ends.
enum Piece {
    Line(Point),
    Cubic([Point; 3]),
    /// Centre, and the angle that is passed.
    Arc(Point, f64),
}

impl Piece {
    fn random(start: Point, random: &mut Random) -> Self {
        let mut near = |size: f64| start + size * Point::new(random.signed(), random.signed());
        let (a, b, c) = (near(20.0), near(20.0), near(20.0));
        match random.below(3) {
            0 => Self::Line(a),
            1 => Self::Cubic([a, b, c]),
            _ => Self::Arc(a, random.sign() * random.between(0.1, 6.1)),
        }
    }

    /// The place after the part `t` of the parameter.
    fn at(&self, start: Point, t: f64) -> Point {
        let u = 1.0 - t;
        match self {
            Self::Line(end) => start * u + end * t,
            Self::Cubic([b, c, d]) => {
                start * (u * u * u) + b * (3.0 * u * u * t) + c * (3.0 * u * t * t) + d * (t * t * t)
            }
            Self::Arc(centre, sweep) => centre + Rotation2::new(sweep * t) * (start - centre),
        }
    }
}

/// Contours that are apart from one another: their starts and their pieces.
fn random_contours(random: &mut Random) -> Vec<(Point, Vec<Piece>)> {
    let count = 1 + random.below(5);
    let contour = |_| {
        let start = 200.0 * Point::new(random.signed(), random.signed());
        let mut at = start;
        let pieces = (0..1 + random.below(6)).map(|_| {
            let piece = Piece::random(at, random);
            at = piece.at(at, 1.0);
            piece
        });
        (start, pieces.collect())
    };
    (0..count).map(contour).collect::<Vec<_>>()
}

/// Path data of SVG, each command absolute or relative.
fn path_data(start: Point, pieces: &[Piece], random: &mut Random) -> String {
    let mut text = format!("M{} {}", start.x, start.y);
    let mut at = start;
    for piece in pieces {
        let relative = random.chance(0.5);
        let base = if relative { at } else { Point::zeros() };
        let letter = |c: char| if relative { c.to_ascii_lowercase() } else { c };
        let point = |p: Point| format!("{} {}", p.x - base.x, p.y - base.y);
        let end = piece.at(at, 1.0);
        text += &match piece {
            Piece::Line(_) => format!("{}{}", letter('L'), point(end)),
            Piece::Cubic([b, c, d]) => format!("{}{},{},{}", letter('C'), point(*b), point(*c), point(*d)),
            Piece::Arc(centre, sweep) => {
                let (radius, large) = ((at - centre).norm(), u8::from(sweep.abs() > 0.5 * TAU));
                format!(
                    "{}{radius} {radius} {} {large} {} {}",
                    letter('A'),
                    random.between(-90.0, 90.0),
                    u8::from(*sweep > 0.0),
                    point(end)
                )
            }
        };
        at = end;
    }
    text
}

/// Entities of DXF.
fn entities(start: Point, pieces: &[Piece]) -> String {
    let mut at = start;
    let mut text = String::new();
    for piece in pieces {
        let end = piece.at(at, 1.0);
        text += &entity(&match piece {
            Piece::Line(_) => format!("0 LINE 8 0 10 {} 20 {} 11 {} 21 {}", at.x, at.y, end.x, end.y),
            Piece::Cubic([b, c, d]) => {
                let points: String = [&at, b, c, d].map(|p| format!(" 10 {} 20 {}", p.x, p.y)).concat();
                format!("0 SPLINE 8 0 71 3 40 0 40 0 40 0 40 0 40 1 40 1 40 1 40 1{points}")
            }
            Piece::Arc(_, sweep) => format!(
                "0 LWPOLYLINE 8 0 90 2 70 0 10 {} 20 {} 42 {} 10 {} 20 {}",
                at.x,
                at.y,
                (0.25 * sweep).tan(),
                end.x,
                end.y
            ),
        });
        at = end;
    }
    text
}

fn assert_same(
    program: &GcodeProgram,
    contours: &[(Point, Vec<Piece>)],
    map: impl Fn(Point) -> Vector3<f64>,
    seed: u64,
) {
    let mut feeds = program.moves_with_starts().filter(|(_, step)| step.kind != MoveKind::Rapid);
    for (start, pieces) in contours {
        let mut at = *start;
        for piece in pieces {
            let (start, step) = feeds.next().unwrap_or_else(|| panic!("seed {seed}: too few moves"));
            for i in 0..=8 {
                let t = f64::from(i) / 8.0;
                let off = (place(start, step, t) - map(piece.at(at, t))).norm();
                assert!(off < 1e-9, "seed {seed}: {off} m at {t} of line {}", step.line);
            }
            at = piece.at(at, 1.0);
        }
    }
    assert!(feeds.next().is_none(), "seed {seed}: too many moves");
    let lifts = program.moves.iter().filter(|step| step.kind == MoveKind::Rapid).count();
    assert_eq!(lifts, 3 * (contours.len() - 1), "seed {seed}");
    assert!(program.moves.windows(2).all(|pair| pair[0].line < pair[1].line), "seed {seed}");
}

#[test]
fn random_contours_are_read_back() {
    for seed in 0..400 {
        let mut random = Random::new(seed);
        let contours = random_contours(&mut random);
        let text: String = contours.iter().map(|(start, pieces)| entities(*start, pieces)).collect();
        let program = read(&dxf_in("4", "", &text), "a.dxf");
        assert_same(&program, &contours, |p| Vector3::new(p.x, p.y, 0.0) / 1e3, seed);

        let (turn, scale, mirror) = (random.between(-180.0, 180.0), random.log(0.2, 3.0), random.sign());
        let shift = Point::new(random.signed(), random.signed()) * 50.0;
        let single = random.chance(0.5);
        let data: Vec<_> = contours.iter().map(|(start, pieces)| path_data(*start, pieces, &mut random)).collect();
        let paths = match single {
            true => format!("<path d='{}'/>", data.concat()),
            false => data.iter().map(|d| format!("<path d='{d}'/>\n")).collect(),
        };
        let text = svg(&format!(
            "<g transform='translate({} {}) rotate({turn})'><g transform='scale({scale} {})'>{paths}</g></g>",
            shift.x,
            shift.y,
            scale * mirror
        ));
        let map = |p: Point| {
            let q = shift + Rotation2::new(turn.to_radians()) * Point::new(scale * p.x, scale * mirror * p.y);
            Vector3::new(q.x, 100.0 - q.y, 0.0) / 1e3
        };
        assert_same(&read(&text, "a.svg"), &contours, map, seed);
    }
}
