//! Files whole or absent: written beside their final names, and renamed when the motion in them is known to hold.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::folder_lock::FolderLock;
#[cfg(feature = "png")]
use super::plot::PngPainter;
use super::trajectory_csv::write_rows;
use super::whole_file::{Part, begin, publish, unwritten};
use crate::input::error::InputError;
use crate::run::trajectory_row::TrajectoryRow;
use crate::run::verdict::LimitsHold;

/// The file that says that a folder is complete: removed first, renamed last.
const COMPLETE: &str = "report.json";

/// The files that one command writes into its folder.
///
/// [`Staging::clear`] removes what an earlier run left under the same names, so that nothing stale can be taken for the result.
/// Each file is written under a hidden name in the same folder; [`Staging::publish`] renames all of them and asks for the proof
/// that every limit holds. A command that ends without it, for whatever reason, leaves none of the files behind. From
/// [`Staging::clear`] on no other run writes into the folder.
///
/// A picture `NAME.svg` can have a `NAME.png` beside it, which is handled as if it were one of the names: it is removed where it is not
/// written anew.
///
/// ```
/// use robot_cr7::Staging;
/// let folder = std::env::temp_dir().join("staging_doc");
/// let mut staging = Staging::new(&folder, &["note.txt"], &[])?;
/// staging.clear()?;
/// staging.write("note.txt", "not published")?;
/// drop(staging);
/// assert!(!folder.join("note.txt").exists());
/// # Ok::<(), robot_cr7::InputError>(())
/// ```
#[derive(Debug)]
pub struct Staging {
    folder: PathBuf,
    names: &'static [&'static str],
    /// Final names that are also read from.
    kept: Vec<PathBuf>,
    parts: Vec<Part>,
    /// Nobody else writes into the folder, once it is cleared.
    lock: Option<FolderLock>,
    /// Nothing of the folder is ours to remove: the files are published, or another run has it.
    done: bool,
    /// Draws each picture as PNG, too.
    #[cfg(feature = "png")]
    png: Option<PngPainter>,
}

impl Staging {
    /// Files called `names` in `folder`, for a command that reads `inputs`.
    ///
    /// # Errors
    /// [`InputError::Overwritten`] for an input that is one of the files.
    pub fn new(folder: &Path, names: &'static [&'static str], inputs: &[&Path]) -> Result<Self, InputError> {
        let mut staging = Self {
            folder: folder.to_owned(),
            names,
            kept: Vec::new(),
            parts: Vec::new(),
            lock: None,
            done: false,
            #[cfg(feature = "png")]
            png: None,
        };
        for input in inputs {
            staging.reads(input)?;
        }
        Ok(staging)
    }

    /// Says that the command reads `input`, too.
    ///
    /// # Errors
    /// [`InputError::Overwritten`] if it is one of the files to write.
    pub fn reads(&mut self, input: &Path) -> Result<(), InputError> {
        let Ok(real) = fs::canonicalize(input) else { return Ok(()) };
        let same = |name: &PathBuf| fs::canonicalize(name).is_ok_and(|file| file == real);
        if let Some(file) = self.complete_first().into_iter().find(same) {
            self.kept.push(file);
            return Err(InputError::Overwritten { file: input.to_owned() });
        }
        Ok(())
    }

    /// Creates the folder, keeps other runs out of it, and removes the files of an earlier run.
    ///
    /// # Errors
    /// [`InputError::Write`]; [`InputError::Busy`] while another run writes into the folder.
    pub fn clear(&mut self) -> Result<(), InputError> {
        let lock = match self.lock.take() {
            Some(lock) => lock,
            None => FolderLock::take(&self.folder).inspect_err(|error| {
                // It may be free when this value is dropped, with the files of the other run in it.
                self.done |= matches!(error, InputError::Busy { .. });
            })?,
        };
        lock.remove_left_parts(&self.folder);
        self.lock = Some(lock);
        for file in self.complete_first() {
            match fs::remove_file(&file) {
                Err(source) if source.kind() != io::ErrorKind::NotFound => return Err(unwritten(&file)(source)),
                _ => {}
            }
        }
        // A folder that takes no files is to be named before the work.
        self.names.first().map_or(Ok(()), |name| begin(&self.folder.join(name)).map(drop))
    }

    /// The final names, that which says that all are there before the others.
    fn complete_first(&self) -> Vec<PathBuf> {
        let pngs = self.names.iter().filter_map(|name| png_beside(name));
        let mut names: Vec<String> = self.names.iter().map(|name| (*name).to_owned()).chain(pngs).collect();
        names.sort_by_key(|name| name != COMPLETE);
        names.iter().map(|name| self.folder.join(name)).collect()
    }

    /// From now on each picture is written as PNG, too.
    #[cfg(all(feature = "cli", feature = "png"))]
    pub(crate) fn draw_png(&mut self, painter: PngPainter) {
        self.png = Some(painter);
    }

    /// Begins a file under its temporary name.
    ///
    /// # Errors
    /// [`InputError::Write`] with its final name.
    pub fn create(&mut self, name: &str) -> Result<File, InputError> {
        let (part, created) = begin(&self.folder.join(name))?;
        self.parts.push(part);
        Ok(created)
    }

    /// Writes a whole file under its temporary name.
    ///
    /// # Errors
    /// [`InputError::Write`] with its final name.
    pub fn write(&mut self, name: &str, text: &str) -> Result<(), InputError> {
        let mut file = self.create(name)?;
        file.write_all(text.as_bytes()).map_err(|source| self.failed(name, source))?;
        #[cfg(feature = "png")]
        self.write_png(name, text)?;
        Ok(())
    }

    /// Writes a picture as PNG, where that was asked for.
    #[cfg(feature = "png")]
    fn write_png(&mut self, svg_name: &str, svg: &str) -> Result<(), InputError> {
        let Some((painter, name)) = self.png.as_ref().zip(png_beside(svg_name)) else { return Ok(()) };
        let image = painter.paint(svg).map_err(|error| self.failed(&name, io::Error::other(error)))?;
        let mut file = self.create(&name)?;
        file.write_all(&image).map_err(|source| self.failed(&name, source))
    }

    /// Writes a picture under its temporary name.
    ///
    /// # Errors
    /// [`InputError::Write`] with its final name, also where it could not be drawn.
    #[cfg(feature = "cli")]
    pub(crate) fn write_picture(&mut self, name: &str, svg: io::Result<String>) -> Result<(), InputError> {
        let svg = svg.map_err(|source| self.failed(name, source))?;
        self.write(name, &svg)
    }

    /// Writes a whole trajectory of joints with these names under its temporary name.
    ///
    /// # Errors
    /// [`InputError::Write`] with its final name.
    pub fn write_trajectory<const N: usize>(
        &mut self,
        name: &str,
        joint_names: &[String],
        rows: impl IntoIterator<Item = TrajectoryRow<N>>,
    ) -> Result<(), InputError> {
        let file = self.create(name)?;
        write_rows(file, joint_names, rows).map_err(|source| self.failed(name, source))
    }

    /// That `name` could not be written.
    pub fn failed(&self, name: &str, source: io::Error) -> InputError {
        InputError::Write { file: self.folder.join(name), source }
    }

    /// Final names of the files written so far, in their order, and of `more` that are to come.
    pub fn files_with(&self, more: &[&str]) -> Vec<PathBuf> {
        let written = self.parts.iter().map(|part| part.file.clone());
        written.chain(more.iter().map(|name| self.folder.join(name))).collect()
    }

    /// Gives all files their final names, after they have reached the disk. Either all have them afterwards or none.
    ///
    /// # Errors
    /// [`InputError::Write`].
    pub fn publish(self, _: &LimitsHold) -> Result<(), InputError> {
        self.publish_pictures()
    }

    /// As [`Staging::publish`], of files that hold no motion.
    pub(crate) fn publish_pictures(mut self) -> Result<(), InputError> {
        self.parts.sort_by_key(|part| part.file.file_name().is_some_and(|name| name == COMPLETE));
        publish(&self.parts)?;
        self.done = true;
        Ok(())
    }
}

/// The name of the PNG beside a picture.
fn png_beside(name: &str) -> Option<String> {
    name.strip_suffix(".svg").map(|stem| format!("{stem}.png"))
}

impl Drop for Staging {
    /// Removes what is not published: no file of it stays, and none of an earlier run.
    fn drop(&mut self) {
        if self.done {
            return;
        }
        self.parts.clear();
        // A folder that another run has is not ours to clear.
        let Some(_lock) = self.lock.take().or_else(|| FolderLock::of(&self.folder)) else { return };
        for file in self.complete_first() {
            if !self.kept.contains(&file) {
                let _ = fs::remove_file(file);
            }
        }
    }
}
