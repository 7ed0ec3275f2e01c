//! Feeds inputs, and says what was found in lines that the watching process reads.

use std::process::ExitCode;

use integration_tests::fuzz::{Verdict, Watchdog};

use crate::options::Options;

/// Exit code of a process whose watchdog ended it.
pub const ENDED: i32 = 3;

pub fn run(options: &Options) -> ExitCode {
    let Some(target) = options.targets.first() else { return ExitCode::from(2) };
    std::panic::set_hook(Box::new(|_| {}));
    let found = target.find();
    let watchdog = Watchdog::new(target.seconds, |seed, why| {
        println!("ended {seed} {why}");
        std::process::exit(ENDED);
    });
    let (mut accepted, mut refused, mut slowest, mut most) = (0u64, 0u64, (0u128, 0), 0);
    for seed in options.seed..options.seed + options.count {
        if options.trace {
            println!("feeds {seed}");
        }
        watchdog.begins(seed);
        let judged = found.feed(seed);
        slowest = slowest.max((judged.time.as_micros(), seed));
        most = most.max(judged.bytes);
        match judged.verdict {
            Verdict::Accepted => accepted += 1,
            Verdict::Refused => refused += 1,
            Verdict::Broken(words) => println!("broken {seed} {}", words.replace('\n', " ")),
        }
    }
    println!("done {accepted} {refused} {} {} {most}", slowest.0, slowest.1);
    ExitCode::SUCCESS
}
