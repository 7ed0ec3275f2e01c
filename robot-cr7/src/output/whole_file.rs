//! Files that are there whole or not at all.
//!
//! Every file of the crate is made here: written beside its final name, brought to the disk, then renamed. A program that is killed on the
//! way leaves a hidden file `.NAME.PROCESS.part`, never a half under the final name; the next run of the command removes it.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::input::error::InputError;

/// Files that are being written, to be removed when the program is interrupted.
static UNDER_WAY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn under_way() -> MutexGuard<'static, Vec<PathBuf>> {
    // The list is whole between any two statements that change it.
    UNDER_WAY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes every file that is being written and ends the program: what a handler of Ctrl-C calls.
pub fn interrupt(exit_code: i32) -> ! {
    // Held until the end: nothing is begun or renamed any more.
    let parts = under_way();
    for part in parts.iter() {
        let _ = fs::remove_file(part);
    }
    std::process::exit(exit_code)
}

/// A file under its temporary name.
#[derive(Debug)]
pub(crate) struct Part {
    /// The hidden name beside the final one.
    pub(crate) hidden: PathBuf,
    /// The final name.
    pub(crate) file: PathBuf,
}

/// That `file` could not be written.
pub(crate) fn unwritten(file: &Path) -> impl Fn(io::Error) -> InputError + '_ {
    |source| InputError::Write { file: file.to_owned(), source }
}

/// Writes a file so that it is there whole or not at all, and returns what `fill` returns.
///
/// # Errors
/// [`InputError::Write`], or the error of `fill`. Nothing is left then, and what stood under the name stands.
pub(crate) fn write_whole<T, E: From<InputError>>(
    file: &Path,
    fill: impl FnOnce(File) -> Result<T, E>,
) -> Result<T, E> {
    let (part, created) = begin(file)?;
    let written = fill(created).and_then(|value| {
        publish(std::slice::from_ref(&part))?;
        Ok(value)
    });
    written.inspect_err(|_| abandon(&part))
}

/// A new file beside `file`, hidden, that is removed on an interrupt.
pub(crate) fn begin(file: &Path) -> Result<(Part, File), InputError> {
    let name = file.file_name().ok_or_else(|| unwritten(file)(io::ErrorKind::InvalidInput.into()))?;
    let hidden = file.with_file_name(format!("{}{}{PART}", hidden_start(&name.to_string_lossy()), std::process::id()));
    let mut list = under_way();
    let created = File::create(&hidden).map_err(unwritten(file))?;
    list.push(hidden.clone());
    Ok((Part { hidden, file: file.to_owned() }, created))
}

/// Gives files their final names, after all of them have reached the disk.
pub(crate) fn publish(parts: &[Part]) -> Result<(), InputError> {
    for Part { hidden, file } in parts {
        // Windows brings nothing to the disk that is not open for writing.
        let opened = File::options().write(true).open(hidden);
        opened.and_then(|part| part.sync_all()).map_err(unwritten(file))?;
    }
    let mut list = under_way();
    for Part { hidden, file } in parts {
        fs::rename(hidden, file).map_err(unwritten(file))?;
    }
    list.retain(|one| !parts.iter().any(|part| part.hidden == *one));
    Ok(())
}

/// Gives a file up that was begun.
pub(crate) fn abandon(part: &Part) {
    let mut list = under_way();
    let _ = fs::remove_file(&part.hidden);
    list.retain(|one| *one != part.hidden);
}

/// The end of a hidden name.
const PART: &str = ".part";

/// The hidden names of `file` begin so; the number of the process and [`PART`] follow.
fn hidden_start(file: &str) -> String {
    format!(".{file}.")
}

/// Removes what killed programs have left of the files called `names` in `folder`, into which nobody else may be writing.
pub(crate) fn remove_left_parts(folder: &Path, names: &[&str]) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let process = |of: &&str| name.strip_prefix(&hidden_start(of))?.strip_suffix(PART)?.parse::<u32>().ok();
        if names.iter().any(|of| process(of).is_some_and(|number| number != std::process::id())) {
            let _ = fs::remove_file(entry.path());
        }
    }
}
