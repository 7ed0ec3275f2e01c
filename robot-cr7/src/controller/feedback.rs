//! The state of the arm as the controller sends it: packets of 1440 bytes every 8 ms, little endian, the same in both versions.
//!
//! Offsets from the tables "real-time feedback" of the maker's manuals.

use arcfeed_kinematics::Joints;

use super::arm_state::ArmState;
use super::dialect::Dialect;
use super::stream::LinkError;

/// Length of a packet.
pub const FEEDBACK_BYTES: usize = 1440;
/// The time between two packets, s.
pub const FEEDBACK_PERIOD: f64 = 0.008;

/// The number that every packet has at [`TEST`].
const TEST_VALUE: u64 = 0x0123_4567_89AB_CDEF;
const MODE: usize = 24;
const CLOCK: usize = 32;
const TEST: usize = 48;
const Q_TARGET: usize = 192;
const Q_ACTUAL: usize = 432;
const QD_ACTUAL: usize = 480;
const ENABLED: usize = 1026;
const ALARM: usize = 1029;
const MODEL: usize = 1031;

fn word(bytes: &[u8], at: usize) -> u64 {
    let mut word = [0; 8];
    word.copy_from_slice(&bytes[at..at + 8]);
    u64::from_le_bytes(word)
}

/// Six angles in degrees, as rad.
fn joints(bytes: &[u8], at: usize, what: &'static str) -> Result<Joints<6>, LinkError> {
    let value = |k: usize| f64::from_bits(word(bytes, at + 8 * k));
    match (0..6).find(|&joint| !value(joint).is_finite()) {
        Some(joint) => Err(LinkError::NotANumber { what, joint, value: value(joint) }),
        None => Ok(Joints::from(std::array::from_fn(|k| value(k).to_radians()))),
    }
}

/// The state in a packet.
///
/// # Errors
/// [`LinkError::NotANumber`] for a position or velocity that is none.
pub fn decode_feedback(packet: &[u8; FEEDBACK_BYTES], dialect: Dialect) -> Result<ArmState<6>, LinkError> {
    Ok(ArmState {
        mode: dialect.mode(word(packet, MODE)),
        enabled: packet[ENABLED] != 0,
        alarm: packet[ALARM] != 0,
        clock_ms: word(packet, CLOCK),
        model: packet[MODEL],
        q: joints(packet, Q_ACTUAL, "position")?,
        qd: joints(packet, QD_ACTUAL, "velocity")?,
        q_target: joints(packet, Q_TARGET, "target position")?,
    })
}

/// Cuts a stream of bytes into packets, and finds the next one where bytes are missing or foreign. It does not allocate.
#[derive(Debug, Clone)]
pub struct FeedbackReader {
    bytes: [u8; 2 * FEEDBACK_BYTES],
    held: usize,
}

impl Default for FeedbackReader {
    fn default() -> Self {
        Self { bytes: [0; 2 * FEEDBACK_BYTES], held: 0 }
    }
}

impl FeedbackReader {
    /// Takes as many of the bytes as there is room for, and returns the others: call [`FeedbackReader::next_packet`] before the rest.
    pub fn push<'b>(&mut self, bytes: &'b [u8]) -> &'b [u8] {
        let (now, later) = bytes.split_at(bytes.len().min(self.bytes.len() - self.held));
        self.bytes[self.held..self.held + now.len()].copy_from_slice(now);
        self.held += now.len();
        later
    }

    /// The next whole packet; `None` until it is there.
    pub fn next_packet(&mut self) -> Option<[u8; FEEDBACK_BYTES]> {
        while self.held >= FEEDBACK_BYTES {
            let begins = |at: usize| {
                let length = u16::from_le_bytes([self.bytes[at], self.bytes[at + 1]]);
                usize::from(length) == FEEDBACK_BYTES && word(&self.bytes, at + TEST) == TEST_VALUE
            };
            if begins(0) {
                let mut packet = [0; FEEDBACK_BYTES];
                packet.copy_from_slice(&self.bytes[..FEEDBACK_BYTES]);
                self.drop_first(FEEDBACK_BYTES);
                return Some(packet);
            }
            let last = self.held - TEST - 8;
            let next = (1..=last).find(|&at| begins(at)).unwrap_or(last + 1);
            self.drop_first(next);
        }
        None
    }

    fn drop_first(&mut self, count: usize) {
        self.bytes.copy_within(count..self.held, 0);
        self.held -= count;
    }
}

#[cfg(test)]
mod tests {
    use super::super::arm_state::ArmMode;
    use super::*;

    /// A packet byte by byte from the table of the manual.
    fn packet(clock: u8) -> [u8; FEEDBACK_BYTES] {
        let mut packet = [0; FEEDBACK_BYTES];
        packet[0..2].copy_from_slice(&[0xA0, 0x05]); // 1440
        packet[24] = 5;
        packet[32] = clock;
        packet[48..56].copy_from_slice(&[0xEF, 0xCD, 0xAB, 0x89, 0x67, 0x45, 0x23, 0x01]);
        // 90.0 as the target of joint 1; -45.0 and 1.5 as position and velocity of joint 6.
        packet[192..200].copy_from_slice(&[0, 0, 0, 0, 0, 0x80, 0x56, 0x40]);
        packet[472..480].copy_from_slice(&[0, 0, 0, 0, 0, 0x80, 0x46, 0xC0]);
        packet[520..528].copy_from_slice(&[0, 0, 0, 0, 0, 0, 0xF8, 0x3F]);
        packet[1026] = 1;
        packet[1031] = 7;
        packet
    }

    #[test]
    fn a_packet_of_the_manual_is_read() {
        let state = decode_feedback(&packet(9), Dialect::V4).expect("numbers");
        assert_eq!((state.mode, state.enabled, state.alarm), (ArmMode::Idle, true, false));
        assert_eq!((state.clock_ms, state.model), (9, 7));
        assert_eq!(state.q_target[0], 90f64.to_radians());
        assert_eq!((state.q[5], state.qd[5]), ((-45f64).to_radians(), 1.5f64.to_radians()));
        assert!(state.q.iter().take(5).chain(state.q_target.iter().skip(1)).all(|q| *q == 0.0));
    }

    #[test]
    fn a_position_that_is_no_number_is_refused() {
        let mut packet = packet(0);
        packet[432..440].copy_from_slice(&f64::NAN.to_le_bytes());
        let error = decode_feedback(&packet, Dialect::V3).expect_err("a NaN").to_string();
        assert!(error.contains("position of joint 1"), "{error}");
    }

    #[test]
    fn packets_are_found_in_any_pieces_and_after_foreign_bytes() {
        let mut bytes = vec![0xA0; 700];
        bytes.extend(packet(1));
        bytes.extend(packet(2));
        bytes.extend(&packet(3)[..1000]);
        bytes.extend(packet(4));
        bytes.extend(packet(5));
        for length in [1, 7, 512, 1440, 4000, bytes.len()] {
            let mut reader = FeedbackReader::default();
            let mut clocks = Vec::new();
            for mut piece in bytes.chunks(length) {
                while !piece.is_empty() {
                    piece = reader.push(piece);
                    while let Some(packet) = reader.next_packet() {
                        clocks.push(packet[32]);
                    }
                }
            }
            // A packet that is cut takes bytes of the next one with it.
            assert_eq!(clocks.iter().filter(|clock| **clock != 3 && **clock != 4).collect::<Vec<_>>(), [&1, &2, &5]);
        }
    }
}
