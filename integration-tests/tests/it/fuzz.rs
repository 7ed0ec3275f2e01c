//! Some arbitrary inputs for every target, and all that are kept: none is a defect. The example `fuzz` feeds millions.

use std::path::Path;

use integration_tests::fuzz::{Judged, TARGETS, Target, Verdict};

/// Inputs of each target; planners of paths take tenths of a second.
fn count(seconds: f64) -> u64 {
    if seconds > 1.0 { 3 } else { 400 }
}

/// The clock of a loaded machine may show so many times the processor time of a target.
const LOADED: f64 = 20.0;

fn check(what: &str, target: &Target, judged: &Judged) {
    if let Verdict::Broken(words) = &judged.verdict {
        panic!("{what}: {words}");
    }
    let seconds = judged.time.as_secs_f64();
    assert!(seconds < LOADED * target.seconds, "{what} takes {seconds} s");
}

#[test]
fn arbitrary_inputs_are_accepted_or_refused_in_bounded_memory() {
    for target in TARGETS {
        let found = target.find();
        assert!(found.has_seeds(), "{} has no samples", target.name);
        let (mut accepted, mut refused) = (0, 0);
        for seed in 0..count(target.seconds) {
            let judged = found.feed(seed);
            check(&format!("{} --seed {seed} --count 1", target.name), target, &judged);
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
            check(&format!("corpus/{}/{name}", target.name), target, &target.feed(&input));
            count += 1;
        }
    }
    assert!(count > 0, "no input is kept");
    // Each folder belongs to a target, and none was passed over.
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    let mut kept = 0;
    for folder in std::fs::read_dir(corpus).expect("the corpus").map(|entry| entry.expect("a folder").path()) {
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let of_meshes = ["stl", "urdf-meshes"].contains(&name.as_str());
        if cfg!(not(feature = "controller")) && name == "controller" || cfg!(not(feature = "html")) && of_meshes {
            continue;
        }
        assert!(TARGETS.iter().any(|target| target.name == name), "corpus/{name} is of no target");
        kept += std::fs::read_dir(folder).expect("a folder").count();
    }
    assert_eq!(count, kept);
}

/// A key of 39 000 letters was repeated as a whole.
#[test]
fn messages_repeat_only_the_beginning_of_long_texts() {
    let long = "x".repeat(50_000);
    let texts = [
        ("json-path", format!("{{\"{long}\": 1}}")),
        ("json-path", format!("{{\"units\": \"{long}\", \"degree\": 1, \"control_points\": [[0, 0], [1, 1]]}}")),
        ("csv-points", format!("x_{long},y_mm\n1,2\n")),
        ("csv-points", format!("x_mm,{long}\n1,2\n")),
        ("csv-points", format!("x_mm,y_mm\n1,{long}\n")),
        ("gcode", format!("G1 ({long}\n")),
        ("job", format!("{long} = 1\n")),
        ("job", format!("[feed]\nfeed_mm_s = \"{long}\"\n")),
        ("scenario", format!("[{long}]\n")),
        ("schedule", format!("[{long}]\n")),
        ("urdf", format!("<robot name='a'><joint name='{long}' type='{long}'/></robot>")),
        ("urdf", format!("<robot name='a'><{long}></robot>")),
        ("arm-json", format!("{{\"format\": \"{long}\", \"name\": \"a\", \"joints\": []}}")),
        ("trajectory-csv", format!("{long}\n1\n")),
        ("compiled-json", format!("{{\"{long}\": 1}}")),
        ("batch-line", format!("{{\"{long}\": 1}}")),
    ];
    for (name, text) in texts {
        let target = TARGETS.iter().find(|target| target.name == name).expect("a target");
        let verdict = target.feed(text.as_bytes()).verdict;
        assert!(matches!(verdict, Verdict::Refused), "{name}: {verdict:?} for {}", &text[..40.min(text.len())]);
    }
}
