//! `cr7 completions` and `cr7 man`: what shells and manuals know of the program.

use std::io::Write;

use clap::CommandFactory;
use clap_complete::{Shell, generate};

use crate::cli::output::say_as_is;
use crate::cli::{Cli, Failure};

/// Arguments of `cr7 completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 completions bash > ~/.local/share/bash-completion/completions/cr7
  cr7 completions fish > ~/.config/fish/completions/cr7.fish
  cr7 completions zsh > \"${fpath[1]}/_cr7\"")]
pub struct CompletionArgs {
    /// The shell
    shell: Shell,
}

pub fn completions(args: &CompletionArgs) -> Result<(), Failure> {
    let mut script = Vec::new();
    generate(args.shell, &mut Cli::command(), "cr7", &mut script);
    say_as_is!("{}", String::from_utf8_lossy(&script));
    Ok(())
}

/// Arguments of `cr7 man`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 man | man -l -
  cr7 man > /usr/local/share/man/man1/cr7.1")]
pub struct ManArgs {}

/// One page with all commands.
pub fn man(_: &ManArgs) -> Result<(), Failure> {
    let written = |error: std::io::Error| Failure::Undoable(format!("the page: {error}"));
    let mut command = Cli::command();
    command.build();
    let mut page = Vec::new();
    clap_mangen::Man::new(command.clone()).render(&mut page).map_err(written)?;
    for of in command.get_subcommands().filter(|of| of.get_name() != "help") {
        let man = clap_mangen::Man::new(of.clone());
        writeln!(page, ".SH \"cr7 {}\"", of.get_name()).map_err(written)?;
        man.render_synopsis_section(&mut page).map_err(written)?;
        man.render_description_section(&mut page).map_err(written)?;
        man.render_options_section(&mut page).map_err(written)?;
        man.render_extra_section(&mut page).map_err(written)?;
    }
    say_as_is!("{}", String::from_utf8_lossy(&page));
    Ok(())
}

/// Arguments of `cr7 schema`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  cr7 schema > report.schema.json
  cr7 schema | jq '.properties'")]
pub struct SchemaArgs {}

/// The JSON schema of the reports.
pub fn schema(_: &SchemaArgs) -> Result<(), Failure> {
    say_as_is!("{}", crate::ReportHead::SCHEMA);
    Ok(())
}
