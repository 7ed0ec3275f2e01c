//! Orders to `cr7 send --scenario` on stdin, one a line.

use std::io::{self, BufRead, ErrorKind, Read, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};

use arcfeed_interp::Command;

/// The highest override that is taken, percent.
const MOST_OVERRIDE: f64 = 150.0;
/// The longest line that is taken, bytes.
const LONGEST: u64 = 200;
/// The number of wrong lines that are told. Nobody may read what is said, and a full pipe would stop the reader.
const MOST_TOLD: usize = 20;

/// Values of [`Mailbox::hold`].
const NOTHING: u8 = 0;
const HOLD: u8 = 1;
const RESUME: u8 = 2;

/// The orders that were not taken yet: a stop, the last one of hold and resume, and the last override. Never more, however many came.
#[derive(Debug)]
pub struct Mailbox {
    stop: AtomicBool,
    hold: AtomicU8,
    /// Bits of the override; of a NaN if there is none.
    share: AtomicU64,
}

impl Default for Mailbox {
    fn default() -> Self {
        let share = AtomicU64::new(f64::NAN.to_bits());
        Self { stop: AtomicBool::new(false), hold: AtomicU8::new(NOTHING), share }
    }
}

impl Mailbox {
    /// A mailbox that a thread fills with the lines of stdin.
    pub fn of_stdin() -> Arc<Self> {
        let mailbox = Arc::new(Self::default());
        let filled = mailbox.clone();
        std::thread::spawn(move || filled.fill(io::stdin().lock(), io::stderr()));
        mailbox
    }

    /// The most urgent order that came since: stop, then hold or resume, then override.
    pub fn take(&self) -> Command {
        if self.stop.swap(false, Ordering::SeqCst) {
            return Command::Stop;
        }
        match self.hold.swap(NOTHING, Ordering::SeqCst) {
            HOLD => return Command::Hold,
            RESUME => return Command::Resume,
            _ => {}
        }
        let share = f64::from_bits(self.share.swap(f64::NAN.to_bits(), Ordering::SeqCst));
        if share.is_nan() { Command::None } else { Command::Override(share) }
    }

    fn put(&self, order: &Command) {
        match order {
            Command::Stop => self.stop.store(true, Ordering::SeqCst),
            Command::Hold => self.hold.store(HOLD, Ordering::SeqCst),
            Command::Resume => self.hold.store(RESUME, Ordering::SeqCst),
            Command::Override(share) => self.share.store(share.to_bits(), Ordering::SeqCst),
            _ => {}
        }
    }

    /// Takes in lines until they end, and says what is wrong with them. An end is no order; nor is a fault, which is told.
    fn fill(&self, mut input: impl BufRead, mut said: impl Write) {
        let (mut line, mut wrong) = (Vec::with_capacity(LONGEST as usize + 1), 0);
        loop {
            line.clear();
            let read = input.by_ref().take(LONGEST + 1).read_until(b'\n', &mut line);
            let is_cut = line.len() as u64 > LONGEST && !line.ends_with(b"\n");
            let read = read.and_then(|count| if is_cut { skip_line(&mut input).map(|()| count) } else { Ok(count) });
            match read {
                Ok(0) => return,
                Ok(_) => {}
                Err(error) => {
                    let rest = "no order is taken any more; Ctrl-C stops the arm";
                    let _ = writeln!(said, "cr7: stdin cannot be read ({error}): {rest}");
                    return;
                }
            }
            let text = String::from_utf8_lossy(&line);
            let text = text.trim_end_matches(['\n', '\r']);
            // What is left of a longer line may look like an order.
            match order(text).filter(|_| !is_cut) {
                Some(order) => self.put(&order),
                None => {
                    wrong += 1;
                    tell(&mut said, text, wrong);
                }
            }
        }
    }
}

/// Says that a line is no order; of many such lines the first ones. What nobody hears is no reason to end.
fn tell(said: &mut impl Write, line: &str, wrong: usize) {
    if wrong > MOST_TOLD {
        return;
    }
    let long = if line.len() as u64 > LONGEST { " (cut)" } else { "" };
    let rule = format!("hold, resume, stop, or override with 0 to {MOST_OVERRIDE} percent");
    let _ = writeln!(said, "cr7: {line:?}{long} is no order: {rule}");
    if wrong == MOST_TOLD {
        let _ = writeln!(said, "cr7: further lines that are no orders are not told");
    }
}

/// Skips what is left of a line.
fn skip_line(input: &mut impl BufRead) -> io::Result<()> {
    loop {
        let (count, is_end) = match input.fill_buf() {
            Ok(bytes) => match bytes.iter().position(|byte| *byte == b'\n') {
                Some(place) => (place + 1, true),
                None => (bytes.len(), bytes.is_empty()),
            },
            Err(error) if error.kind() == ErrorKind::Interrupted => (0, false),
            Err(error) => return Err(error),
        };
        input.consume(count);
        if is_end {
            return Ok(());
        }
    }
}

/// What a line orders.
fn order(line: &str) -> Option<Command> {
    let words: Vec<&str> = line.split_whitespace().collect();
    Some(match words[..] {
        ["hold"] => Command::Hold,
        ["resume"] => Command::Resume,
        ["stop"] => Command::Stop,
        ["override", percent] => {
            let percent: f64 = percent.trim_end_matches('%').parse().ok()?;
            Command::Override((0.0..=MOST_OVERRIDE).contains(&percent).then_some(percent / 100.0)?)
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_words_and_a_percentage() {
        assert_eq!(order(" hold "), Some(Command::Hold));
        assert_eq!(order("resume"), Some(Command::Resume));
        assert_eq!(order("stop"), Some(Command::Stop));
        assert_eq!(order("override 50"), Some(Command::Override(0.5)));
        assert_eq!(order("override 0%"), Some(Command::Override(0.0)));
        for wrong in ["", "override", "override -1", "override 151", "override nan", "hold on", "leave"] {
            assert_eq!(order(wrong), None, "{wrong}");
        }
    }

    /// The orders that are left after these bytes, and what was said.
    fn after(bytes: &[u8]) -> (Vec<Command>, String) {
        let (mailbox, mut said) = (Mailbox::default(), Vec::new());
        mailbox.fill(bytes, &mut said);
        let orders = std::iter::from_fn(|| Some(mailbox.take()).filter(|order| *order != Command::None)).collect();
        (orders, String::from_utf8(said).expect("text"))
    }

    #[test]
    fn a_line_that_is_no_text_does_not_end_the_orders() {
        let (orders, said) = after(b"\xff\xfe\nstop");
        assert_eq!(orders, [Command::Stop]);
        assert!(said.contains("is no order") && !said.contains("cannot be read"), "{said}");
    }

    #[test]
    fn an_endless_line_is_skipped_and_many_wrong_lines_are_not_told() {
        let long = [&[b'x'; 1_000_000][..], b"stop\nhold\n"].concat();
        let (orders, said) = after(&long);
        assert_eq!(orders, [Command::Hold]);
        assert!(said.contains("(cut)") && said.len() < 500, "{said}");
        // The longest line that is taken, and one more byte.
        let padded = |count: usize| [&vec![b' '; count - 4][..], b"stop\n"].concat();
        for (count, orders) in [(200, vec![Command::Stop]), (201, vec![]), (202, vec![])] {
            assert_eq!(after(&padded(count)).0, orders, "{count}");
        }
        assert!(after(&b"wrong\n".repeat(100_000)).1.len() < 5_000);
    }

    #[test]
    fn a_stop_comes_first_and_of_the_others_the_last() {
        let many = b"override 10\nhold\n".repeat(1000);
        let (orders, _) = after(&[&many[..], b"stop\nresume\noverride 70\n"].concat());
        assert_eq!(orders, [Command::Stop, Command::Resume, Command::Override(0.7)]);
    }

    /// An input that fails, and nobody who hears what is said.
    struct Broken;

    impl Read for Broken {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::other("the line is cut"))
        }
    }

    impl Write for Broken {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::Error::other("nobody listens"))
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_fault_of_stdin_is_told_and_a_closed_stderr_ends_nothing() {
        let (mailbox, mut said) = (Mailbox::default(), Vec::new());
        mailbox.fill(io::BufReader::new(Broken), &mut said);
        let said = String::from_utf8(said).expect("text");
        assert!(said.contains("the line is cut") && said.contains("Ctrl-C"), "{said}");
        mailbox.fill(&b"nonsense\nstop\n"[..], Broken);
        assert_eq!(mailbox.take(), Command::Stop);
    }
}
