//! `cr7 reproduce` as a person runs it.

use robot_cr7::reproduce::{Overview, PAPERS, Reproduction};

use crate::common::Desk;

#[test]
fn every_paper_is_reproduced_with_its_figures_and_a_page() {
    let desk = Desk::new("reproduce_all");
    let overview = desk.run(&["reproduce", "all", "--out", "figures", "--json"]).done().json();
    assert_eq!(overview["broken"], 0, "{overview}");
    let papers = overview["papers"].as_array().expect("a list");
    assert_eq!(papers.len(), PAPERS.len());
    for claim in papers.iter().flat_map(|p| p["claims"].as_array().expect("a list")) {
        let counts = claim["kind"] == "independent" || claim["kind"] == "print";
        assert_eq!(claim["holds"], if counts { true.into() } else { serde_json::Value::Null }, "{claim}");
    }
    let tally = &overview["tally"];
    assert!(tally["independent"].as_u64() > Some(200) && tally["print"].as_u64() > Some(30), "{tally}");
    has_the_rows_of_the_page(papers);
    let page = std::fs::read_to_string(desk.folder.join("figures/index.html")).expect("a page");
    let pn =
        ["01a", "01b", "02a", "02b", "03a", "03b", "04", "06_acceleration", "06_deceleration", "10a", "10b", "10c"];
    let pn = pn
        .iter()
        .chain(&["10d", "10e", "10f", "11a", "11b", "11c", "11d", "13a", "13b"])
        .map(|n| format!("pn_figure_{n}"));
    let hs =
        ["01a", "01b", "01c", "01d", "02a", "02b", "05", "07a", "07b", "09a", "09b", "09c", "11a", "11b", "12a", "12b"];
    let hs =
        hs.iter().chain(&["12c", "12d", "13", "14_above", "14_side", "14_joints"]).map(|n| format!("hs_figure_{n}"));
    let qb = ["02_scan", "03", "04", "05", "06_scan", "07", "08", "09", "11", "12", "13", "14"];
    for name in pn.chain(hs).chain(qb.iter().map(|n| format!("qb_figure_{n}"))) {
        let file = format!("{name}.svg");
        assert!(desk.folder.join("figures").join(&file).exists(), "{file}");
        assert!(page.contains(&format!("src=\"{file}\"")), "{file}");
    }
    let named = include_str!("../../../docs/papers.md");
    for file in named.split('`').filter(|name| name.ends_with(".svg")) {
        assert!(desk.folder.join("figures").join(file).exists(), "docs/papers.md names {file}");
    }
    assert!(page.matches("<figcaption>").count() >= 55 && !page.contains("BROKEN<td>"), "{}", page.len());
}

/// The page in `docs` has these rows, with these kinds; numbers of ours such as times may differ.
fn has_the_rows_of_the_page(papers: &[serde_json::Value]) {
    let page = include_str!("../../../docs/reproduction.md");
    let on_page: Vec<(String, String)> = page
        .lines()
        .filter(|l| l.starts_with("| ") && !l.starts_with("| what"))
        .map(|l| l.trim_matches('|').split(" | ").map(|c| c.trim().to_owned()).collect::<Vec<_>>())
        .map(|cells| (cells[0].clone(), cells[3].clone()))
        .collect();
    let text = |c: &serde_json::Value, key: &str| c[key].as_str().expect("a text").to_owned();
    let claims = papers.iter().flat_map(|p| p["claims"].as_array().expect("a list"));
    let measured: Vec<(String, String)> = claims.map(|c| (text(c, "what"), text(c, "kind"))).collect();
    for (page, ours) in on_page.iter().zip(&measured) {
        assert_eq!(page, ours, "write docs/reproduction.md anew: cr7 reproduce all --markdown");
    }
    assert_eq!(on_page.len(), measured.len());
}

#[test]
fn one_paper_is_shown_as_text_as_tables_and_drawn() {
    let desk = Desk::new("reproduce_one");
    let run = desk.run(&["reproduce", "hs"]).done();
    for part in ["0.914486", "Table 3", "Table 5", "Table 7", "independent check", "agrees with print", "checks hold"] {
        assert!(run.stdout.contains(part), "{part}: {run:?}");
    }
    let run = desk.run(&["reproduce", "hs", "--markdown", "--out", "drawn"]).done();
    let rows: Vec<&str> = run.stdout.lines().filter(|l| l.starts_with('|')).collect();
    assert!(rows.len() > 150 && rows.iter().all(|r| r.matches('|').count() == 6), "{run:?}");
    assert!(desk.folder.join("drawn/index.html").exists());
    desk.run(&["reproduce", "xy"]).refused(2, &["xy", "pn", "hs"]);
    // A folder that cannot be made is told, and not ignored.
    desk.write("file", "");
    desk.run(&["reproduce", "qb", "--out", "file/figures"]).refused(2, &["file/figures"]);
}

#[test]
fn a_broken_row_ends_the_command_with_one() {
    let mut r = Reproduction::new("a paper");
    r.print("Table 1", "x", "0.10", 0.101);
    r.information("Table 1", "y", "1", "2").fitted();
    r.information("Table 1", "z", "1", "2");
    assert_eq!(Overview::of(vec![r.clone()]).exit_code(), 0);
    r.print("Table 1", "x", "0.10", 0.106);
    let overview = Overview::of(vec![r.clone(), r]);
    assert_eq!((overview.exit_code(), overview.broken, overview.tally.counted()), (1, 2, 4));
    assert!(overview.to_markdown().contains("**BROKEN**"));
}
