//! The file of `cr7 online`, of either kind.

use std::path::Path;

use serde::Deserialize;

use super::error::{InputError, read_text};
use super::online_scenario::OnlineScenario;
use super::tool_scenario::ToolScenario;

const EXPECTED: &str = "a TOML scenario such as scenarios/online.toml or scenarios/tool.toml";

/// The file of `cr7 online`: targets of the joints, or of the tool.
#[derive(Debug, Clone, PartialEq)]
pub enum OnlineFile {
    /// `run.mode` is "time", "line" or "none".
    Joints(OnlineScenario),
    /// `run.mode` is "tool".
    Tool(ToolScenario),
}

/// As much of a file as says which kind it is.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Kind {
    run: KindRun,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct KindRun {
    mode: Option<String>,
}

impl OnlineFile {
    /// Reads and checks a scenario file.
    ///
    /// # Errors
    /// Fails when the file cannot be read, is not TOML, has an unknown key, or a value breaks its rule.
    pub fn read(file: &Path) -> Result<Self, InputError> {
        let text = read_text(file, EXPECTED)?;
        // What is wrong with the file is told by the reader of its kind.
        let mode = toml::from_str::<Kind>(&text).ok().and_then(|kind| kind.run.mode);
        Ok(match mode.as_deref() {
            Some("tool") => Self::Tool(ToolScenario::parse(&text, file)?),
            _ => Self::Joints(OnlineScenario::parse(&text, file)?),
        })
    }
}
