//! Triangles of an STL file, binary or text.

use std::io::Cursor;

use super::fault::MeshFault;
use crate::text::clip;

/// Bytes before the triangles of a binary file: a header and their number.
const HEAD: usize = 84;
/// Bytes of a triangle of a binary file.
const TRIANGLE: u64 = 50;
/// Longest line of a text, bytes.
const MOST_LINE: usize = 1000;
/// What a text begins with, and some binary files, too.
const SOLID: &[u8] = b"solid";

/// The corners of a triangle, in the unit of the file.
type Corners = [[f32; 3]; 3];

/// The corners of each triangle, in the unit of the file; at most `most` of them. Of a text they are those of all its solids.
///
/// # Errors
/// [`MeshFault`] for what is no STL, or not finite.
pub(super) fn triangles(bytes: &[u8], most: usize) -> Result<Vec<Corners>, MeshFault> {
    // Some binary files begin as a text. Their number of triangles has a 0 in it, for no file is large enough for another one.
    match bytes.starts_with(SOLID) && !bytes[..HEAD.min(bytes.len())].contains(&0) {
        true => of_text(bytes, most),
        false => of_binary(bytes, most),
    }
}

/// A head, the number of triangles, and triangles; what follows is left alone.
fn of_binary(bytes: &[u8], most: usize) -> Result<Vec<Corners>, MeshFault> {
    let stated = bytes.get(HEAD - 4..HEAD).and_then(|count| Some(u32::from_le_bytes(count.try_into().ok()?)));
    let (length, stated) = (bytes.len() as u64, stated.unwrap_or_default());
    let needed = HEAD as u64 + TRIANGLE * u64::from(stated);
    if length < needed {
        return Err(MeshFault::Length { triangles: stated, needed, bytes: length });
    }
    // A head that looks like a text is none.
    let mut reader = Cursor::new([&[0; HEAD - 4][..], &bytes[HEAD - 4..]].concat());
    let mut all = Vec::new();
    take(&mut all, &mut reader, most, Some(stated))?;
    Ok(all)
}

/// Solids, each from a line `solid NAME` to a line `endsolid NAME`.
fn of_text(bytes: &[u8], most: usize) -> Result<Vec<Corners>, MeshFault> {
    let mut all = Vec::new();
    let mut solid: Option<Vec<u8>> = None;
    for (index, line) in bytes.split_inclusive(|byte| *byte == b'\n').enumerate() {
        if line.len() > MOST_LINE {
            let (count, most) = (line.len() as u64, MOST_LINE as u64);
            return Err(MeshFault::Many { what: "bytes in a line", count, most });
        }
        let word = line.trim_ascii().split(u8::is_ascii_whitespace).next().unwrap_or_default();
        match (&mut solid, word) {
            (None, b"") => {}
            // The reader takes a solid with a name alone.
            (None, word) if word.starts_with(SOLID) => solid = Some(b"solid a\n".to_vec()),
            (None, _) => {
                let found = clip(String::from_utf8_lossy(line).trim(), 40);
                return Err(MeshFault::Behind { line: index + 1, found });
            }
            (Some(lines), b"endsolid") => {
                lines.extend(b"endsolid\n");
                take(&mut all, &mut Cursor::new(std::mem::take(lines)), most, None)?;
                solid = None;
            }
            (Some(lines), _) => lines.extend(line),
        }
    }
    // Without an end, which is said.
    solid.map_or(Ok(()), |lines| take(&mut all, &mut Cursor::new(lines), most, None))?;
    Ok(all)
}

/// Adds the triangles of a file of one solid, which states the number of its triangles or does not.
fn take(all: &mut Vec<Corners>, file: &mut Cursor<Vec<u8>>, most: usize, stated: Option<u32>) -> Result<(), MeshFault> {
    for triangle in stl_io::create_stl_reader(file)? {
        let number = all.len() + 1;
        let wrong = |words: String| MeshFault::Triangle { triangle: number, words };
        let corners = triangle.map_err(|error| wrong(clip(&error.to_string(), 200)))?.vertices.map(|corner| corner.0);
        if let Some(value) = corners.iter().flatten().find(|value| !value.is_finite()) {
            return Err(wrong(format!("a corner has the coordinate {value}")));
        }
        if number > most {
            let count = stated.map_or(number as u64, u64::from);
            return Err(MeshFault::Many { what: "triangles", count, most: most as u64 });
        }
        all.push(corners);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use arcfeed_testing::Random;

    use super::*;

    /// A binary file of triangles.
    fn binary(head: &[u8], count: u32, corners: &[[f32; 9]]) -> Vec<u8> {
        let mut bytes = head.to_vec();
        bytes.resize(80, b' ');
        bytes.extend(count.to_le_bytes());
        for triangle in corners {
            bytes.extend([0; 12]);
            bytes.extend(triangle.iter().flat_map(|v| v.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    const CORNERS: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.5, 0.0];
    const TEXT: &str =
        "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2.5 0\nendloop\nendfacet\n";

    #[test]
    fn binary_and_text_say_the_same() {
        let corners = vec![[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.5, 0.0]]];
        let whole = format!("{TEXT}endsolid a b\n");
        // Some programs begin a binary file as a text, or add something to its end.
        let padded = [binary(b"made by", 1, &[CORNERS]), vec![0; 7]].concat();
        let files = [whole.into_bytes(), binary(b"made by", 1, &[CORNERS]), binary(b"solid x", 1, &[CORNERS]), padded];
        for bytes in files {
            assert_eq!(triangles(&bytes, 10).expect("a triangle"), corners);
        }
        assert_eq!(triangles(&binary(b"", 0, &[]), 10).expect("none"), Vec::<[[f32; 3]; 3]>::new());
    }

    /// Some programs write a solid for each part, and a solid needs no name.
    #[test]
    fn every_solid_of_a_text_is_read() {
        let second = TEXT.replace("solid a b", "solid").replace("2.5", "3.5");
        let text = format!("{TEXT}endsolid a b\n\n{second}  endsolid\r\n\n");
        let read = triangles(text.as_bytes(), 2).expect("two triangles");
        assert_eq!(read.iter().map(|corners| corners[2][1]).collect::<Vec<_>>(), [2.5, 3.5]);
        assert_eq!(
            triangles(second.replace('\n', "\r\n").as_bytes(), 2).map_err(|e| e.to_string()),
            Err("triangle 2: EOF while expecting facet or endsolid.: export it again".to_owned())
        );
        // A name in another encoding is no text.
        let named = [&b"solid \xe4\n"[..], &TEXT.as_bytes()[10..], b"endsolid \xe4\n"].concat();
        assert_eq!(triangles(&named, 2).expect("a triangle").len(), 1);
    }

    #[test]
    fn a_binary_file_that_begins_as_a_text_may_end_in_anything() {
        for rest in [&[][..], &[0; 7], b"made by a program"] {
            let bytes = [&binary(b"solid x", 1, &[CORNERS])[..], rest].concat();
            assert_eq!(triangles(&bytes, 10).expect("a triangle").len(), 1, "{rest:?}");
        }
    }

    #[test]
    fn what_is_no_mesh_is_refused_in_words() {
        let wrong = |bytes: Vec<u8>| triangles(&bytes, 2).expect_err("no mesh").to_string();
        let mut not_finite = CORNERS;
        not_finite[4] = f32::NAN;
        let whole = binary(b"made by", 2, &[CORNERS; 2]);
        for (bytes, words) in [
            (Vec::new(), "it states 0 triangles, which need 84 bytes, and it has 0"),
            (b"solid x".to_vec(), "triangle 1: EOF"),
            (whole[..whole.len() - 1].to_vec(), "it states 2 triangles, which need 184 bytes, and it has 183"),
            (binary(b"", u32::MAX, &[CORNERS]), "it states 4294967295 triangles"),
            (binary(b"", 1, &[not_finite]), "triangle 1: a corner has the coordinate NaN"),
            (binary(b"", 3, &[CORNERS; 3]), "3 triangles: at most 2 are read"),
            (TEXT.as_bytes().to_vec(), "triangle 2: EOF"),
            (TEXT.replace("2.5", "inf").into_bytes(), "triangle 1: expected finite"),
            (TEXT.replace("2.5", "two").into_bytes(), "triangle 1: invalid float"),
            (format!("{TEXT}endsolid\nfacet normal 0 0 1\n").into_bytes(), "line 10 is \"facet normal 0 0 1\""),
            (format!("{TEXT}endsolid\n{}", TEXT.replace("2.5", "inf")).into_bytes(), "triangle 2: expected finite"),
            (format!("{TEXT}{TEXT}endsolid\n").into_bytes(), "triangle 2: invalid facet header"),
            (format!("{TEXT}endsolid\n").repeat(3).into_bytes(), "3 triangles: at most 2 are read"),
            (binary(b"solid x", 2, &[CORNERS]), "it states 2 triangles, which need 184 bytes, and it has 134"),
            (format!("solid {}", "x ".repeat(1000)).into_bytes(), "2006 bytes in a line: at most 1000"),
            (b"<html>not found</html>".to_vec(), "it was cut off, or is no STL"),
        ] {
            let said = wrong(bytes);
            assert!(said.contains(words), "{said}: {words}");
        }
    }

    /// Whatever bytes come, corners are finite and no more than allowed.
    #[test]
    fn spoilt_files_are_refused_or_read() {
        let mut random = Random::new(1);
        let whole = [binary(b"made by", 3, &[CORNERS; 3]), format!("{TEXT}endsolid a b\n").into_bytes()];
        let mut refused = 0;
        for case in 0..20_000 {
            let mut bytes = whole[case % 2].clone();
            for _ in 0..1 + random.below(4) {
                let at = random.below(bytes.len());
                bytes[at] = random.below(256) as u8;
            }
            bytes.truncate(bytes.len() - random.below(3) * random.below(40));
            match triangles(&bytes, 5) {
                Ok(all) => assert!(all.len() <= 5 && all.iter().flatten().flatten().all(|v| v.is_finite()), "{case}"),
                Err(fault) => refused += usize::from(!fault.to_string().is_empty()),
            }
        }
        assert!((2_000..20_000).contains(&refused), "{refused}");
    }
}
