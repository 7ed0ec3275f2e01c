//! Liu et al. 2024, "online trajectory generation in task and joint spaces" (Actuators 13, 108).

mod conditions;
pub mod printed_cases;
pub mod printed_feed;
pub mod printed_projection;
pub mod projection;
pub mod table_1;
pub mod table_3;
pub mod table_4;
pub mod table_6;
mod table_6_figures;
pub mod table_8;
mod tool;

use super::Reproduced;

/// Tables 1 to 8 beside ours, and Figures 1, 2, 5, 7, 9 and 11 to 14.
pub fn liu_2024() -> Reproduced {
    use projection::{Table5Run, Table7Run};
    use table_1::Section2Run;
    use table_3::Table3Run;
    use table_4::Table4Run;
    use table_6::Table6Run;
    use table_8::EventRun;

    let mut out = Reproduced::new(
        "Liu et al. 2024, online trajectory generation for robots in task and joint spaces, Actuators 2024, 13, 108",
    );
    out.take("Table 1", Section2Run::measure(), Section2Run::judge, Section2Run::figures);
    out.take("Table 3", Table3Run::measure(), Table3Run::judge, Table3Run::figures);
    out.take("Table 4", Table4Run::measure(), Table4Run::judge, Table4Run::figures);
    out.take("Table 5", Table5Run::measure(), Table5Run::judge, Table5Run::figures);
    out.take("Table 6", Table6Run::measure(), Table6Run::judge, Table6Run::figures);
    out.take("Table 7", Table7Run::measure(), Table7Run::judge, Table7Run::figures);
    let names = [("14", "Figure 14"), ("14_middle", "Figure 14, event in the middle")];
    out.take(
        "Table 8",
        EventRun::measure(),
        |runs, r| runs.iter().for_each(|run| run.judge(r)),
        |runs| runs.iter().zip(names).flat_map(|(run, (file, title))| run.figures(file, title)).collect(),
    );
    out
}
