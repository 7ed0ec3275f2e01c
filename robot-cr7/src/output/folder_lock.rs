//! One run at a time in a folder.

use std::fs::{self, File, TryLockError};
use std::path::Path;

use super::whole_file::{remove_left_parts, unwritten};
use crate::input::error::InputError;

/// A folder into which no other run writes while this value lives.
///
/// The operating system holds the lock and gives it back when the program ends, however it ends; no file marks it. It is the lock that
/// `flock FOLDER` takes, too. Where a folder cannot be
/// locked (Windows, some network drives) there is none: each file is whole even then, but those of two runs may be mixed.
#[derive(Debug)]
pub(crate) struct FolderLock {
    held: Option<File>,
}

impl FolderLock {
    /// Creates the folder where it is missing, and takes it.
    ///
    /// # Errors
    /// [`InputError::Busy`] while another run has it; [`InputError::Write`] where it cannot be made.
    pub(crate) fn take(folder: &Path) -> Result<Self, InputError> {
        fs::create_dir_all(folder).map_err(unwritten(folder))?;
        Self::of(folder).ok_or_else(|| InputError::Busy { folder: folder.to_owned() })
    }

    /// The lock of a folder; `None` while another run has it.
    pub(crate) fn of(folder: &Path) -> Option<Self> {
        let Ok(opened) = File::open(folder) else { return Some(Self { held: None }) };
        match opened.try_lock() {
            Ok(()) => Some(Self { held: Some(opened) }),
            Err(TryLockError::WouldBlock) => None,
            Err(TryLockError::Error(_)) => Some(Self { held: None }),
        }
    }

    /// Removes what killed programs have left in `folder`, which is the locked one or in it. Nothing, where others are not kept out.
    pub(crate) fn remove_left_parts(&self, folder: &Path) {
        if self.held.is_some() {
            remove_left_parts(folder);
        }
    }
}
