//! Pictures as PNG beside the SVG files.

use crate::Staging;
#[cfg(feature = "png")]
use crate::plot::PngPainter;

use crate::cli::Failure;
use crate::cli::formats;

/// Arguments of commands that draw.
#[derive(Debug, clap::Args)]
pub struct PictureArgs {
    /// Also write each picture as `png`, with the fonts of the system
    #[arg(long, value_enum, value_name = "FORMAT")]
    format: Option<PictureFormat>,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum PictureFormat {
    /// PNG, two pixels for one of the picture; needs the feature `png` of this program
    Png,
}

impl PictureArgs {
    /// Has the command write what was asked for.
    pub fn apply(&self, staging: &mut Staging) -> Result<(), Failure> {
        match self.format {
            Some(PictureFormat::Png) => draw_png(staging),
            None => Ok(()),
        }
    }
}

/// Has a command write each picture as PNG, too. Fonts are looked for at once, so that their lack is known before the work.
pub fn draw_png(staging: &mut Staging) -> Result<(), Failure> {
    formats::check(&[formats::Format::Png])?;
    #[cfg(feature = "png")]
    staging.draw_png(PngPainter::new().map_err(|error| Failure::Undoable(format!("--format png: {error}")))?);
    #[cfg(not(feature = "png"))]
    let _ = staging;
    Ok(())
}
