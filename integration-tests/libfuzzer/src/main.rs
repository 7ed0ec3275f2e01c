//! One target of `integration_tests::fuzz`, named by `ARCFEED_TARGET`, fed by libFuzzer. `run.sh` builds and starts it.
//!
//! libFuzzer keeps the inputs that reach code that none before has reached. Some of its changes are those of the other search, which know
//! lines, words and numbers. An input that is a defect ends the program, and libFuzzer saves it.
#![no_main]

use std::process::abort;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

use arcfeed_testing::Counting;
use integration_tests::fuzz::{Found, Target, Verdict, Watchdog, target};
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

static TARGET: LazyLock<Target> = LazyLock::new(|| {
    let name = std::env::var("ARCFEED_TARGET").unwrap_or_default();
    target(&name).unwrap_or_else(|| {
        eprintln!("ARCFEED_TARGET={name:?}: no such target");
        std::process::exit(2);
    })
});
static FOUND: LazyLock<Found> = LazyLock::new(|| TARGET.find());
static WATCHDOG: LazyLock<Watchdog> = LazyLock::new(|| {
    Watchdog::new(TARGET.seconds, |_, why| {
        eprintln!("{}: {why}", TARGET.name);
        abort();
    })
});
static FED: AtomicU64 = AtomicU64::new(0);

fuzz_target!(|input: &[u8]| {
    WATCHDOG.begins(FED.fetch_add(1, Ordering::Relaxed));
    let judged = TARGET.feed(input);
    WATCHDOG.rests();
    if let Verdict::Broken(words) = judged.verdict {
        eprintln!("{}: {words}", TARGET.name);
        abort();
    }
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let changed = match seed % 4 {
        0 => Some(FOUND.input(seed.into())),
        1 | 2 => FOUND.changed(&data[..size], seed.into()),
        _ => None,
    };
    let Some(changed) = changed else { return fuzzer_mutate(data, size, max_size) };
    let length = changed.len().min(max_size);
    data[..length].copy_from_slice(&changed[..length]);
    length
});
