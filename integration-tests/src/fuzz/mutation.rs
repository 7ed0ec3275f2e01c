//! Texts changed at random, with regard to their lines, words and numbers.

use std::ops::Range;

use arcfeed_testing::Random;

/// Numbers that programs stumble over.
const NUMBERS: [&str; 28] = [
    "0",
    "-0",
    "-1",
    "1",
    "0.0",
    "1e-300",
    "1e300",
    "-1e308",
    "1e999",
    "NaN",
    "nan",
    "inf",
    "-inf",
    "Infinity",
    "1e-9",
    "1e9",
    "255",
    "256",
    "65536",
    "2147483648",
    "4294967296",
    "9223372036854775807",
    "18446744073709551616",
    "0x10",
    "1_000",
    ".5",
    "5.",
    "1e",
];

/// Pieces that mean something to one reader or another.
const PIECES: [&str; 44] = [
    "\"",
    "'",
    "{",
    "}",
    "[",
    "]",
    "(",
    ")",
    "<",
    ">",
    "/>",
    "=",
    ",",
    ";",
    ":",
    "#",
    "%",
    "&amp;",
    "&a;",
    "<!--",
    "-->",
    "<![CDATA[",
    "<!DOCTYPE r [<!ENTITY a \"aaaa\">]>",
    "<?xml version=\"1.0\"?>",
    "\u{feff}",
    "\0",
    "\u{e9}",
    "\t",
    "\r",
    "null",
    "true",
    "[[",
    "]]",
    "\"\"\"",
    "G2",
    "G5.2",
    "X",
    "R",
    "#1=",
    "[2 ** 9]",
    "  0\nLINE\n",
    "  0\nENDSEC\n",
    "transform=\"scale(0)\"",
    "d=\"M0 0 A1 0 0 0 1 1 1\"",
];

/// The longest text that is made, bytes.
const LONGEST: usize = 100_000;

/// A change of one of `seeds`, one to six steps away from it.
pub(super) fn mutated(seeds: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let Some(seed) = seeds.get(random.below(seeds.len().max(1))) else { return Vec::new() };
    changed(seed.clone(), seeds, random)
}

/// A change of `text`, one to six steps away from it, some with pieces of `seeds`, of which there is one at least.
pub(super) fn changed(mut text: Vec<u8>, seeds: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    for _ in 0..1 + random.below(6) {
        change(&mut text, seeds, random);
        text.truncate(LONGEST);
    }
    text
}

fn change(text: &mut Vec<u8>, seeds: &[Vec<u8>], random: &mut Random) {
    match random.below(16) {
        0..=3 => change_number(text, random),
        4 => change_byte(text, random),
        5 => {
            let piece = random.one_of(&PIECES).repeat(repeats(random));
            insert(text, piece.as_bytes(), random);
        }
        6 => {
            let span = some_span(text, random);
            text.drain(span);
        }
        7 => {
            let span = some_span(text, random);
            let piece = text[span].repeat(repeats(random));
            insert(text, &piece, random);
        }
        8 | 9 => {
            let line = line(text, random);
            text.drain(line);
        }
        10 => {
            let line = line(text, random);
            let piece = text[line.clone()].repeat(repeats(random));
            text.splice(line.start..line.start, piece);
        }
        11 => {
            let (from, to) = (line(text, random), line(text, random));
            let moved = text[from].to_vec();
            text.splice(to.start..to.start, moved);
        }
        12 => {
            // A piece of another file.
            let other = &seeds[random.below(seeds.len())];
            let piece = &other[some_span(other, random)];
            insert(text, piece, random);
        }
        13 => {
            // The head of this one and the tail of another.
            let other = &seeds[random.below(seeds.len())];
            let (head, tail) = (line(text, random).start, line(other, random).start);
            text.truncate(head);
            text.extend_from_slice(&other[tail..]);
        }
        14 => swap_words(text, random),
        _ => match random.below(3) {
            0 => text.truncate(random.below(text.len() + 1)),
            1 => *text = String::from_utf8_lossy(text).replace('\n', "\r\n").into_bytes(),
            _ => {
                text.splice(0..0, "\u{feff}".bytes());
            }
        },
    }
}

/// Mostly 1, sometimes hundreds.
fn repeats(random: &mut Random) -> usize {
    if random.chance(0.9) { 1 + random.below(3) } else { 1 + random.below(600) }
}

fn insert(text: &mut Vec<u8>, piece: &[u8], random: &mut Random) {
    let at = random.below(text.len() + 1);
    text.splice(at..at, piece.iter().copied());
}

fn change_byte(text: &mut [u8], random: &mut Random) {
    let length = text.len();
    if length > 0 {
        let byte = &mut text[random.below(length)];
        *byte = if random.chance(0.5) { *byte ^ (1 << random.below(8)) } else { random.bits() as u8 };
    }
}

/// A few bytes somewhere.
fn some_span(text: &[u8], random: &mut Random) -> Range<usize> {
    let start = random.below(text.len() + 1);
    start..(start + random.below(60)).min(text.len())
}

/// A whole line with its end.
fn line(text: &[u8], random: &mut Random) -> Range<usize> {
    let at = random.below(text.len() + 1);
    let start = text[..at].iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
    let end = text[at..].iter().position(|b| *b == b'\n').map_or(text.len(), |i| at + i + 1);
    start..end
}

/// The run of bytes of one kind around a place.
fn run(text: &[u8], at: usize, of: fn(u8) -> bool) -> Range<usize> {
    let start = text[..at].iter().rposition(|b| !of(*b)).map_or(0, |i| i + 1);
    let end = text[at..].iter().position(|b| !of(*b)).map_or(text.len(), |i| at + i);
    start..end
}

fn of_number(byte: u8) -> bool {
    byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+' | b'e' | b'E')
}

fn of_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.' | b'-')
}

/// Another number in the place of one.
fn change_number(text: &mut Vec<u8>, random: &mut Random) {
    let from = random.below(text.len() + 1);
    let Some(at) = text[from..].iter().position(u8::is_ascii_digit).map(|i| from + i) else { return };
    let span = run(text, at, of_number);
    let old = std::str::from_utf8(&text[span.clone()]).ok().and_then(|number| number.parse::<f64>().ok());
    let new = match (random.below(5), old) {
        (0, Some(old)) => format!("{}", old * random.log(0.1, 10.0)),
        (1, Some(old)) => format!("{:e}", old * 10f64.powi(random.below(40) as i32 - 20)),
        (2, Some(old)) => format!("{}", -old),
        (3, Some(old)) => format!("{}", old.round() + random.one_of(&[-1.0, 0.0, 1.0])),
        _ => random.one_of(&NUMBERS).to_owned(),
    };
    text.splice(span, new.into_bytes());
}

/// One word of the text in the place of another.
fn swap_words(text: &mut Vec<u8>, random: &mut Random) {
    let word = |text: &[u8], random: &mut Random| {
        let from = random.below(text.len() + 1);
        let at = text[from..].iter().position(|b| of_word(*b)).map(|i| from + i)?;
        Some(run(text, at, of_word))
    };
    if let (Some(from), Some(to)) = (word(text, random), word(text, random)) {
        let moved = text[from].to_vec();
        text.splice(to, moved);
    }
}
