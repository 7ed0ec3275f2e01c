//! Ends a program whose present input takes too long or too much.

use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// The most memory that a program may take for one input, bytes.
pub const MOST_BYTES: u64 = 500 << 20;
/// An input that waits takes no processor time: so many times the time of the processor may pass on the clock.
const CLOCK: f64 = 20.0;
/// No input.
const NONE: u64 = u64::MAX;
/// How often it looks.
const EVERY: Duration = Duration::from_millis(20);
/// Size of a page of memory, bytes, and ticks of the processor clock in a second: what Linux tells in its files.
const PAGE: u64 = 4096;
const TICKS: f64 = 100.0;

/// Looks at the program from a thread of its own.
#[derive(Debug, Clone)]
pub struct Watchdog {
    input: Arc<AtomicU64>,
}

impl Watchdog {
    /// Watches from now on: an input may take `seconds` of the processor (of the clock, where the system tells no other time), and 20 times
    /// as much of the clock. `ends` is called with the input and the reason, and has to end the program.
    pub fn new(seconds: f64, ends: impl Fn(u64, &str) + Send + 'static) -> Self {
        let input = Arc::new(AtomicU64::new(NONE));
        let watched = Arc::clone(&input);
        let begin = Instant::now();
        let base = held();
        thread::spawn(move || {
            let used = || processor().unwrap_or_else(|| begin.elapsed().as_secs_f64());
            let mut seen = (NONE, used(), Instant::now());
            loop {
                thread::sleep(EVERY);
                let now = watched.load(Ordering::Relaxed);
                if now != seen.0 {
                    seen = (now, used(), Instant::now());
                } else if now == NONE {
                    // Nothing has begun.
                } else if used() - seen.1 > seconds {
                    ends(now, &format!("takes more than {seconds} s"));
                } else if seen.2.elapsed().as_secs_f64() > CLOCK * seconds {
                    ends(now, &format!("takes more than {} s of the clock", CLOCK * seconds));
                }
                if held() > base + MOST_BYTES {
                    ends(now, &format!("takes more than {} MB", MOST_BYTES >> 20));
                }
            }
        });
        Self { input }
    }

    /// The next input begins.
    pub fn begins(&self, input: u64) {
        self.input.store(input, Ordering::Relaxed);
    }

    /// No input is being fed.
    pub fn rests(&self) {
        self.input.store(NONE, Ordering::Relaxed);
    }
}

/// Memory of the program, bytes; 0 where the system does not tell.
fn held() -> u64 {
    let pages = |text: String| text.split_whitespace().nth(1)?.parse::<u64>().ok();
    fs::read_to_string("/proc/self/statm").ok().and_then(pages).unwrap_or(0) * PAGE
}

/// Processor time of the program, s.
fn processor() -> Option<f64> {
    let text = fs::read_to_string("/proc/self/stat").ok()?;
    // Behind the name, which may hold blanks: the state is the third field, the times are fields 14 and 15.
    let mut fields = text.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / TICKS)
}
