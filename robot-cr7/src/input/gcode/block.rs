//! One block: the words of a line.

use super::codes;
use super::expression::{Cursor, LARGEST_WORD, Parameters, whole};
use super::fault::{GcodeFault, Located};
use super::text::Text;

/// A word other than N, G and M.
#[derive(Debug, Clone, Copy)]
pub(super) struct Word {
    pub(super) letter: u8,
    pub(super) value: f64,
    pub(super) column: usize,
    used: bool,
}

impl Word {
    /// A fault of this word.
    pub(super) fn fault(&self, fault: GcodeFault) -> Located {
        Located::new(self.column, format!("{}{}", self.letter.to_ascii_uppercase() as char, self.value), fault)
    }

    /// A fault of its value.
    pub(super) fn refuse(&self, rule: &'static str, remedy: &'static str) -> Located {
        self.fault(GcodeFault::Value { value: self.value, rule, remedy })
    }
}

/// A G code (in tenths) or an M code, with its column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Code {
    pub(super) code: u16,
    pub(super) column: usize,
}

/// The words of a line. Its buffers serve every line of a program.
#[derive(Debug, Default)]
pub(super) struct Block {
    /// Number of the N word.
    pub(super) number: Option<u32>,
    /// G codes in tenths.
    pub(super) general: Vec<Code>,
    /// M codes.
    pub(super) miscellaneous: Vec<Code>,
    words: [Option<Word>; 26],
    /// Column and text of the first word, for faults of the whole block.
    first: (usize, String),
}

impl Block {
    /// Takes over the words of `text`. Assignments are left pending in `parameters`.
    pub(super) fn read(&mut self, text: &Text, parameters: &mut Parameters) -> Result<(), Located> {
        self.number = None;
        self.general.clear();
        self.miscellaneous.clear();
        self.words = [None; 26];
        self.first.0 = 0;
        let mut cursor = Cursor { text, at: 0, parameters };
        while cursor.at < text.bytes().len() {
            let start = cursor.at;
            match cursor.peek() {
                b'#' => cursor.assignment()?,
                b'o' => return self.program_number(&mut cursor),
                letter @ b'a'..=b'z' => {
                    cursor.at += 1;
                    let value = cursor.value(0).map_err(|e| with_letter(e, &cursor, start))?;
                    if value.abs() > LARGEST_WORD {
                        let rule = "words are between -1e9 and 1e9";
                        return Err(
                            cursor.fault(start, GcodeFault::Value { value, rule, remedy: "correct the number" })
                        );
                    }
                    self.add(Word { letter, value, column: text.column(start), used: false }, &cursor, start)?;
                }
                _ => {
                    let rule = "a word starts with a letter";
                    let remedy = "write words such as X1.5, or put the text into a comment";
                    return Err(cursor.fault(start, GcodeFault::Syntax { rule, remedy }));
                }
            }
            if self.first.0 == 0 {
                self.first = (text.column(start), text.word(start, cursor.at));
            }
        }
        Ok(())
    }

    fn add(&mut self, word: Word, cursor: &Cursor, start: usize) -> Result<(), Located> {
        let value = word.value;
        match word.letter {
            b'g' | b'm' => {
                let scale = if word.letter == b'g' { 10.0 } else { 1.0 };
                let code = match whole(value * scale) {
                    Some(code) if (0.0..=9999.0).contains(&code) => code as u16,
                    _ => return Err(cursor.fault(start, GcodeFault::UnknownCode)),
                };
                self.add_code(word.letter == b'g', Code { code, column: word.column })
            }
            b'n' => {
                if self.number.is_some() {
                    return Err(cursor.fault(start, GcodeFault::Repeated { first: self.first.0 }));
                }
                match whole(value) {
                    Some(number) if number >= 0.0 => self.number = Some(number as u32),
                    _ => return Err(word.refuse("line numbers are whole numbers from 0", "correct or remove it")),
                }
                Ok(())
            }
            b'u' | b'v' | b'w' => {
                let what = "an axis U, V or W";
                Err(word.fault(GcodeFault::Unsupported { what, remedy: "post-process for the axes X Y Z A B C" }))
            }
            letter => {
                let place = &mut self.words[usize::from(letter - b'a')];
                if let Some(other) = place {
                    return Err(word.fault(GcodeFault::Repeated { first: other.column }));
                }
                *place = Some(word);
                Ok(())
            }
        }
    }

    fn add_code(&mut self, general: bool, code: Code) -> Result<(), Located> {
        let (names, others): (fn(u16) -> String, _) =
            if general { (codes::name, &mut self.general) } else { (|m| format!("M{m}"), &mut self.miscellaneous) };
        let group_of = if general { codes::general } else { codes::miscellaneous };
        let located = |fault| Located::new(code.column, names(code.code), fault);
        let group = group_of(code.code).map_err(located)?;
        // G80 may stand beside the code of a motion, which it does not disturb.
        let clash = |other: &&Code| {
            let cancels = general && (other.code == 800) != (code.code == 800);
            group_of(other.code) == Ok(group) && group != codes::Group::NonModal && !cancels
        };
        if let Some(other) = others.iter().find(clash) {
            return Err(located(GcodeFault::ModalGroup { other: names(other.code), group: group.sets() }));
        }
        if others.contains(&code) || others.iter().any(|o| o.code == code.code) {
            return Err(located(GcodeFault::ModalGroup { other: names(code.code), group: "the same" }));
        }
        others.push(code);
        Ok(())
    }

    /// A line `O1234` is the number of the program. Every other O word is refused.
    fn program_number(&mut self, cursor: &mut Cursor) -> Result<(), Located> {
        let start = cursor.at;
        cursor.at += 1;
        while cursor.peek().is_ascii_digit() {
            cursor.at += 1;
        }
        let alone = cursor.at > start + 1 && cursor.at == cursor.text.bytes().len() && self.is_empty();
        if alone {
            return Ok(());
        }
        cursor.at = cursor.text.bytes().len();
        let what = "a subroutine, branch or loop (O word)";
        let remedy = "post-process into single moves";
        Err(cursor.fault(start, GcodeFault::Unsupported { what, remedy }))
    }

    /// True where the block has no word beside N.
    pub(super) fn is_empty(&self) -> bool {
        self.general.is_empty() && self.miscellaneous.is_empty() && self.words.iter().all(Option::is_none)
    }

    /// The word with this letter.
    pub(super) fn word(&self, letter: u8) -> Option<&Word> {
        self.words[usize::from(letter - b'a')].as_ref()
    }

    /// The word with this letter, marked as used.
    pub(super) fn take(&mut self, letter: u8) -> Option<Word> {
        let word = self.words[usize::from(letter - b'a')].as_mut()?;
        word.used = true;
        Some(*word)
    }

    /// True where the block has a word with one of the `letters`.
    pub(super) fn has_any(&self, letters: &[u8]) -> bool {
        letters.iter().any(|&letter| self.word(letter).is_some())
    }

    /// True where the block holds this G code, in tenths.
    pub(super) fn has_code(&self, tenths: u16) -> bool {
        self.general.iter().any(|c| c.code == tenths)
    }

    /// The code of a group of G codes.
    pub(super) fn code_of(&self, group: codes::Group) -> Option<Code> {
        self.general.iter().find(|c| codes::general(c.code) == Ok(group)).copied()
    }

    /// Refuses the first word that nothing has used.
    pub(super) fn refuse_unused(&self) -> Result<(), Located> {
        let unused = self.words.iter().flatten().filter(|w| !w.used).min_by_key(|w| w.column);
        unused.map_or(Ok(()), |word| Err(word.fault(GcodeFault::Unused)))
    }

    /// A fault of the whole block, at its first word.
    pub(super) fn fault(&self, fault: GcodeFault) -> Located {
        Located::new(self.first.0.max(1), self.first.1.clone(), fault)
    }

    /// A fault of a G code of the block, or of the whole block where the code stands in an earlier one.
    pub(super) fn code_fault(&self, tenths: u16, fault: GcodeFault) -> Located {
        match self.general.iter().find(|c| c.code == tenths) {
            Some(code) => Located::new(code.column, codes::name(tenths), fault),
            None => self.fault(fault),
        }
    }
}

/// A fault of a value, told with the letter of its word where the value starts right behind it.
fn with_letter(mut located: Located, cursor: &Cursor, start: usize) -> Located {
    if located.column == cursor.text.column(start + 1) {
        located.column = cursor.text.column(start);
        located.word = cursor.text.word(start, cursor.at.max(start + 1));
    }
    located
}
