//! Triangles of an STL file, binary or text.

use std::io::Cursor;

use super::fault::MeshFault;

/// Bytes before the triangles of a binary file: a header and their number.
const HEAD: usize = 84;
/// Bytes of a triangle of a binary file.
const TRIANGLE: u64 = 50;
/// Longest line of a text, bytes.
const MOST_LINE: usize = 1000;
/// What a text begins with, and some binary files, too.
const SOLID: &[u8] = b"solid";

/// The corners of each triangle, in the unit of the file; at most `most` of them.
///
/// # Errors
/// [`MeshFault`] for what is no STL, or not finite.
pub(super) fn triangles(mut bytes: Vec<u8>, most: usize) -> Result<Vec<[[f32; 3]; 3]>, MeshFault> {
    let stated = bytes.get(HEAD - 4..HEAD).and_then(|count| Some(u32::from_le_bytes(count.try_into().ok()?)));
    let (length, stated) = (bytes.len() as u64, stated.unwrap_or_default());
    let needed = HEAD as u64 + TRIANGLE * u64::from(stated);
    let is_text = bytes.starts_with(SOLID) && needed != length;
    if is_text {
        if let Some(line) = bytes.split(|byte| *byte == b'\n').find(|line| line.len() > MOST_LINE) {
            let (count, most) = (line.len() as u64, MOST_LINE as u64);
            return Err(MeshFault::Many { what: "bytes in a line", count, most });
        }
    } else if length < needed.max(HEAD as u64) {
        return Err(MeshFault::Length { triangles: stated, needed, bytes: length });
    } else {
        // A header that looks like a text is none.
        bytes[..SOLID.len()].fill(0);
    }
    let mut bytes = Cursor::new(bytes);
    let mut all = Vec::new();
    for (index, triangle) in stl_io::create_stl_reader(&mut bytes)?.enumerate() {
        let wrong = |words: String| MeshFault::Triangle { triangle: index + 1, words };
        let corners = triangle.map_err(|error| wrong(error.to_string()))?.vertices.map(|corner| corner.0);
        if let Some(value) = corners.iter().flatten().find(|value| !value.is_finite()) {
            return Err(wrong(format!("a corner has the coordinate {value}")));
        }
        if index == most {
            let count = if is_text { index as u64 + 1 } else { u64::from(stated) };
            return Err(MeshFault::Many { what: "triangles", count, most: most as u64 });
        }
        all.push(corners);
    }
    Ok(all)
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
            assert_eq!(triangles(bytes, 10).expect("a triangle"), corners);
        }
        assert_eq!(triangles(binary(b"", 0, &[]), 10).expect("none"), Vec::<[[f32; 3]; 3]>::new());
    }

    #[test]
    fn what_is_no_mesh_is_refused_in_words() {
        let wrong = |bytes: Vec<u8>| triangles(bytes, 2).expect_err("no mesh").to_string();
        let mut not_finite = CORNERS;
        not_finite[4] = f32::NAN;
        let whole = binary(b"made by", 2, &[CORNERS; 2]);
        for (bytes, words) in [
            (Vec::new(), "it states 0 triangles, which need 84 bytes, and it has 0"),
            (whole[..whole.len() - 1].to_vec(), "it states 2 triangles, which need 184 bytes, and it has 183"),
            (binary(b"", u32::MAX, &[CORNERS]), "it states 4294967295 triangles"),
            (binary(b"", 1, &[not_finite]), "triangle 1: a corner has the coordinate NaN"),
            (binary(b"", 3, &[CORNERS; 3]), "3 triangles: at most 2 are read"),
            (TEXT.as_bytes().to_vec(), "triangle 2: EOF"),
            (TEXT.replace("2.5", "inf").into_bytes(), "triangle 1: expected finite"),
            (TEXT.replace("2.5", "two").into_bytes(), "triangle 1: invalid float"),
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
            match triangles(bytes, 5) {
                Ok(all) => assert!(all.len() <= 5 && all.iter().flatten().flatten().all(|v| v.is_finite()), "{case}"),
                Err(fault) => refused += usize::from(!fault.to_string().is_empty()),
            }
        }
        assert!((2_000..20_000).contains(&refused), "{refused}");
    }
}
