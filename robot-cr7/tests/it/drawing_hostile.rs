//! Hostile drawings are survived.

use std::path::Path;

use arcfeed_testing::Random;
use robot_cr7::{DrawingOptions, InputError, read_drawing};

use crate::drawing_texts::{dxf_in, entity, refusal, svg};

const SAMPLES: [(&str, &str); 4] = [
    ("plate.dxf", include_str!("../../data/drawings/plate.dxf")),
    ("leaf.dxf", include_str!("../../data/drawings/leaf.dxf")),
    ("badge.svg", include_str!("../../data/drawings/badge.svg")),
    ("bracket.svg", include_str!("../../data/drawings/bracket.svg")),
];

const PIECES: [&str; 60] = [
    "nan",
    "inf",
    "1e308",
    "-1e308",
    "1e-308",
    "0",
    "-0",
    "-1",
    "1e6",
    "99999999999999999999",
    "4294967296",
    "0.1",
    "é",
    "\u{feff}",
    "\0",
    "\n",
    "\n0\n",
    "\n0\nLINE\n",
    "\n0\nENDSEC\n",
    "\n0\nEOF\n",
    "\n0\nINSERT\n2\nEYE\n",
    "\n0\nPOLYLINE\n",
    "\n0\nVERTEX\n",
    "\n42\n1e9\n",
    "\n210\n0\n",
    "\n230\n-1\n",
    "\n70\n1\n",
    "\n71\n9\n",
    "\n40\n0\n",
    "\n10\n0\n",
    "\n20\n0\n",
    "\n67\n1\n",
    "\n60\n1\n",
    "<",
    ">",
    "/>",
    "\"",
    "'",
    "&",
    "&amp;",
    "<g>",
    "</g>",
    "<g transform=\"scale(1e200)\">",
    "<use href=\"#layer1\"/>",
    "<use href=\"#dot\"/>",
    "<!--",
    "-->",
    "<![CDATA[",
    "<!DOCTYPE svg [<!ENTITY a \"b\">]>",
    "&a;",
    " d=\"M0 0A1 1 0 1 1 0 1e-9\"",
    " transform=\"matrix(1 1 1 1 0 0)\"",
    " style=\"display:none\"",
    " viewBox=\"0 0 1 1\"",
    "A",
    "c",
    "q",
    "z",
    "m",
    "e",
];

/// A sample with damage, or pieces alone.
fn hostile_text(random: &mut Random) -> (&'static str, Vec<u8>) {
    let (name, sample) = random.one_of(&SAMPLES);
    let mut text = sample.as_bytes().to_vec();
    if random.chance(0.05) {
        text.clear();
        (0..random.below(60)).for_each(|_| text.extend(random.one_of(&PIECES).bytes()));
        return (name, text);
    }
    // Half of the texts keep their form.
    let kinds = if random.chance(0.5) { 1 } else { 7 };
    for _ in 0..1 + random.below(6) {
        let at = random.below(text.len());
        let end = (at + random.below(20)).min(text.len());
        match random.below(kinds) {
            0 => number(&mut text, at, random),
            1 => drop(text.drain(at..end)),
            2 => text.splice(at..at, random.one_of(&PIECES).bytes()).for_each(drop),
            3 => text.splice(at..end, random.one_of(&PIECES).bytes()).for_each(drop),
            4 => text[at] = random.bits() as u8,
            5 => {
                // A part moves elsewhere.
                let part: Vec<u8> = text[at..(at + random.below(400)).min(text.len())].to_vec();
                let to = random.below(text.len());
                text.splice(to..to, part).for_each(drop);
            }
            _ => text.truncate(at.max(1)),
        }
        if text.is_empty() {
            break;
        }
    }
    (name, text)
}

/// Another number in place of the one at `at` or behind it.
fn number(text: &mut Vec<u8>, at: usize, random: &mut Random) {
    let digit = |byte: &u8| byte.is_ascii_digit() || *byte == b'.' || *byte == b'-';
    let Some(start) = text[at..].iter().position(digit).map(|i| at + i) else { return };
    let end = text[start..].iter().position(|byte| !digit(byte)).map_or(text.len(), |i| start + i);
    let other = match random.below(3) {
        0 => random.one_of(&PIECES[..12]).to_owned(),
        1 => format!("{}", random.sign() * random.log(1e-12, 1e12)),
        _ => format!("{}", random.below(300)),
    };
    text.splice(start..end, other.bytes()).for_each(drop);
}

/// Reads `count` hostile texts. What is read is finite and connected; what is not has a message of one line. Returns how many were read.
fn read_hostile_texts(seed: u64, count: u64) -> u64 {
    let mut read = 0;
    for seed in seed..seed + count {
        let (name, text) = hostile_text(&mut Random::new(seed));
        match read_drawing(&text, Path::new(name), &DrawingOptions::default()) {
            Ok(program) => {
                read += 1;
                let mut line = 0;
                for (start, step) in program.moves_with_starts() {
                    let ends = [start, step.end()];
                    assert!(ends.iter().flatten().all(|x| x.abs() <= 1.001e6), "seed {seed}: {step:?}");
                    assert!(step.line > line, "seed {seed}: {step:?} behind line {line}");
                    line = step.line;
                }
                // A path, or an error of its shape; no panic.
                match program.joined() {
                    Ok(path) => assert!(path.length().is_finite(), "seed {seed}"),
                    Err(InputError::Curve { .. }) => {}
                    Err(e) => panic!("seed {seed}: {e}"),
                }
            }
            Err(InputError::NotText { line, .. }) => assert!(line >= 1, "seed {seed}"),
            Err(e) => {
                let message = e.to_string();
                assert!(message.starts_with(name) && !message.contains('\n'), "seed {seed}: {message}");
            }
        }
    }
    read
}

#[test]
fn hostile_texts_are_survived() {
    let read = read_hostile_texts(0, 4000);
    assert!((400..3600).contains(&read), "{read} texts were read");
}

#[test]
#[ignore = "a longer run of the test above"]
fn many_hostile_texts_are_survived() {
    println!("{} texts were read", read_hostile_texts(1_000_000, 100_000));
}

#[test]
fn bombs_end_with_a_message() {
    let options = DrawingOptions::default();
    let says = |text: &str, name: &str, part: &str| {
        let message = refusal(text, name, &options);
        assert!(message.contains(part), "{message}");
    };
    let deep = |n: usize| svg(&format!("{}<line x2='5'/>{}", "<g>".repeat(n), "</g>".repeat(n)));
    says(&deep(100_000), "a.svg", "200 deep");
    assert!(read_drawing(deep(150).as_bytes(), Path::new("a.svg"), &options).is_ok());
    says(&svg("<g id='a'><line x2='5'/><use href='#a'/></g>"), "a.svg", "200 deep");
    let group = |i: usize| format!("<g id='g{}'><use href='#g{i}'/><use href='#g{i}'/></g>\n", i + 1);
    let doubled: String = (0..60).map(group).collect();
    says(&svg(&format!("<g id='g0'/>{doubled}")), "a.svg", "more than");
    let entities: String = (1..30).map(|i| format!("<!ENTITY a{i} '&a{0};&a{0};'>", i - 1)).collect();
    says(&format!("<!DOCTYPE svg [<!ENTITY a0 'x'>{entities}]>{}", svg("&a29;")), "a.svg", "a.svg:1");

    let block = |name: usize, inner: &str| entity(&format!("0 BLOCK 2 B{name} 70 0 10 0 20 0")) + inner + "0\nENDBLK\n";
    let pair = |i: usize| entity(&format!("0 INSERT 2 B{i} 10 0 20 0")).repeat(4);
    let blocks = |last: &str| {
        let all: String = (0..25).map(|i| block(i + 1, &pair(i))).collect();
        format!("0\nSECTION\n2\nBLOCKS\n{}{all}0\nENDSEC\n", block(0, last))
    };
    // Groups without a meaning make the count go up sooner.
    let filler = "1\nx\n".repeat(20_000);
    let insert = entity("0 INSERT 2 B25 10 0 20 0");
    let line = entity("0 LINE 10 0 20 0 11 5 21 5");
    says(&dxf_in("4", &blocks(&(line + &filler)), &insert), "a.dxf", "more than");
    says(&dxf_in("4", &blocks(&(entity("0 TEXT 10 0") + &filler)), &insert), "a.dxf", "more than");
    let grid = entity("0 INSERT 2 B0 10 0 20 0 70 9000000000000000000 71 9000000000000000000") + &filler;
    says(&dxf_in("4", &blocks(""), &grid), "a.dxf", "more than");
    let long = format!("<polyline points='{}'/>", "1 2 ".repeat(1_000_001));
    says(&svg(&long), "a.svg", "2000000 numbers");
    says(&svg(&"<g/>".repeat(3_000_001)), "a.svg", "divide the drawing");
}

#[test]
fn copies_of_long_texts_end_with_a_message() {
    let says = |text: &str, name: &str, parts: &[&str]| {
        let message = refusal(text, name, &DrawingOptions::default());
        for part in ["256 MB", "fewer copies"].iter().chain(parts) {
            assert!(message.contains(part), "{message}");
        }
    };
    // A path without a line, a million times; so are comments, attributes and children that no element shows.
    let group = |i: u32| format!("<g id='g{}'>{}</g>\n", i + 1, format!("<use href='#g{i}'/>").repeat(10));
    let copies: String = (0..6).map(group).collect();
    let shown = |element: &str| svg(&format!("<defs>{element}{copies}</defs><use href='#g6'/>"));
    says(&shown(&format!("<path id='g0' d='{}'/>", "M0 0".repeat(1_000_000))), "a.svg", &["path \"g0\""]);
    says(&shown(&format!("<g id='g0'>{}</g>", "<!--a-->".repeat(100_000))), "a.svg", &["g \"g0\""]);
    says(&shown(&format!("<g id='g0'>{}</g>", "<title/>".repeat(100_000))), "a.svg", &["title"]);
    let child = "<g systemLanguage='en'/>";
    says(&shown(&format!("<switch id='g0'>{}</switch>", child.repeat(100_000))), "a.svg", &["what is read"]);
    // A block with a text, in rows and columns; so is one with a long end, and one with a long blank.
    let grid = entity("0 INSERT 2 B 10 0 20 0 70 1000 71 1000");
    let block = |inner: &str| {
        let start = entity("0 SECTION 2 BLOCKS 0 BLOCK 2 B 70 0 10 0 20 0");
        dxf_in("4", &format!("{start}{inner}{}", entity("0 ENDSEC")), &grid)
    };
    let text = format!("0\nTEXT\n1\n{}\n", "a".repeat(1_000_000));
    says(&block(&(text.clone() + "0\nENDBLK\n")), "a.dxf", &["TEXT"]);
    says(&block(&text.replace("TEXT", "ENDBLK")), "a.dxf", &["ENDBLK"]);
    says(&block(&format!("0\nTEXT\n{}1\na\n0\nENDBLK\n", " ".repeat(1_000_000))), "a.dxf", &["TEXT"]);
    let vertices = entity("0 POLYLINE 70 0 0 VERTEX 10 0 20 0") + &text.replace("TEXT", "VERTEX");
    says(&block(&(vertices + "10\n1\n20\n1\n0\nSEQEND\n0\nENDBLK\n")), "a.dxf", &["VERTEX"]);
}
