//! The pages on the papers: nothing that they name is missing, and no part of a paper is left out.

use std::path::Path;

/// Equations, tables and figures of each paper.
const PARTS: [(&str, usize, usize, usize); 3] = [("PN", 39, 2, 13), ("HS", 20, 8, 14), ("QB", 38, 3, 14)];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace")
}

fn read(file: &str) -> String {
    std::fs::read_to_string(root().join(file)).unwrap_or_else(|e| panic!("{file}: {e}"))
}

/// Cells of the table rows below the heading `## name`.
fn rows(page: &str, name: &str) -> Vec<Vec<String>> {
    let section = page.split("\n## ").find(|s| s.lines().next() == Some(name)).expect("a heading");
    let cells = |line: &str| line.trim_matches('|').split(" | ").map(|c| c.trim().to_owned()).collect();
    section.lines().filter(|l| l.starts_with("| ") && !l.starts_with("| part")).map(cells).collect()
}

/// Numbers that a first cell names after `word`: "eqs. 4-7" names 4, 5, 6, 7.
fn named(cell: &str, words: &[&str]) -> Vec<usize> {
    let mut found = Vec::new();
    for part in cell.split(", ") {
        let Some(rest) = words.iter().find_map(|w| part.strip_prefix(w)) else { continue };
        let ends: Vec<usize> = rest.split('-').filter_map(|n| n.trim().parse().ok()).collect();
        if let (Some(&from), Some(&to)) = (ends.first(), ends.last()) {
            found.extend(from..=to);
        }
    }
    found
}

#[test]
fn every_equation_table_and_figure_has_a_row() {
    let page = read("docs/papers.md");
    for (paper, equations, tables, figures) in PARTS {
        let rows = rows(&page, paper);
        assert!(rows.iter().all(|cells| cells.len() == 4 && cells.iter().all(|c| !c.is_empty())), "{paper}: {rows:?}");
        for (words, count) in
            [(&["eq. ", "eqs. "][..], equations), (&["Table "][..], tables), (&["Figure "][..], figures)]
        {
            let all: Vec<usize> = rows.iter().flat_map(|cells| named(&cells[0], words)).collect();
            for number in 1..=count {
                assert!(all.contains(&number), "{paper}: {}{number}", words[0]);
            }
        }
    }
}

#[test]
fn every_file_and_test_that_the_page_names_exists() {
    let page = read("docs/papers.md");
    let mut tests = 0;
    for name in page.split('`').skip(1).step_by(2).filter(|name| !name.ends_with(".svg")) {
        match name.split_once("::") {
            Some((file, test)) => {
                assert!(read(file).contains(&format!("fn {test}(")), "{name}");
                tests += 1;
            }
            None => assert!(root().join(name).exists(), "{name}"),
        }
    }
    assert!(tests > 40, "{tests}");
}

#[test]
fn the_page_of_parts_states_the_totals_of_the_page_of_rows() {
    let (page, parts) = (read("docs/reproduction.md"), read("docs/papers.md"));
    let totals: Vec<&str> = page.lines().filter(|l| l.contains(" checks hold (")).collect();
    assert_eq!(totals.len(), 4, "{totals:?}");
    for total in totals {
        // "80 of 80 checks hold (69 independent, 11 agree with the print)"
        let counted = total.trim_start_matches("All papers: ").split(';').next().unwrap_or_default();
        let flat = parts.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(flat.contains(counted), "docs/papers.md lacks: {counted}");
    }
}
