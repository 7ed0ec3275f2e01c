//! The connections to a real controller.

use std::io::{ErrorKind, Read, Write};
use std::net::{IpAddr, SocketAddr, TcpStream};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use super::channel::Channel;
use super::dialect::Dialect;
use super::feedback::FEEDBACK_BYTES;
use super::link::Wire;
use super::stream::LinkError;

/// How long a connection may take.
const CONNECT_TIME: Duration = Duration::from_secs(3);
/// How long a write may wait for room.
const WRITE_TIME: Duration = Duration::from_millis(20);
/// Pieces that wait to be read.
const WAITING: usize = 256;

/// The ports of a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ports {
    /// Commands.
    pub dashboard: u16,
    /// Motion commands of version 3.
    pub motion: u16,
    /// The state of the arm.
    pub feedback: u16,
}

impl Default for Ports {
    /// Those of the maker.
    fn default() -> Self {
        Self { dashboard: 29999, motion: 30003, feedback: 30004 }
    }
}

impl Ports {
    fn of(self, channel: Channel) -> u16 {
        match channel {
            Channel::Dashboard => self.dashboard,
            Channel::Motion => self.motion,
            Channel::Feedback => self.feedback,
        }
    }
}

/// Bytes as one read gave them; of a fault, its kind.
struct Piece {
    channel: Channel,
    bytes: [u8; FEEDBACK_BYTES],
    read: Result<usize, ErrorKind>,
}

/// TCP connections to a controller. A thread for each of them reads.
#[derive(Debug)]
pub struct TcpWire {
    begin: Instant,
    streams: Vec<(Channel, TcpStream)>,
    pieces: Receiver<Piece>,
}

impl TcpWire {
    /// Opens the connections of a dialect.
    ///
    /// # Errors
    /// [`LinkError::Io`] with the connection that cannot be opened.
    pub fn connect(address: IpAddr, ports: Ports, dialect: Dialect) -> Result<Self, LinkError> {
        let (sender, pieces) = sync_channel(WAITING);
        let mut streams = Vec::new();
        for &channel in dialect.channels() {
            let open = || {
                let stream = TcpStream::connect_timeout(&SocketAddr::new(address, ports.of(channel)), CONNECT_TIME)?;
                stream.set_nodelay(true)?;
                stream.set_write_timeout(Some(WRITE_TIME))?;
                let reader = stream.try_clone()?;
                let sender = sender.clone();
                let name = format!("{channel} connection");
                std::thread::Builder::new().name(name).spawn(move || read(channel, reader, &sender))?;
                Ok(stream)
            };
            streams.push((channel, open().map_err(|source| LinkError::Io { channel, source })?));
        }
        Ok(Self { begin: Instant::now(), streams, pieces })
    }
}

/// Hands on what comes, until the connection or the wire ends.
fn read(channel: Channel, mut stream: TcpStream, sender: &SyncSender<Piece>) {
    loop {
        let mut piece = Piece { channel, bytes: [0; FEEDBACK_BYTES], read: Ok(0) };
        piece.read = stream.read(&mut piece.bytes).map_err(|error| error.kind());
        let goes_on = match piece.read {
            Err(ErrorKind::Interrupted) => continue,
            Ok(count) => count > 0,
            Err(_) => false,
        };
        if sender.send(piece).is_err() || !goes_on {
            return;
        }
    }
}

impl Wire for TcpWire {
    fn now(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }

    fn send(&mut self, channel: Channel, bytes: &[u8]) -> Result<(), LinkError> {
        let Some((_, stream)) = self.streams.iter_mut().find(|(other, _)| *other == channel) else {
            return Err(LinkError::Closed(channel));
        };
        stream.write_all(bytes).map_err(|source| LinkError::Io { channel, source })
    }

    fn receive(&mut self, until: f64, bytes: &mut [u8; FEEDBACK_BYTES]) -> Result<Option<(Channel, usize)>, LinkError> {
        let wait = Duration::from_secs_f64((until - self.now()).max(0.0).min(3600.0));
        let piece = match self.pieces.recv_timeout(wait) {
            Ok(piece) => piece,
            Err(RecvTimeoutError::Timeout) => return Ok(None),
            Err(RecvTimeoutError::Disconnected) => {
                // No thread reads any more.
                std::thread::sleep(wait);
                return Err(LinkError::Closed(Channel::Dashboard));
            }
        };
        match piece.read {
            Ok(0) => Err(LinkError::Closed(piece.channel)),
            Ok(count) => {
                *bytes = piece.bytes;
                Ok(Some((piece.channel, count)))
            }
            Err(kind) => Err(LinkError::Io { channel: piece.channel, source: kind.into() }),
        }
    }
}

impl Drop for TcpWire {
    /// Ends the threads that read.
    fn drop(&mut self) {
        for (_, stream) in &self.streams {
            let _ = stream.shutdown(std::net::Shutdown::Both);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;

    #[test]
    fn connections_that_are_closed_do_not_keep_the_processor_busy() {
        let listen = || TcpListener::bind(("127.0.0.1", 0)).expect("a port");
        let (dashboard, feedback) = (listen(), listen());
        let port = |listener: &TcpListener| listener.local_addr().expect("its number").port();
        let ports = Ports { dashboard: port(&dashboard), motion: 0, feedback: port(&feedback) };
        let mut wire = TcpWire::connect([127, 0, 0, 1].into(), ports, Dialect::V4).expect("connections");
        drop((dashboard.accept(), feedback.accept()));
        let mut errors = 0;
        while wire.now() < 0.2 {
            errors += usize::from(wire.receive(wire.now() + 0.005, &mut [0; FEEDBACK_BYTES]).is_err());
        }
        assert!((3..=45).contains(&errors), "{errors}");
    }
}
