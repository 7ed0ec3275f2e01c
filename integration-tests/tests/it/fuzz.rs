//! Some arbitrary inputs for every reader and planner, and all that are kept: none is a defect. The example `fuzz` feeds millions.

use integration_tests::fuzz::{Judged, MOST_BYTES, TARGETS, Verdict};

/// Inputs of each target; planners of paths take tenths of a second.
fn count(seconds: f64) -> u64 {
    if seconds > 1.0 { 3 } else { 400 }
}

fn check(what: &str, judged: &Judged) {
    if let Verdict::Broken(words) = &judged.verdict {
        panic!("{what}: {words}");
    }
    assert!(judged.bytes < MOST_BYTES as usize, "{what} takes {} bytes", judged.bytes);
}

#[test]
fn arbitrary_inputs_are_accepted_or_refused_in_bounded_memory() {
    for target in TARGETS {
        let found = target.find();
        assert!(found.has_seeds(), "{} has no samples", target.name);
        let (mut accepted, mut refused) = (0, 0);
        for seed in 0..count(target.seconds) {
            let judged = found.feed(seed);
            check(&format!("{} --seed {seed} --count 1", target.name), &judged);
            accepted += u64::from(judged.verdict == Verdict::Accepted);
            refused += u64::from(judged.verdict == Verdict::Refused);
        }
        // Inputs that are all alike would test nothing.
        let few = target.seconds > 1.0;
        assert!(few || (accepted > 0 && refused > 0), "{}: {accepted} accepted, {refused} refused", target.name);
    }
}

#[test]
fn inputs_that_were_defects_once_are_none_any_more() {
    let mut count = 0;
    for target in TARGETS {
        for (name, input) in target.kept() {
            check(&format!("corpus/{}/{name}", target.name), &target.feed(&input));
            count += 1;
        }
    }
    println!("{count} inputs");
}
