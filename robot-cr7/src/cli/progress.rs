//! Signs of life on stderr: a spinner on a terminal, a line every few seconds elsewhere.

use std::io::IsTerminal;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{JoinHandle, spawn};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Time of silence on a stderr that is no terminal.
const SILENCE: Duration = Duration::from_secs(5);

/// Shows what the program does as long as it lives.
pub enum Progress {
    Spinner(ProgressBar),
    Lines { steps: Option<Sender<String>>, teller: Option<JoinHandle<()>> },
}

impl Progress {
    pub fn new(step: &str) -> Self {
        if std::io::stderr().is_terminal() {
            let bar = ProgressBar::new_spinner().with_message(step.to_owned());
            if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
                bar.set_style(style);
            }
            bar.enable_steady_tick(Duration::from_millis(100));
            return Self::Spinner(bar);
        }
        let (steps, receiver) = channel();
        let first = step.to_owned();
        Self::Lines { steps: Some(steps), teller: Some(spawn(move || tell(first, &receiver))) }
    }

    /// Names the next step of the program.
    pub fn step(&self, step: &str) {
        match self {
            Self::Spinner(bar) => bar.set_message(step.to_owned()),
            Self::Lines { steps, .. } => drop(steps.as_ref().map(|steps| steps.send(step.to_owned()))),
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        match self {
            Self::Spinner(bar) => bar.finish_and_clear(),
            Self::Lines { steps, teller } => {
                // Without a sender the thread ends.
                steps.take();
                drop(teller.take().map(JoinHandle::join));
            }
        }
    }
}

fn tell(mut step: String, steps: &Receiver<String>) {
    let begin = Instant::now();
    let mut due = SILENCE;
    loop {
        match steps.recv_timeout(due.saturating_sub(begin.elapsed())) {
            Ok(next) => step = next,
            Err(RecvTimeoutError::Timeout) => {
                eprintln!("cr7: {step}, {} s so far", due.as_secs());
                due += SILENCE;
            }
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}
