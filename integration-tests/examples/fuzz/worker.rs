//! Feeds inputs, and says what was found in lines that the watching process reads.

use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};

use integration_tests::fuzz::{Judged, Verdict, Watchdog};

use crate::options::Options;

/// Exit code of a process whose watchdog ended it.
pub const ENDED: i32 = 3;

/// What was counted and not yet said. The watchdog says it, too, before it ends the process.
static COUNTS: Counts = Counts {
    accepted: AtomicU64::new(0),
    refused: AtomicU64::new(0),
    slowest_us: AtomicU64::new(0),
    most_bytes: AtomicU64::new(0),
};

struct Counts {
    accepted: AtomicU64,
    refused: AtomicU64,
    slowest_us: AtomicU64,
    most_bytes: AtomicU64,
}

impl Counts {
    fn take(&self, judged: &Judged) {
        match judged.verdict {
            Verdict::Accepted => self.accepted.fetch_add(1, Ordering::Relaxed),
            Verdict::Refused => self.refused.fetch_add(1, Ordering::Relaxed),
            Verdict::Broken(_) => 0,
        };
        self.slowest_us.fetch_max(judged.time.as_micros() as u64, Ordering::Relaxed);
        self.most_bytes.fetch_max(judged.bytes as u64, Ordering::Relaxed);
    }

    fn say(&self) {
        let [accepted, refused, slowest, most] =
            [&self.accepted, &self.refused, &self.slowest_us, &self.most_bytes].map(|n| n.swap(0, Ordering::Relaxed));
        println!("done {accepted} {refused} {slowest} {most}");
    }
}

pub fn run(options: &Options) -> ExitCode {
    let Some(target) = options.targets.first() else { return ExitCode::from(2) };
    std::panic::set_hook(Box::new(|_| {}));
    let found = target.find();
    let watchdog = Watchdog::new(target.seconds, |seed, why| {
        COUNTS.say();
        println!("ended {seed} {why}");
        std::process::exit(ENDED);
    });
    for seed in options.seed..options.seed + options.count {
        if options.trace {
            // Whatever ends the process, what came before has been said.
            COUNTS.say();
            println!("feeds {seed}");
        }
        watchdog.begins(seed);
        let judged = found.feed(seed);
        COUNTS.take(&judged);
        if let Verdict::Broken(words) = judged.verdict {
            println!("broken {seed} {}", words.replace('\n', " "));
        }
    }
    watchdog.rests();
    COUNTS.say();
    ExitCode::SUCCESS
}
