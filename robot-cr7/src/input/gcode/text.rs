//! Lines of a program without blanks, case and comments.

use std::io::{self, BufRead, Read};

use super::fault::{GcodeFault, Located};

/// Most bytes of a line. LinuxCNC takes 255.
pub(super) const MOST_LINE_BYTES: usize = 4096;

/// The lines of a stream, one at a time in one buffer.
pub(super) struct Lines<R> {
    reader: R,
    buffer: Vec<u8>,
    /// Number of the line read last, from 1.
    pub(super) number: u64,
}

impl<R: BufRead> Lines<R> {
    pub(super) fn new(reader: R) -> Self {
        Self { reader, buffer: Vec::with_capacity(256), number: 0 }
    }

    /// The next line without its end, or `None` behind the last; `Some(Err(..))` where it is too long.
    pub(super) fn next(&mut self) -> io::Result<Option<Result<&[u8], Located>>> {
        self.buffer.clear();
        let most = MOST_LINE_BYTES as u64 + 2;
        if (&mut self.reader).take(most).read_until(b'\n', &mut self.buffer)? == 0 {
            return Ok(None);
        }
        self.number += 1;
        let mut line = self.buffer.as_slice();
        line = line.strip_suffix(b"\n").unwrap_or(line);
        line = line.strip_suffix(b"\r").unwrap_or(line);
        if self.number == 1 {
            line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
        }
        if line.len() > MOST_LINE_BYTES {
            let fault = GcodeFault::LineLength { limit: MOST_LINE_BYTES };
            return Ok(Some(Err(Located::new(MOST_LINE_BYTES + 1, "the line", fault))));
        }
        Ok(Some(Ok(line)))
    }
}

/// A line in lower case without blanks and comments. Its buffers serve every line of a program.
#[derive(Debug, Default)]
pub(super) struct Text {
    bytes: Vec<u8>,
    columns: Vec<usize>,
    end: usize,
    /// Texts of the comments `(MSG, ...)`.
    pub(super) messages: Vec<String>,
    /// True where the line starts with `/`.
    pub(super) deleted: bool,
}

impl Text {
    /// Takes over the next line.
    pub(super) fn scan(&mut self, line: &[u8]) -> Result<(), Located> {
        self.bytes.clear();
        self.columns.clear();
        self.messages.clear();
        self.deleted = false;
        let mut column = 0;
        let mut at = 0;
        while at < line.len() {
            column += 1;
            let byte = line[at];
            match byte {
                b' ' | b'\t' => {}
                b'(' => {
                    let comment = bracketed_comment(&line[at..], column)?;
                    self.note(&comment[1..comment.len() - 1]);
                    at += comment.len() - 1;
                    column += characters(comment) - 1;
                }
                b';' => {
                    self.note(&line[at + 1..]);
                    column += characters(&line[at..]) - 1;
                    at = line.len() - 1;
                }
                b'/' if self.bytes.is_empty() && !self.deleted => self.deleted = true,
                b'!'..=b'~' => {
                    self.bytes.push(byte.to_ascii_lowercase());
                    self.columns.push(column);
                }
                _ => return Err(stray(&line[at..], column)),
            }
            at += 1;
        }
        self.end = column + 1;
        Ok(())
    }

    /// The bytes, in lower case and without blanks.
    pub(super) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Column of the byte `at`, or that behind the line.
    pub(super) fn column(&self, at: usize) -> usize {
        self.columns.get(at).copied().unwrap_or(self.end)
    }

    /// The text from `start` to before `end` in upper case, for messages.
    pub(super) fn word(&self, start: usize, end: usize) -> String {
        let end = end.min(self.bytes.len());
        let word: String = self.bytes[start.min(end)..end].iter().map(|b| b.to_ascii_uppercase() as char).collect();
        if word.is_empty() { "the end of the line".to_owned() } else { word }
    }

    /// Keeps the text of a comment that is a message.
    fn note(&mut self, comment: &[u8]) {
        let comment = comment.trim_ascii();
        if comment.len() >= 4 && comment[..4].eq_ignore_ascii_case(b"msg,") {
            self.messages.push(String::from_utf8_lossy(comment[4..].trim_ascii()).into_owned());
        }
    }
}

/// The comment at the start of `rest`, with both brackets.
fn bracketed_comment(rest: &[u8], column: usize) -> Result<&[u8], Located> {
    let syntax = |rule, remedy| Located::new(column, "(", GcodeFault::Syntax { rule, remedy });
    match rest[1..].iter().position(|&b| b == b')' || b == b'(') {
        Some(i) if rest[i + 1] == b')' => Ok(&rest[..i + 2]),
        Some(_) => Err(syntax("a comment holds another \"(\"", "remove the inner brackets")),
        None => Err(syntax("the comment has no end on this line", "add \")\"")),
    }
}

/// Number of characters of UTF-8 text, never 0 for a text that is not empty.
fn characters(text: &[u8]) -> usize {
    text.iter().filter(|&&b| b & 0xC0 != 0x80).count().max(1)
}

fn stray(rest: &[u8], column: usize) -> Located {
    let text = String::from_utf8_lossy(&rest[..rest.len().min(4)]);
    let found = text.chars().next().map(|c| c.escape_debug().to_string()).unwrap_or_default();
    let rule = "only plain ASCII characters stand outside of comments";
    Located::new(column, found, GcodeFault::Syntax { rule, remedy: "remove the character" })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scanned(line: &str) -> Text {
        let mut text = Text::default();
        text.scan(line.as_bytes()).expect("the line is text");
        text
    }

    #[test]
    fn blanks_case_and_comments_vanish_and_columns_stay() {
        let text = scanned("  g 1 X+0. 12 34Y 7 (é;) z1; (x");
        assert_eq!(text.bytes(), b"g1x+0.1234y7z1");
        let z = text.bytes().iter().position(|&b| b == b'z').expect("z is there");
        assert_eq!(text.column(z), 26);
        assert_eq!(text.column(99), 32);
        assert!(!text.deleted);
    }

    #[test]
    fn messages_and_block_delete() {
        let text = scanned(" / G0 (msg, Hello ) (other) ; MSG,second");
        assert!(text.deleted);
        assert_eq!(text.messages, ["Hello", "second"]);
        assert_eq!(text.bytes(), b"g0");
        assert_eq!(scanned("X[1/2]").bytes(), b"x[1/2]");
    }

    #[test]
    fn bad_comments_and_characters_have_their_column() {
        let fails = |line: &[u8]| Text::default().scan(line).expect_err("the line is bad");
        assert_eq!(fails(b"G1 (a (b)").column, 4);
        assert_eq!(fails(b"G1 (a").column, 4);
        assert_eq!(fails("é".as_bytes()).word, "é");
        assert_eq!(fails("(é) \u{1}".as_bytes()).column, 5);
        assert_eq!(fails(b"\xff").column, 1);
    }

    #[test]
    fn lines_end_in_either_way_and_have_a_longest_length() {
        let mut lines = Lines::new(&b"\xef\xbb\xbfa\r\nb\nc"[..]);
        for (number, expected) in [(1, b"a"), (2, b"b"), (3, b"c")] {
            let line = lines.next().expect("no error").expect("a line").expect("short").to_owned();
            assert_eq!(line, expected);
            assert_eq!(lines.number, number);
        }
        assert!(lines.next().expect("no error").is_none());
        let fits = vec![b'x'; MOST_LINE_BYTES];
        assert!(Lines::new(&fits[..]).next().expect("no error").expect("a line").is_ok());
        let long = vec![b'x'; MOST_LINE_BYTES + 1];
        assert!(Lines::new(&long[..]).next().expect("no error").expect("a line").is_err());
    }
}
