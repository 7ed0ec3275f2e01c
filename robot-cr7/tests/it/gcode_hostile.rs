//! Hostile texts and long programs are survived.

use std::io::{self, BufReader, Read};
use std::path::Path;

use arcfeed_geometry::nalgebra::{Vector3, vector};
use arcfeed_testing::Random;
use robot_cr7::{GcodeMove, GcodeOptions, GcodeProgram, InputError, MoveKind, MoveShape};

const SAMPLES: [&str; 9] = [
    include_str!("../../data/gcode/helix.ngc"),
    include_str!("../../data/gcode/inch.ngc"),
    include_str!("../../data/gcode/nurbs_g5.ngc"),
    include_str!("../../data/gcode/nurbs_g6.ngc"),
    include_str!("../../data/gcode/pocket.ngc"),
    include_str!("../../data/gcode/rotary.ngc"),
    include_str!("../../data/gcode/splines.ngc"),
    include_str!("../../data/gcode/square.ngc"),
    include_str!("../../data/gcode/variables.ngc"),
];

/// Random bytes, random pieces of words, or a sample with damage.
fn hostile_text(random: &mut Random) -> Vec<u8> {
    let pieces: [&[u8]; 48] = [
        b"G",
        b"G0",
        b"G1",
        b"G2",
        b"G3",
        b"G5",
        b"G5.1",
        b"G5.2",
        b"G5.3",
        b"G6.2",
        b"G90",
        b"G91",
        b"G20",
        b"G18",
        b"G93",
        b"G64",
        b"M3",
        b"M2",
        b"X",
        b"Y",
        b"Z1",
        b"I",
        b"J",
        b"K",
        b"R",
        b"P2",
        b"Q",
        b"L3",
        b"F1",
        b"A",
        b"1",
        b"-",
        b".5",
        b"999999999",
        b"[",
        b"]",
        b"#1",
        b"#1=",
        b"#<a>",
        b"=",
        b"**",
        b"/",
        b"SIN[",
        b"ATAN[1]/",
        b"(",
        b")",
        b"\n",
        b"0",
    ];
    match random.below(3) {
        0 => (0..random.below(300)).map(|_| random.bits() as u8).collect(),
        1 => (0..random.below(150)).flat_map(|_| random.one_of(&pieces).iter().copied()).collect(),
        _ => {
            let mut text = random.one_of(&SAMPLES).as_bytes().to_vec();
            for _ in 0..1 + random.below(6) {
                let at = random.below(text.len());
                let end = (at + random.below(20)).min(text.len());
                match random.below(5) {
                    0 => text[at] = random.bits() as u8,
                    1 => drop(text.drain(at..end)),
                    2 => text.splice(at..at, random.one_of(&pieces).iter().copied()).for_each(drop),
                    3 => text.splice(at..end, random.one_of(&pieces).iter().copied()).for_each(drop),
                    _ => text.extend_from_within(at..end),
                }
                if text.is_empty() {
                    break;
                }
            }
            text
        }
    }
}

/// Reads `count` hostile texts. What is read is finite and connected; what is not has a place. Returns how many were read.
fn read_hostile_texts(seed: u64, count: u64) -> u64 {
    let mut read = 0;
    for seed in seed..seed + count {
        let text = hostile_text(&mut Random::new(seed));
        match GcodeProgram::from_bytes(&text, Path::new("hostile.ngc"), &GcodeOptions::default()) {
            Ok(program) => {
                read += 1;
                for (start, step) in program.moves_with_starts() {
                    assert_sound(start, step, seed);
                }
                assert!(program.markers.iter().all(|m| m.after <= program.moves.len()), "seed {seed}");
            }
            Err(InputError::Gcode { line, column, word, .. }) => {
                let lines = 1 + text.iter().filter(|&&b| b == b'\n').count() as u64;
                assert!((1..=lines).contains(&line) && column >= 1 && !word.is_empty(), "seed {seed}");
            }
            Err(InputError::Empty { .. }) => {}
            Err(e) => panic!("seed {seed}: {e}"),
        }
    }
    read
}

fn assert_sound(start: Vector3<f64>, step: &GcodeMove, seed: u64) {
    let finite = |v: Vector3<f64>| v.iter().all(|x| x.is_finite());
    assert!(finite(step.end()) && step.rotary.is_none_or(finite), "seed {seed}: {step:?}");
    match step.kind {
        MoveKind::Rapid => {}
        MoveKind::Feed { speed: x } | MoveKind::RotaryFeed { speed: x } | MoveKind::InverseTime { seconds: x } => {
            assert!(x.is_finite() && x > 0.0, "seed {seed}: {step:?}");
        }
    }
    if let MoveShape::Arc { centre, normal, sweep, rise, to } = &step.shape {
        let arm = start - centre;
        let (sin, cos) = sweep.sin_cos();
        let end = centre + arm * cos + normal.cross(&arm) * sin + normal.into_inner() * *rise;
        let size = centre.norm() + start.norm() + to.norm() + 1.0;
        assert!((end - to).norm() < 1e-8 * size && sweep.abs() > 0.0, "seed {seed}: {step:?} ends in {end}");
    }
}

#[test]
fn hostile_texts_are_survived() {
    let read = read_hostile_texts(0, 10_000);
    assert!((500..9500).contains(&read), "{read} texts were read");
}

#[test]
#[ignore = "a longer run of the test above"]
fn a_million_hostile_texts_are_survived() {
    read_hostile_texts(1_000_000, 1_000_000);
}

/// A program of many lines that is made while it is read: one line in `every` moves.
struct Endless {
    line: u64,
    lines: u64,
    every: u64,
    present: Vec<u8>,
}

impl Read for Endless {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.present.is_empty() && self.line < self.lines {
            let x = (self.line / self.every) % 1000;
            self.present = format!("N{} G1 X{x}.5 Y[2*{x}] F900 (line)\n", self.line % 100_000).into_bytes();
            self.line += 1;
        }
        let count = self.present.len().min(buffer.len());
        buffer[..count].copy_from_slice(&self.present[..count]);
        self.present.drain(..count);
        Ok(count)
    }
}

#[test]
fn a_million_lines_are_read_one_at_a_time() {
    let stream = Endless { line: 0, lines: 1_000_000, every: 5000, present: Vec::new() };
    let reader = BufReader::with_capacity(4096, stream);
    let program = GcodeProgram::from_reader(reader, Path::new("long.ngc"), &GcodeOptions::default()).expect("is read");
    assert_eq!(program.lines, 1_000_000);
    assert_eq!(program.moves.len(), 200);
    assert!(program.markers.is_empty());
    assert_eq!(program.moves[199].line, 995_001);
    assert!((program.moves[199].end() - vector![0.1995, 0.398, 0.0]).norm() < 1e-12);
}

#[test]
fn a_line_without_end_is_refused_without_being_stored() {
    let reader = BufReader::new(io::repeat(b'X'));
    let e = GcodeProgram::from_reader(reader, Path::new("endless.ngc"), &GcodeOptions::default());
    assert!(e.expect_err("too long").to_string().contains("more than 4096 bytes"));
    let reader = BufReader::new(io::repeat(b'\n').take(3_000_000));
    let e = GcodeProgram::from_reader(reader, Path::new("blank.ngc"), &GcodeOptions::default());
    assert!(e.expect_err("blank").to_string().contains("empty"));
}
