//! Arguments of the command line.

use std::path::PathBuf;

use integration_tests::fuzz::{TARGETS, Target, target};

pub struct Options {
    pub targets: Vec<Target>,
    pub count: u64,
    pub seed: u64,
    pub minutes: Option<f64>,
    pub replay: Option<PathBuf>,
    /// This process feeds inputs; another one watches it.
    pub worker: bool,
    /// Say each input before it is fed.
    pub trace: bool,
}

impl Options {
    pub fn read(mut arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut options = Self {
            targets: TARGETS.to_vec(),
            count: 1000,
            seed: 1,
            minutes: None,
            replay: None,
            worker: false,
            trace: false,
        };
        while let Some(flag) = arguments.next() {
            match flag.as_str() {
                "--worker" => options.worker = true,
                "--trace" => options.trace = true,
                _ => {
                    let value = arguments.next().ok_or_else(|| format!("{flag} needs a value"))?;
                    options.set(&flag, &value)?;
                }
            }
        }
        Ok(options)
    }

    fn set(&mut self, flag: &str, value: &str) -> Result<(), String> {
        let wrong = || format!("{flag} {value}: give a number");
        match flag {
            "--target" if value == "all" => {}
            "--target" => {
                let names = || TARGETS.iter().map(|target| target.name).collect::<Vec<_>>().join(", ");
                self.targets = vec![target(value).ok_or_else(|| format!("no target {value}: all, {}", names()))?];
            }
            "--count" => self.count = value.parse().map_err(|_| wrong())?,
            "--seed" => self.seed = value.parse().map_err(|_| wrong())?,
            "--minutes" => self.minutes = Some(value.parse().map_err(|_| wrong())?),
            "--replay" => self.replay = Some(value.into()),
            _ => return Err(format!("no option {flag}: --target, --count, --seed, --minutes, --replay")),
        }
        Ok(())
    }
}
