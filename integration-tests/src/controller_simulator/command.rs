//! Commands of the protocol, cut out of a stream of text.

/// A command with its arguments, as written.
#[derive(Debug, Clone, PartialEq)]
pub struct Command {
    /// The name in lower case.
    pub name: String,
    /// The arguments between the brackets.
    pub arguments: String,
    /// The whole command, for the reply.
    pub text: String,
}

impl Command {
    /// The numbers of the arguments, names and brackets left out.
    pub fn numbers(&self) -> Vec<f64> {
        let parts = self.arguments.split(|c: char| ",={} ".contains(c));
        parts.filter_map(|part| part.parse().ok()).collect()
    }
}

/// Text that is not a whole command yet.
#[derive(Debug, Clone, Default)]
pub struct Commands(String);

impl Commands {
    /// Takes text as it comes, and returns the commands that are whole.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Command> {
        self.0.push_str(&String::from_utf8_lossy(bytes));
        let mut all = Vec::new();
        while let Some(end) = self.0.find(')') {
            let text: String = self.0.drain(..=end).collect();
            let text = text.trim().to_owned();
            if let Some((name, rest)) = text.split_once('(') {
                let arguments = rest.trim_end_matches(')').to_owned();
                all.push(Command { name: name.trim().to_lowercase(), arguments, text: text.clone() });
            }
        }
        all
    }
}
