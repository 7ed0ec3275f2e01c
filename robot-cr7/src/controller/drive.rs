//! A session on a stream.

use super::arm_state::ArmState;
use super::fault::Fault;
use super::log::SendLog;
use super::session::Session;
use super::setpoints::SetpointSource;
use super::stream::{Event, JointStream, Order};

/// The longest time between two looks at the wish of the operator, s.
const LOOK_AGAIN: f64 = 0.005;
/// How long a look at a controller may take, s.
const LOOK_TIME: f64 = 2.0;

/// Runs a session to its end. `interrupted` is asked every few milliseconds.
pub fn drive<M: SetpointSource<N>, S: JointStream<N>, const N: usize>(
    session: &mut Session<M, N>,
    stream: &mut S,
    log: &mut SendLog<N>,
    mut interrupted: impl FnMut() -> bool,
) {
    while !session.is_over() {
        if interrupted() {
            session.interrupt(stream.now());
        }
        loop {
            let Some(order) = session.next_order(stream.now()) else {
                if session.has_planned() {
                    continue;
                }
                break;
            };
            match stream.send(&order) {
                Ok(()) if order == Order::Stop => session.stop_is_sent(stream.now()),
                Ok(()) => {}
                Err(error) => session.lose(stream.now(), &error.to_string()),
            }
        }
        if session.is_over() {
            return;
        }
        match stream.receive(session.due().min(stream.now() + LOOK_AGAIN)) {
            Ok(Some(event)) => {
                let now = stream.now();
                if let Event::State(state) = &event {
                    log.see(now, session.setpoint(), state);
                }
                session.see(now, &event);
            }
            Ok(None) => {}
            Err(error) => session.lose(stream.now(), &error.to_string()),
        }
    }
}

/// What a controller says without being asked to move anything.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Survey<const N: usize = 6> {
    /// The state of the arm.
    pub state: ArmState<N>,
    /// The number of errors that are not cleared.
    pub errors: usize,
    /// The first of them.
    pub first_error: i64,
}

/// Looks at a controller. No motion and no enabling is ordered.
///
/// # Errors
/// [`Fault::Link`], [`Fault::Silence`], [`Fault::NoAnswer`], [`Fault::Refused`].
pub fn survey<S: JointStream<N>, const N: usize>(stream: &mut S) -> Result<Survey<N>, Fault> {
    let link = |error: super::stream::LinkError| Fault::Link(error.to_string());
    let begin = stream.now();
    stream.send(&Order::AskErrors).map_err(link)?;
    let (mut state, mut errors) = (None, None);
    loop {
        if let (Some(state), Some((errors, first_error))) = (state, errors) {
            return Ok(Survey { state, errors, first_error });
        }
        let waited = stream.now() - begin;
        match stream.receive(begin + LOOK_TIME).map_err(link)? {
            Some(Event::State(seen)) => state = Some(seen),
            Some(Event::Errors { count, first }) => errors = Some((count, first)),
            Some(Event::Refused { order, code }) => return Err(Fault::Refused { order, code }),
            None => {}
        }
        if waited >= LOOK_TIME {
            return Err(match state {
                None => Fault::Silence { silence: waited },
                Some(_) => Fault::NoAnswer { order: "GetErrorID", waited },
            });
        }
    }
}
