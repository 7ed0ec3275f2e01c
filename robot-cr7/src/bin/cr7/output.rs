//! What goes to stdout, where a reader may stop reading (`cr7 robots | head -1`): that ends the program, it is no failure.

use std::io::Write;

/// Writes to stdout; ends the program quietly when nobody reads any more.
pub fn write(text: std::fmt::Arguments<'_>) {
    if let Err(error) = std::io::stdout().lock().write_fmt(text) {
        let code = if error.kind() == std::io::ErrorKind::BrokenPipe { 0 } else { 2 };
        if code != 0 {
            eprintln!("cr7: stdout: {error}");
        }
        std::process::exit(code);
    }
}

/// As `println!`.
macro_rules! say {
    ($($part:tt)*) => { $crate::output::write(format_args!("{}\n", format_args!($($part)*))) };
}
/// As `print!`.
macro_rules! say_as_is {
    ($($part:tt)*) => { $crate::output::write(format_args!($($part)*)) };
}
pub(crate) use {say, say_as_is};
