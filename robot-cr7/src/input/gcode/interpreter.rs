//! Executes blocks: markers, modes and the order in which a block takes effect.

use super::block::Block;
use super::codes::{self, Group};
use super::expression::whole;
use super::fault::{GcodeFault, Located};
use super::modal::Modal;
use super::motion::Motion;
use super::program::{GcodeMarker, GcodeOptions, GcodeProgram, MarkerKind};

/// The state of a program that is being read.
pub(super) struct Interpreter {
    modal: Modal,
    motion: Motion,
    program: GcodeProgram,
    most: usize,
}

impl Interpreter {
    pub(super) fn new(options: &GcodeOptions, file: std::path::PathBuf) -> Self {
        let program = GcodeProgram {
            file,
            start: options.start,
            moves: Vec::new(),
            markers: Vec::new(),
            warnings: Vec::new(),
            lines: 0,
        };
        Self { modal: Modal::new(options.unit), motion: Motion::new(options.start), program, most: options.most_moves }
    }

    /// Keeps the messages of a line.
    pub(super) fn messages(&mut self, line: u64, messages: &mut Vec<String>) {
        for message in messages.drain(..) {
            self.mark(line, MarkerKind::Message(message));
        }
    }

    /// Executes a block. True where it ends the program.
    pub(super) fn execute(&mut self, line: u64, block: &mut Block) -> Result<bool, Located> {
        if block.is_empty() {
            return Ok(false);
        }
        if self.motion.is_open() {
            self.motion.continue_nurbs(block, &mut self.modal, &mut self.program)?;
            return self.finish(block).map(|()| false);
        }
        self.refuse_shared(block)?;
        self.modal.apply(block, self.motion.has_moved())?;
        self.warn_of_modes(line, block);
        self.mark_words(line, block)?;
        self.mark_codes(line, block, false);
        self.dwell(line, block)?;
        self.motion.execute(line, block, &mut self.modal, &mut self.program)?;
        self.mark_codes(line, block, true);
        self.finish(block)?;
        Ok(block.miscellaneous.iter().any(|c| codes::is_end(c.code)))
    }

    /// The program, behind its last block.
    pub(super) fn program(mut self, lines: u64) -> Result<GcodeProgram, Located> {
        self.motion.close(&mut self.program)?;
        self.program.lines = lines;
        Ok(self.program)
    }

    /// Checks of a block that has been executed.
    fn finish(&self, block: &Block) -> Result<(), Located> {
        block.refuse_unused()?;
        if self.program.moves.len() + self.program.markers.len() > self.most {
            return Err(block.fault(GcodeFault::TooMany { limit: self.most }));
        }
        Ok(())
    }

    /// Refuses a word that two codes of the block could take.
    fn refuse_shared(&self, block: &Block) -> Result<(), Located> {
        let modal = self.modal.motion.filter(|_| block.code_of(Group::Motion).is_none() && Motion::continues(block));
        let general = block.general.iter().map(|c| c.code).chain(modal);
        let general = general.map(|code| (codes::name(code), codes::letters_of_general(code)));
        let others = block.miscellaneous.iter().map(|c| c.code);
        let others = others.map(|code| (format!("M{code}"), codes::letters_of_miscellaneous(code)));
        let claims: Vec<_> = general.chain(others).filter(|(_, letters)| !letters.is_empty()).collect();
        if claims.len() < 2 {
            return Ok(());
        }
        for letter in *b"pqelr" {
            let Some(word) = block.word(letter) else { continue };
            let mut takers = claims.iter().filter(|(_, letters)| letters.as_bytes().contains(&letter));
            if let (Some(first), Some(second)) = (takers.next(), takers.next()) {
                return Err(word.fault(GcodeFault::Shared { first: first.0.clone(), second: second.0.clone() }));
            }
        }
        Ok(())
    }

    fn warn_of_modes(&mut self, line: u64, block: &Block) {
        if let Some(code) = block.code_of(Group::CoordinateSystem)
            && code.code != 540
        {
            let name = codes::name(code.code);
            self.program.warnings.push(format!("line {line}: {name} is taken as the workpiece frame"));
        }
        if !self.modal.unit_named && Motion::continues(block) {
            self.modal.unit_named = true;
            let unit = self.modal.unit.symbol();
            let text = format!("line {line}: no G20 or G21 before the first coordinate: lengths are taken in {unit}");
            self.program.warnings.push(text);
        }
    }

    fn mark(&mut self, line: u64, kind: MarkerKind) {
        self.program.markers.push(GcodeMarker { line, after: self.program.moves.len(), kind });
    }

    /// Marks S and T.
    fn mark_words(&mut self, line: u64, block: &mut Block) -> Result<(), Located> {
        if let Some(word) = block.take(b's') {
            self.mark(line, MarkerKind::SpindleSpeed(word.value));
        }
        if let Some(word) = block.take(b't') {
            match whole(word.value) {
                Some(tool) if tool >= 0.0 => self.mark(line, MarkerKind::Tool(tool as u32)),
                _ => return Err(word.refuse("tools have whole numbers from 0", "correct T")),
            }
        }
        Ok(())
    }

    /// Marks the M codes that stop, or the others.
    fn mark_codes(&mut self, line: u64, block: &mut Block, stops: bool) {
        for index in 0..block.miscellaneous.len() {
            let code = block.miscellaneous[index].code;
            if codes::is_stop(code) != stops {
                continue;
            }
            let mut text = format!("M{code}");
            for letter in codes::letters_of_miscellaneous(code).bytes() {
                if let Some(word) = block.take(letter) {
                    text.push_str(&format!(" {}{}", letter.to_ascii_uppercase() as char, word.value));
                }
            }
            self.mark(line, MarkerKind::Code(text));
        }
    }

    fn dwell(&mut self, line: u64, block: &mut Block) -> Result<(), Located> {
        if !block.has_code(40) {
            return Ok(());
        }
        let Some(word) = block.take(b'p') else {
            let needs = "G4 needs its time in seconds";
            return Err(block.code_fault(40, GcodeFault::Missing { needs, remedy: "write P" }));
        };
        if word.value < 0.0 {
            return Err(word.refuse("the time of a dwell is not below 0", "correct P"));
        }
        self.mark(line, MarkerKind::Dwell { seconds: word.value });
        Ok(())
    }
}
