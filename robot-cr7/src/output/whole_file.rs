//! Files that are there whole or not at all.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Files that are being written, to be removed when the program is interrupted.
static UNDER_WAY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

pub(crate) fn under_way() -> MutexGuard<'static, Vec<PathBuf>> {
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

/// Writes a file so that it is there whole or not at all.
///
/// # Errors
/// The error of the operating system. Nothing is left then, and what stood under the name stands.
pub(crate) fn write_whole(file: &Path, fill: impl FnOnce(File) -> io::Result<()>) -> io::Result<()> {
    let (part, created) = begin(file)?;
    let written = fill(created).and_then(|()| {
        let mut list = under_way();
        fs::rename(&part, file)?;
        list.retain(|one| *one != part);
        Ok(())
    });
    written.inspect_err(|_| abandon(&part))
}

/// A new file beside `file`, hidden, that is removed on an interrupt.
pub(crate) fn begin(file: &Path) -> io::Result<(PathBuf, File)> {
    let name = file.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    let hidden = format!(".{}.{}.part", name.to_string_lossy(), std::process::id());
    let part = file.with_file_name(hidden);
    let mut list = under_way();
    let created = File::create(&part)?;
    list.push(part.clone());
    Ok((part, created))
}

/// Gives a file up that was begun.
pub(crate) fn abandon(part: &Path) {
    let mut list = under_way();
    let _ = fs::remove_file(part);
    list.retain(|one| one != part);
}
