//! The figures of papers as files, with a page that shows rows and figures paper by paper.

use std::path::{Path, PathBuf};

use super::{Claim, PaperFigure, Reproduced};
use crate::input::error::InputError;
use crate::output::folder_lock::FolderLock;
use crate::output::plot::{paper_picture, save_picture};

const STYLE: &str = "body{font:15px/1.45 sans-serif;max-width:1120px;margin:2em auto;color:#222}\
    table{border-collapse:collapse;width:100%;font-size:13px}td,th{border:1px solid #ddd;padding:3px 7px;text-align:left}\
    .BROKEN{color:#c81e1e;font-weight:bold}figure{margin:2em 0}img{max-width:100%;border:1px solid #eee}\
    figcaption{color:#444}";

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn row(claim: &Claim) -> String {
    let mark = if claim.holds == Some(false) { "BROKEN" } else { claim.kind.words() };
    let cells = [&*claim.what, &*claim.paper, &*claim.ours, mark, &*claim.note].map(escaped);
    let [what, paper, ours, mark, note] = cells;
    format!("<tr><td>{what}<td>{paper}<td>{ours}<td class=\"{mark}\">{mark}<td>{note}\n")
}

fn section(paper: &Reproduced) -> String {
    let r = &paper.reproduction;
    let mut text = format!("<h2>{}</h2>\n<p>{}.</p>\n", escaped(&r.paper), r.tally());
    let mut place = "";
    for claim in &r.claims {
        if claim.place != place {
            if !place.is_empty() {
                text += "</table>\n";
            }
            place = &claim.place;
            text += &format!("<h3>{}</h3>\n<table><tr><th>what<th>paper<th>ours<th>kind<th>note\n", escaped(place));
        }
        text += &row(claim);
    }
    if !place.is_empty() {
        text += "</table>\n";
    }
    for PaperFigure { file, title, caption, .. } in &paper.figures {
        text += &format!(
            "<figure><img src=\"{file}\" alt=\"{}\"><figcaption><b>{}.</b> {}</figcaption></figure>\n",
            escaped(title),
            escaped(title),
            escaped(caption)
        );
    }
    text
}

/// Writes every figure as an SVG into the folder `out`, and `index.html`; returns the files.
///
/// # Errors
/// [`InputError::Write`] naming the file that cannot be drawn or written; [`InputError::Busy`] while another run writes into the folder.
pub fn write_figures(out: &Path, papers: &[Reproduced]) -> Result<Vec<PathBuf>, InputError> {
    let lock = FolderLock::take(out)?;
    lock.remove_left_parts(out);
    let mut files = Vec::new();
    for figure in papers.iter().flat_map(|p| &p.figures) {
        let file = out.join(&figure.file);
        let svg = paper_picture(figure).map_err(|source| InputError::Write { file: file.clone(), source })?;
        save_picture(&file, &svg)?;
        files.push(file);
    }
    let sections: String = papers.iter().map(section).collect();
    let page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>The papers, reproduced</title>\n\
         <style>{STYLE}</style>\n<h1>The papers, reproduced</h1>\n{sections}</html>\n"
    );
    let index = out.join("index.html");
    save_picture(&index, &page)?;
    files.push(index);
    Ok(files)
}
