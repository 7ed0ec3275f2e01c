//! The simulated controller on real ports, in real time.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{JoinHandle, sleep, spawn};
use std::time::{Duration, Instant};

use super::controller::{SimulatedController, Version};

/// A client that does not read loses its connection after this time.
const WRITE_TIME: Duration = Duration::from_millis(50);

/// A controller that is served; it ends with this value.
#[derive(Debug)]
pub struct Served {
    controller: Arc<Mutex<SimulatedController>>,
    ends: Arc<AtomicBool>,
    clock: Option<JoinHandle<()>>,
    /// Ports of dashboard, motion and feedback.
    pub ports: [u16; 3],
}

impl Served {
    /// The controller, for a look.
    pub fn controller(&self) -> MutexGuard<'_, SimulatedController> {
        self.controller.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        let _ = self.clock.take().map(JoinHandle::join);
    }
}

/// Serves a controller on ports of this machine; a port 0 is one that is free. The motion port belongs to version 3.
///
/// # Errors
/// Those of the operating system.
pub fn serve(controller: SimulatedController, ports: [u16; 3]) -> std::io::Result<Served> {
    let three = controller.version() == Version::Three;
    let mut listeners = Vec::new();
    let mut bound = [0; 3];
    for (i, port) in ports.into_iter().enumerate() {
        if i == 1 && !three {
            continue;
        }
        let listener = TcpListener::bind(("127.0.0.1", port))?;
        listener.set_nonblocking(true)?;
        bound[i] = listener.local_addr()?.port();
        listeners.push((i, listener));
    }
    let controller = Arc::new(Mutex::new(controller));
    let ends = Arc::new(AtomicBool::new(false));
    let clock = {
        let (controller, ends) = (controller.clone(), ends.clone());
        spawn(move || run(&controller, &listeners, &ends))
    };
    Ok(Served { controller, ends, clock: Some(clock), ports: bound })
}

/// Accepts, reads, steps and writes once a millisecond.
fn run(controller: &Mutex<SimulatedController>, listeners: &[(usize, TcpListener)], ends: &AtomicBool) {
    let begin = Instant::now();
    let mut clients: Vec<(usize, TcpStream)> = Vec::new();
    while !ends.load(Ordering::Relaxed) {
        for (port, listener) in listeners {
            if let Ok((stream, _)) = listener.accept() {
                let ready = stream.set_nonblocking(true).is_ok() && stream.set_nodelay(true).is_ok();
                if ready {
                    clients.push((*port, stream));
                }
            }
        }
        let (replies, feedback) = {
            let mut controller = controller.lock().unwrap_or_else(PoisonError::into_inner);
            clients.retain_mut(|(port, stream)| *port == 2 || hear(&mut controller, *port, stream));
            while controller.time() < begin.elapsed().as_millis() as u64 {
                controller.step();
            }
            (controller.take_replies(), controller.take_feedback())
        };
        clients.retain_mut(|(port, stream)| match port {
            0 => write(stream, &replies),
            2 => write(stream, &feedback),
            _ => true,
        });
        sleep(Duration::from_micros(500));
    }
}

/// Reads what is there; false if the client is gone.
fn hear(controller: &mut SimulatedController, port: usize, stream: &mut TcpStream) -> bool {
    let mut bytes = [0; 4096];
    loop {
        match stream.read(&mut bytes) {
            Ok(0) => return false,
            Ok(count) => controller.hear(port == 1, &bytes[..count]),
            Err(error) => return error.kind() == ErrorKind::WouldBlock,
        }
    }
}

/// Writes all of it; false if the client is gone or does not read.
fn write(stream: &mut TcpStream, mut bytes: &[u8]) -> bool {
    let begin = Instant::now();
    while !bytes.is_empty() {
        match stream.write(bytes) {
            Ok(count) => bytes = &bytes[count..],
            Err(error) if error.kind() == ErrorKind::WouldBlock && begin.elapsed() < WRITE_TIME => {
                sleep(Duration::from_micros(200));
            }
            Err(_) => return false,
        }
    }
    true
}
