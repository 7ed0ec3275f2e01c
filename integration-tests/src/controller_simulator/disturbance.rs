//! What goes wrong.

/// A fault of controller, arm, link or sender. Those without "at the start" begin at a time that the case gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Disturbance {
    /// Nothing does.
    None,
    /// The arm stands elsewhere at the start: joint from 0, degrees.
    WrongStart(usize, f64),
    /// An alarm at the start.
    AlarmAtStart,
    /// The drives are off at the start and may not be switched on.
    OffAtStart,
    /// The controller leads another model.
    OtherModel,
    /// The arm is in another mode at the start.
    ModeAtStart(u64),
    /// An alarm; the arm brakes.
    Alarm,
    /// The drives go off; the arm brakes.
    Off,
    /// The arm goes into another mode; it brakes.
    Mode(u64),
    /// A joint moves no more.
    Stuck(usize),
    /// Setpoints are refused. Version 3 does not answer them: there they are only forgotten.
    Refused,
    /// That many setpoints are forgotten.
    Forgotten(usize),
    /// No feedback any more.
    Silent,
    /// The same feedback again and again.
    Frozen,
    /// Feedback of random bytes.
    Garbage,
    /// A position that is no number.
    NotANumber,
    /// Every reply is a text that is none.
    ForeignReply,
    /// Both directions are down.
    Lost,
    /// Commands do not arrive any more, while the feedback goes on.
    Deaf,
    /// Both directions stand still for that many milliseconds.
    Delayed(u64),
    /// The sender stands still for that many milliseconds.
    Stalled(u64),
    /// The operator interrupts.
    Interrupted,
    /// The operator interrupts while the motion connection of version 3 stands still: setpoints that were sent come that many
    /// milliseconds after the stop.
    Overtaken(u64),
}
