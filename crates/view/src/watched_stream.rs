//! TCP connection that detects a peer that has stopped reading: records since when writes have been blocked.

use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

use smol::Timer;
use smol::io::{AsyncRead, AsyncWrite};
use smol::net::TcpStream;

/// Time between two checks of whether the peer reads.
const PERIOD: Duration = Duration::from_millis(500);

/// Forwards all operations, and records when a write blocks.
#[derive(Debug)]
pub struct WatchedStream {
    stream: TcpStream,
    blocked: Blocked,
}

/// Time since which a peer has not read the pending data, if any.
#[derive(Clone, Debug, Default)]
pub struct Blocked(Arc<Mutex<Option<Instant>>>);

impl WatchedStream {
    pub fn new(stream: TcpStream) -> Self {
        Self { stream, blocked: Blocked::default() }
    }

    pub fn blocked(&self) -> Blocked {
        self.blocked.clone()
    }
}

impl Blocked {
    fn note(&self, is_blocked: bool) {
        let mut since = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        *since = if is_blocked { since.or_else(|| Some(Instant::now())) } else { None };
    }

    /// Returns once the peer has read nothing for this time.
    pub async fn for_long(&self, time: Duration) {
        loop {
            let since = *self.0.lock().unwrap_or_else(PoisonError::into_inner);
            if since.is_some_and(|since| since.elapsed() >= time) {
                return;
            }
            Timer::after(PERIOD).await;
        }
    }
}

impl AsyncRead for WatchedStream {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut [u8],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_read(cx, buffer)
    }
}

impl AsyncWrite for WatchedStream {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(cx, bytes);
        self.blocked.note(written.is_pending());
        written
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_close(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_close(cx)
    }
}
