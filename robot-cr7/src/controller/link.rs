//! Orders and events of a session as the bytes of Dobot's controllers.

use super::channel::Channel;
use super::dialect::Dialect;
use super::feedback::{FEEDBACK_BYTES, FeedbackReader, decode_feedback};
use super::reply::{CommandName, Reply, ReplyReader};
use super::stream::{Event, JointStream, LinkError, Order};

/// Bytes to and from a controller, with a clock.
pub trait Wire {
    /// The time, s. It never goes back.
    fn now(&self) -> f64;

    /// Sends bytes without waiting for room longer than some milliseconds.
    ///
    /// # Errors
    /// The fault of the connection.
    fn send(&mut self, channel: Channel, bytes: &[u8]) -> Result<(), LinkError>;

    /// The next bytes of any connection: their number and where they are from; `None` if there are none until the time `until` (s).
    ///
    /// # Errors
    /// The fault of the connection. One that lasts is told at the time `until`, so that those who ask again do not keep the processor busy.
    fn receive(&mut self, until: f64, bytes: &mut [u8; FEEDBACK_BYTES]) -> Result<Option<(Channel, usize)>, LinkError>;
}

/// The controller of a Dobot CR at the other end of a wire.
///
/// After a stop it takes no setpoint, whatever the session does. An arm to which setpoints were sent is stopped when the link is dropped.
#[derive(Debug)]
pub struct DobotLink<W: Wire> {
    wire: W,
    dialect: Dialect,
    feedback: FeedbackReader,
    replies: ReplyReader,
    /// Replies of the motion port of version 3.
    motion_replies: ReplyReader,
    text: String,
    bytes: [u8; FEEDBACK_BYTES],
    /// The part of `bytes` that is not read yet.
    left: (usize, usize),
    moved: bool,
    /// A stop was ordered; it was sent.
    stopped: bool,
    stop_is_sent: bool,
}

impl<W: Wire> DobotLink<W> {
    /// A link over connections that are open.
    pub fn new(wire: W, dialect: Dialect) -> Self {
        Self {
            wire,
            dialect,
            feedback: FeedbackReader::default(),
            replies: ReplyReader::default(),
            motion_replies: ReplyReader::default(),
            text: String::with_capacity(256),
            bytes: [0; FEEDBACK_BYTES],
            left: (0, 0),
            moved: false,
            stopped: false,
            stop_is_sent: false,
        }
    }

    /// The wire.
    pub fn wire(&self) -> &W {
        &self.wire
    }

    /// The next event in bytes that are here.
    fn held_event(&mut self) -> Result<Option<Event<6>>, LinkError> {
        loop {
            if let Some(packet) = self.feedback.next_packet() {
                return Ok(Some(Event::State(decode_feedback(&packet, self.dialect)?)));
            }
            let (begin, end) = self.left;
            if begin == end {
                break;
            }
            self.left.0 = end - self.feedback.push(&self.bytes[begin..end]).len();
        }
        for replies in [&mut self.replies, &mut self.motion_replies] {
            while let Some(reply) = replies.next_reply()? {
                if let Some(event) = event_of(&reply) {
                    return Ok(Some(event));
                }
            }
        }
        Ok(None)
    }
}

/// What a session has to know of a reply.
fn event_of(reply: &Reply) -> Option<Event<6>> {
    match (reply.command, reply.code) {
        (CommandName::Errors, 0) => Some(Event::Errors { count: reply.count, first: reply.values[0] }),
        (_, 0) => None,
        (command, code) => Some(Event::Refused { order: command.words(), code }),
    }
}

impl<W: Wire> JointStream<6> for DobotLink<W> {
    fn now(&self) -> f64 {
        self.wire.now()
    }

    fn send(&mut self, order: &Order<6>) -> Result<(), LinkError> {
        match order {
            Order::Setpoint { .. } if self.stopped => return Err(LinkError::AfterStop),
            Order::Setpoint { .. } => self.moved = true,
            Order::Stop => self.stopped = true,
            Order::AskErrors | Order::Enable => {}
        }
        self.text.clear();
        let channel = self.dialect.write(order, &mut self.text);
        self.wire.send(channel, self.text.as_bytes())?;
        self.stop_is_sent |= *order == Order::Stop;
        Ok(())
    }

    fn receive(&mut self, until: f64) -> Result<Option<Event<6>>, LinkError> {
        loop {
            if let Some(event) = self.held_event()? {
                return Ok(Some(event));
            }
            let Some((channel, count)) = self.wire.receive(until, &mut self.bytes)? else { return Ok(None) };
            match channel {
                Channel::Feedback => self.left = (0, count),
                Channel::Dashboard => self.replies.push(&self.bytes[..count])?,
                Channel::Motion => self.motion_replies.push(&self.bytes[..count])?,
            }
            // Bytes may come without end and mean nothing.
            if self.now() >= until {
                return self.held_event();
            }
        }
    }
}

impl<W: Wire> Drop for DobotLink<W> {
    /// Whatever ended the program: an arm that follows setpoints is stopped.
    fn drop(&mut self) {
        if self.moved && !self.stop_is_sent {
            let _ = self.send(&Order::Stop);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;

    use arcfeed_kinematics::Joints;

    use super::*;

    /// Keeps what is sent; a stop fails as often as the number says.
    #[derive(Default)]
    struct Paper(Rc<RefCell<Vec<String>>>, u32);

    impl Wire for Paper {
        fn now(&self) -> f64 {
            0.0
        }

        fn send(&mut self, channel: Channel, bytes: &[u8]) -> Result<(), LinkError> {
            let name = String::from_utf8_lossy(bytes).split('(').next().unwrap_or_default().to_owned();
            if name == "Stop" && self.1 > 0 {
                self.1 -= 1;
                return Err(LinkError::Closed(channel));
            }
            self.0.borrow_mut().push(format!("{channel} {name}"));
            Ok(())
        }

        fn receive(&mut self, _: f64, _: &mut [u8; FEEDBACK_BYTES]) -> Result<Option<(Channel, usize)>, LinkError> {
            Ok(None)
        }
    }

    /// Replies that say nothing new, one every 0.1 ms.
    struct Flood(u32);

    impl Wire for Flood {
        fn now(&self) -> f64 {
            1e-4 * f64::from(self.0)
        }

        fn send(&mut self, _: Channel, _: &[u8]) -> Result<(), LinkError> {
            Ok(())
        }

        fn receive(&mut self, _: f64, bytes: &mut [u8; FEEDBACK_BYTES]) -> Result<Option<(Channel, usize)>, LinkError> {
            let reply = b"0,{1},ServoJ();";
            bytes[..reply.len()].copy_from_slice(reply);
            self.0 += 1;
            Ok((self.0 < 100_000).then_some((Channel::Dashboard, reply.len())))
        }
    }

    #[test]
    fn a_flood_of_replies_keeps_no_one_waiting() {
        let mut link = DobotLink::new(Flood(0), Dialect::V4);
        assert_eq!(link.receive(0.005).expect("replies"), None);
        assert!(link.now() < 0.006, "{}", link.now());
    }

    const SETPOINT: Order<6> = Order::Setpoint { q: Joints::<6>::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), period: 0.03 };

    #[test]
    fn after_a_stop_no_setpoint_leaves_the_link() {
        let paper = Paper::default();
        let said = paper.0.clone();
        let mut link = DobotLink::new(paper, Dialect::V3);
        for order in [SETPOINT, Order::Stop, SETPOINT, Order::Stop] {
            let sent = link.send(&order);
            assert_eq!(matches!(sent, Err(LinkError::AfterStop)), said.borrow().len() == 2 && order == SETPOINT);
        }
        drop(link);
        assert_eq!(*said.borrow(), ["motion ServoJ", "dashboard ResetRobot", "dashboard ResetRobot"]);
    }

    #[test]
    fn a_stop_that_did_not_leave_is_sent_when_the_link_goes() {
        let paper = Paper(Rc::default(), 1);
        let said = paper.0.clone();
        let mut link = DobotLink::new(paper, Dialect::V4);
        link.send(&SETPOINT).expect("paper");
        assert!(link.send(&Order::Stop).is_err() && link.send(&SETPOINT).is_err());
        drop(link);
        assert_eq!(*said.borrow(), ["dashboard ServoJ", "dashboard Stop"]);
    }

    #[test]
    fn an_arm_that_is_led_is_stopped_when_the_link_goes() {
        for (orders, expected) in [(&[SETPOINT][..], vec!["dashboard ServoJ", "dashboard Stop"]), (&[], vec![])] {
            let paper = Paper::default();
            let said = paper.0.clone();
            let mut link = DobotLink::new(paper, Dialect::V4);
            orders.iter().for_each(|order| link.send(order).expect("paper"));
            drop(link);
            assert_eq!(*said.borrow(), expected);
        }
    }
}
