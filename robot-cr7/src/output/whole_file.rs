//! Files that are there whole or not at all.
//!
//! Every file of the crate is made here: written beside its final name, brought to the disk, then renamed. A program that is killed on the
//! way leaves a hidden file `.NAME.PROCESS.NUMBER.part`, never a half under the final name; the next run into the folder removes it.
//! A hidden file is always a new one: nothing that stands under its name, a link least of all, is written to.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
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

/// A file under its temporary name. One that is dropped before it is published is removed, after a panic too.
#[derive(Debug)]
pub(crate) struct Part {
    /// The hidden name beside the final one.
    hidden: PathBuf,
    /// The final name.
    pub(crate) file: PathBuf,
}

impl Drop for Part {
    fn drop(&mut self) {
        let mut list = under_way();
        if let Some(i) = list.iter().position(|one| *one == self.hidden) {
            let _ = fs::remove_file(&self.hidden);
            list.swap_remove(i);
        }
    }
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
    let value = fill(created)?;
    publish(&[part])?;
    Ok(value)
}

/// A new file beside `file`, hidden, that is removed on an interrupt.
pub(crate) fn begin(file: &Path) -> Result<(Part, File), InputError> {
    /// Each hidden name of this program has a number of its own.
    static NUMBER: AtomicU64 = AtomicU64::new(0);

    let name = file.file_name().ok_or_else(|| unwritten(file)(io::ErrorKind::InvalidInput.into()))?;
    let (name, process) = (name.to_string_lossy(), std::process::id());
    let mut list = under_way();
    let mut taken = 0;
    loop {
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let hidden = file.with_file_name(format!(".{name}.{process}.{number}{PART}"));
        match File::create_new(&hidden) {
            Ok(created) => {
                list.push(hidden.clone());
                return Ok((Part { hidden, file: file.to_owned() }, created));
            }
            // What a killed program of the same number has left.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && taken < MOST_TAKEN => taken += 1,
            Err(error) => return Err(unwritten(file)(error)),
        }
    }
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

/// The end of a hidden name.
const PART: &str = ".part";
/// Names that may be taken before a file is given up.
const MOST_TAKEN: u32 = 10_000;

/// Removes what killed programs have left in `folder`, into which nobody else may be writing: every `.NAME.PROCESS.NUMBER.part`.
pub(crate) fn remove_left_parts(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    let list = under_way();
    for entry in entries.flatten() {
        let name = entry.file_name();
        let text = name.to_string_lossy();
        let number = || {
            let (rest, count) = text.strip_prefix('.')?.strip_suffix(PART)?.rsplit_once('.')?;
            count.parse::<u64>().ok().and(rest.rsplit_once('.')?.1.parse::<u64>().ok())
        };
        // The number of a process may be that of this one: in a container it mostly is.
        if number().is_some() && !list.iter().any(|one| one.file_name() == Some(&name)) {
            let _ = fs::remove_file(entry.path());
        }
    }
}
