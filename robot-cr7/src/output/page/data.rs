//! What the page's own script reads, and the page around it.

use plotly::Plot;
use serde::Serialize;

use super::shape::ArmShape;
use crate::output::arm_poses::Pose;
use crate::output::report::Report;
use crate::text::json;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = concat!(include_str!("shape.js"), include_str!("page.js"));

/// One quantity of all joints.
#[derive(Debug, Serialize)]
pub struct JointCurves {
    /// What it is: "velocity".
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its values, joint by joint.
    pub values: Vec<Vec<f64>>,
    /// The least and the greatest value allowed, joint by joint.
    pub limits: Vec<[f64; 2]>,
}

/// The data of a page. Numbers that are not finite become `null`.
#[derive(Debug, Serialize)]
pub struct Page<'a> {
    pub report: &'a Report,
    pub limited_by: Option<String>,
    pub robot: &'a str,
    pub joint_names: &'a [String],
    /// Time (s), place on the path (m), speed (m/s) of each sample of the curves.
    pub t: Vec<f64>,
    pub s: Vec<f64>,
    pub feed: Vec<f64>,
    /// Time and the highest speed there.
    pub limit: Vec<[f64; 2]>,
    /// From which place of the path on (m) which limit sets that speed.
    pub ceiling: Vec<(f64, &'a str)>,
    pub quantities: Vec<JointCurves>,
    /// Radius of the links, m.
    pub radius: f64,
    pub poses: &'a [Pose],
    /// Meshes of the arm, where there are some.
    pub shape: Option<ArmShape>,
}

impl Page<'_> {
    /// The whole file.
    pub fn to_html(&self) -> String {
        // What begins with "<" could end the script, wherever it stands.
        let data = json(self).replace('<', "\\u003c");
        let title = self.report.name.replace('&', "&amp;").replace('<', "&lt;");
        let library = library();
        let parts = [
            ("{{title}}", title.as_str()),
            ("{{style}}", STYLE),
            ("{{library}}", &library),
            ("{{data}}", &data),
            ("{{script}}", SCRIPT),
        ];
        let mut page = String::with_capacity(parts.iter().map(|(_, text)| text.len()).sum::<usize>() + PAGE.len());
        let mut rest = PAGE;
        // In the order of the page, so that what stands in the data is never taken for a mark.
        for (mark, text) in parts {
            if let Some((before, after)) = rest.split_once(mark) {
                page.extend([before, text]);
                rest = after;
            }
        }
        page.push_str(rest);
        page
    }
}

/// The script of plotly.js. The crate puts a second one behind it, for formulas, which this page has none of.
fn library() -> String {
    let mut scripts = Plot::offline_js_sources();
    if let Some(end) = scripts.find("</script>") {
        scripts.truncate(end + "</script>".len());
    }
    scripts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_library_is_one_whole_script() {
        let library = library();
        assert!(library.starts_with("<script"));
        assert!(library.ends_with("</script>"));
        assert_eq!(library.matches("</script>").count(), 1);
        assert!(library.contains("Plotly") && (4_000_000..5_500_000).contains(&library.len()), "{}", library.len());
        assert!(!library.contains("MathJax={"));
    }

    #[test]
    fn the_marks_stand_in_the_order_in_which_they_are_filled() {
        let marks = ["{{title}}", "{{style}}", "{{library}}", "{{data}}", "{{script}}"];
        let places = marks.map(|mark| PAGE.find(mark).expect("a mark"));
        assert!(places.is_sorted() && PAGE.matches("{{").count() == marks.len());
    }
}
