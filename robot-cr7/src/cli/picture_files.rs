//! Pictures as PNG beside the SVG files.

use crate::Staging;
#[cfg(feature = "png")]
use crate::plot::PngPainter;

use crate::cli::Failure;
use crate::cli::formats::{self, Format};

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
    /// What draws what was asked for. To be called before anything of an earlier run is touched.
    pub fn painter(&self) -> Result<Painter, Failure> {
        Painter::new(self.format.is_some())
    }
}

/// Draws the pictures of a command as PNG, too, where that is asked for.
pub struct Painter {
    #[cfg(feature = "png")]
    png: Option<PngPainter>,
}

impl Painter {
    /// Looks for the fonts at once, so that their lack is known before the work.
    pub fn new(png: bool) -> Result<Self, Failure> {
        if png {
            formats::check(&[Format::Png])?;
        }
        #[cfg(feature = "png")]
        {
            let painter = png.then(PngPainter::new).transpose();
            Ok(Self { png: painter.map_err(|error| Failure::Undoable(format!("--format png: {error}")))? })
        }
        #[cfg(not(feature = "png"))]
        Ok(Self {})
    }

    /// Has the files of a command drawn.
    pub fn draw(self, staging: &mut Staging) {
        #[cfg(feature = "png")]
        if let Some(painter) = self.png {
            staging.draw_png(painter);
        }
        #[cfg(not(feature = "png"))]
        let _ = staging;
    }
}
