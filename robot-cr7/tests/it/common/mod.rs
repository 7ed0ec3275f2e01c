//! A desk to run the command on.
#![allow(dead_code, reason = "every test uses some of it")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use robot_cr7::{TrajectoryRow, read_trajectory};
use serde_json::Value;

/// The command under test; the variable CR7 names another build of it, such as an optimised or an earlier one.
pub fn binary() -> String {
    std::env::var("CR7").unwrap_or_else(|_| env!("CARGO_BIN_EXE_cr7").to_owned())
}

/// A folder of its own for one test, empty.
pub struct Desk {
    pub folder: PathBuf,
}

impl Desk {
    pub fn new(test: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("a writable target folder");
        Self { folder }
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.folder.join(name), text).expect("a writable target folder");
    }

    pub fn run(&self, args: &[&str]) -> Run {
        let output = Command::new(binary()).args(args).current_dir(&self.folder).output().expect("the binary runs");
        Run::new(args, output)
    }

    pub fn trajectory<const N: usize>(&self, out: &str) -> Vec<TrajectoryRow<N>> {
        let file = self.folder.join(out).join("trajectory.csv");
        let bytes = std::fs::read(&file).expect("a trajectory was written");
        read_trajectory(bytes.as_slice(), &file).expect("a readable trajectory")
    }
}

/// What one run of the command gave.
pub struct Run {
    pub command: String,
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Run {
    pub fn new(args: &[&str], output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("plain text");
        // A loaded machine brings signs of life that an idle one does not.
        let stderr = text(output.stderr);
        let alive = |line: &&str| line.starts_with("cr7: ") && line.ends_with(" s so far\n");
        let run = Self {
            command: format!("cr7 {}", args.join(" ")),
            code: output.status.code().expect("not killed"),
            stdout: text(output.stdout),
            stderr: stderr.split_inclusive('\n').filter(|line| !alive(line)).collect(),
        };
        assert!(!run.stderr.contains("panicked"), "{run:?}");
        run
    }

    pub fn done(self) -> Self {
        assert_eq!(self.code, 0, "{self:?}");
        self
    }

    /// Ended with `code`, said all of `parts` on stderr in one message, and nothing on stdout.
    pub fn refused(self, code: i32, parts: &[&str]) -> Self {
        assert_eq!(self.code, code, "{self:?}");
        assert_eq!(self.stdout, "", "{self:?}");
        for part in parts {
            assert!(self.stderr.contains(part), "\"{part}\" is missing in: {self:?}");
        }
        self
    }

    pub fn json(&self) -> Value {
        assert_eq!(self.stdout.trim_end().lines().count(), 1, "one line: {self:?}");
        serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {self:?}"))
    }
}

impl std::fmt::Debug for Run {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}\nexit {}\n--- stdout\n{}\n--- stderr\n{}", self.command, self.code, self.stdout, self.stderr)
    }
}
