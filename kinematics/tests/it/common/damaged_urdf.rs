//! URDF texts damaged at random: whatever a text holds, reading it gives an arm or an error.

use arcfeed_kinematics::ArmDescription;

/// A multiplicative sequence, the same on every machine.
struct Sequence(u64);

impl Sequence {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(self.0 >> 33).unwrap_or(0) % bound.max(1)
    }
}

/// Everything that means something to a reader of markup or of arms, and what it should survive.
const PIECES: [&str; 44] = [
    "<",
    ">",
    "/>",
    "\"",
    "'",
    "=",
    "&",
    ";",
    "<!--",
    "-->",
    "<![CDATA[",
    "]]>",
    "<!DOCTYPE r [<!ENTITY a \"aaaa\">]>",
    "<?",
    "?>",
    "&a;",
    "&#0;",
    "&#x110000;",
    "&lt;",
    "NaN",
    "inf",
    "-1e308",
    "1e999",
    "0",
    " ",
    "\n",
    "\u{0}",
    "\u{e9}",
    "\u{feff}",
    "</robot>",
    "<robot name=\"y\">",
    "<link name=\"world\"/>",
    "<link name=\"a\"/>",
    "<inertial/>",
    "<mass value=\"1\"/>",
    "<mimic joint=\"a\"/>",
    "<origin xyz=\"0 0 0\" rpy=\"0 0 0\"/>",
    "<axis xyz=\"0 0 0\"/>",
    "<x:y z:w=\"1\" xmlns=\"u\">",
    "version=\"1.2\"",
    "quat_xyzw=\"0 0 0 0\"",
    "type=\"planar\"",
    "type=\"fixed\"",
    "<a b=\"/>\">",
];

fn boundary(text: &str, mut at: usize) -> usize {
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// The `seed`-th damaged text.
pub fn damaged(sound: &[String], seed: u64) -> String {
    let mut draw = Sequence(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let mut text = sound[draw.below(sound.len())].clone();
    for _ in 0..1 + draw.below(4) {
        let start = draw.below(text.len() + 1);
        let start = boundary(&text, start);
        let end = (start + draw.below(80)).min(text.len());
        let end = boundary(&text, end);
        match draw.below(9) {
            0 => text.replace_range(start..end, ""),
            1 => text.truncate(start),
            2 => {
                let part = text[start..end].repeat(1 + draw.below(4));
                let to = draw.below(text.len() + 1);
                text.insert_str(boundary(&text, to), &part);
            }
            3 => {
                let other = &sound[draw.below(sound.len())];
                let from = draw.below(other.len());
                text.replace_range(start.., &other[boundary(other, from)..]);
            }
            4 => text.insert_str(start, &PIECES[draw.below(PIECES.len())].repeat(1 + draw.below(200))),
            5 | 6 => {
                // One character, as a slip of the hand.
                let end = boundary(&text, (start + 1).min(text.len()));
                text.replace_range(start..end, &draw.below(10).to_string());
            }
            _ => text.replace_range(start..end, PIECES[draw.below(PIECES.len())]),
        }
    }
    text
}

/// Reads a text and uses what it gives; true if that is an arm.
pub fn read(text: &str) -> bool {
    let arm = ArmDescription::from_urdf(text, None, None).and_then(|arm| arm.build_any());
    match arm {
        Ok(arm) => {
            let pose = arm.forward(&vec![0.1; arm.joints()]);
            assert!(pose.is_ok_and(|pose| pose.translation.vector.iter().all(|v| v.is_finite())), "no pose");
            true
        }
        Err(error) => {
            assert!(error.to_string().len() < 30_000, "an error of {} bytes", error.to_string().len());
            false
        }
    }
}
