//! Replies of the controller: `ErrorID,{values},Command(arguments);`.

use super::stream::LinkError;

/// Bytes of replies that are kept until their end has come.
const BUFFER: usize = 8192;
/// Values of a reply that are kept.
const VALUES: usize = 8;

/// The command that a reply belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandName {
    /// `GetErrorID`.
    Errors,
    /// `EnableRobot`.
    Enable,
    /// `ServoJ`.
    Setpoint,
    /// `Stop` or `ResetRobot`.
    Stop,
    /// Another one.
    Other,
}

impl CommandName {
    fn of(text: &str) -> Self {
        let name = text.split('(').next().unwrap_or_default().trim();
        let is = |other: &str| name.eq_ignore_ascii_case(other);
        match () {
            () if is("GetErrorID") => Self::Errors,
            () if is("EnableRobot") => Self::Enable,
            () if is("ServoJ") => Self::Setpoint,
            () if is("Stop") || is("ResetRobot") => Self::Stop,
            () => Self::Other,
        }
    }

    /// The name for a message.
    pub fn words(self) -> &'static str {
        match self {
            Self::Errors => "GetErrorID",
            Self::Enable => "EnableRobot",
            Self::Setpoint => "ServoJ",
            Self::Stop => "the stop",
            Self::Other => "a command",
        }
    }
}

/// One reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reply {
    /// 0 if the command is accepted.
    pub code: i32,
    /// The command.
    pub command: CommandName,
    /// The number of errors that `GetErrorID` lists; 0 for other commands.
    pub count: usize,
    /// The first of them.
    pub values: [i64; VALUES],
}

impl Reply {
    /// Reads a reply without the semicolon at its end; `None` for a text that is none.
    pub fn parse(text: &str) -> Option<Self> {
        let (code, rest) = text.trim().split_once(',')?;
        let code = code.trim().parse().ok()?;
        let (inside, command) = rest.trim_start().strip_prefix('{')?.rsplit_once("},")?;
        let mut reply = Self { code, command: CommandName::of(command), count: 0, values: [0; VALUES] };
        if reply.command != CommandName::Errors || code != 0 {
            return Some(reply);
        }
        // No errors are empty lists, and not nothing.
        inside.contains('[').then_some(())?;
        for number in inside.split(|c: char| "[],".contains(c) || c.is_whitespace()).filter(|text| !text.is_empty()) {
            let number = number.parse().ok()?;
            if let Some(place) = reply.values.get_mut(reply.count) {
                *place = number;
            }
            reply.count += 1;
        }
        Some(reply)
    }
}

/// Cuts a stream of bytes into replies. It does not allocate but for an error.
#[derive(Debug, Clone)]
pub struct ReplyReader {
    bytes: [u8; BUFFER],
    held: usize,
}

impl Default for ReplyReader {
    fn default() -> Self {
        Self { bytes: [0; BUFFER], held: 0 }
    }
}

impl ReplyReader {
    /// Takes bytes as they come.
    ///
    /// # Errors
    /// [`LinkError::Unreadable`] where more bytes come than a reply has. All bytes are forgotten then.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let end = self.held + bytes.len();
        let Some(place) = self.bytes.get_mut(self.held..end) else {
            self.held = 0;
            return Err(unreadable(bytes));
        };
        place.copy_from_slice(bytes);
        self.held = end;
        Ok(())
    }

    /// The next whole reply; `None` until it is there.
    ///
    /// # Errors
    /// [`LinkError::Unreadable`] for a text that is no reply. All bytes are forgotten then.
    pub fn next_reply(&mut self) -> Result<Option<Reply>, LinkError> {
        let next = self.cut_reply();
        if next.is_err() {
            self.held = 0;
        }
        next
    }

    fn cut_reply(&mut self) -> Result<Option<Reply>, LinkError> {
        let held = &self.bytes[..self.held];
        let begin = held.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(held.len());
        // A reply begins with a number; refusals of another kind do not end with a semicolon.
        if held.get(begin).is_some_and(|b| !(b.is_ascii_digit() || *b == b'-')) {
            return Err(unreadable(held));
        }
        let Some(end) = held.iter().position(|b| *b == b';') else { return Ok(None) };
        let reply = std::str::from_utf8(&held[begin..end]).ok().and_then(Reply::parse);
        let reply = reply.ok_or_else(|| unreadable(&held[begin..end]))?;
        self.bytes.copy_within(end + 1..self.held, 0);
        self.held -= end + 1;
        Ok(Some(reply))
    }
}

fn unreadable(bytes: &[u8]) -> LinkError {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(120)]);
    LinkError::Unreadable(text.trim().escape_debug().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replies_of_the_manual_are_read() {
        let reply = |text| Reply::parse(text).expect(text);
        assert_eq!(reply("0,{},EnableRobot()").command, CommandName::Enable);
        let servo = reply("0,{17},ServoJ(0,0,-90,0,90,0,t=0.1,aheadtime=50,gain=500)");
        assert_eq!((servo.code, servo.command, servo.count), (0, CommandName::Setpoint, 0));
        assert_eq!(reply("-10000,{},Mov(-500,100,200,150,0,90)").code, -10000);
        // No error: seven empty lists. Version 4 puts a further pair of brackets around them.
        assert_eq!(reply("0,{[],[],[],[],[],[],[]},GetErrorID()").count, 0);
        let errors = reply("0,{[[-2,17],[],[33],[],[],[],[]]},GetErrorID()");
        assert_eq!((errors.command, errors.count, &errors.values[..3]), (CommandName::Errors, 3, &[-2, 17, 33][..]));
        for inside in ["[[17.5],[]]", "[0x11]", "[99999999999999999999]", "17", "[seventeen]"] {
            assert_eq!(Reply::parse(&format!("0,{{{inside}}},GetErrorID()")), None, "{inside}");
        }
        for text in ["", "0", "0,{}", "Control Mode Is Not Tcp", "x,{},Stop()", "0,},Stop()", "0,{},GetErrorID()"] {
            assert_eq!(Reply::parse(text), None, "{text}");
        }
    }

    #[test]
    fn replies_may_come_in_any_pieces() {
        let text = b"0,{1},ServoJ(1,2,3,4,5,6);\r\n-1,{},Stop();0,{},EnableRobot();";
        for length in 1..text.len() {
            let mut reader = ReplyReader::default();
            let mut all = Vec::new();
            for piece in text.chunks(length) {
                reader.push(piece).expect("room");
                while let Some(reply) = reader.next_reply().expect("replies") {
                    all.push((reply.code, reply.command));
                }
            }
            let expected = [(0, CommandName::Setpoint), (-1, CommandName::Stop), (0, CommandName::Enable)];
            assert_eq!(all, expected, "{length}");
        }
    }

    #[test]
    fn what_is_no_reply_is_told() {
        let mut reader = ReplyReader::default();
        reader.push(b"Control Mode Is Not Tcp").expect("room");
        let error = reader.next_reply().expect_err("no reply").to_string();
        assert!(error.contains("Control Mode Is Not Tcp") && error.contains("TCP/IP mode"), "{error}");
        // It is told once, and what comes later is read.
        reader.push(b"0,{},Stop();").expect("room");
        assert_eq!(reader.next_reply().expect("a reply").map(|reply| reply.command), Some(CommandName::Stop));
        let mut reader = ReplyReader::default();
        reader.push(&[b'0'; BUFFER]).expect("room");
        assert!(reader.push(b"0").is_err());
        assert!(reader.push(b"0").is_ok());
    }
}
