//! A connection in memory, for fuzz targets: the request is there at once, and the response is kept.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use smol::io::{AsyncRead, AsyncWrite};

use crate::http_service::HttpService;
use crate::latest_evaluation::EvaluationSlot;
use crate::server::respond;

/// The response of a view without a robot to the bytes of a browser.
#[must_use]
pub fn respond_in_memory(request: &[u8]) -> Vec<u8> {
    let mut response = Vec::new();
    let stream = InMemory { request, response: &mut response };
    smol::block_on(respond(stream, &Arc::new(HttpService::new(Arc::new(EvaluationSlot::default()), None))));
    response
}

struct InMemory<'m> {
    request: &'m [u8],
    response: &'m mut Vec<u8>,
}

impl AsyncRead for InMemory<'_> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        _: &mut Context<'_>,
        buffer: &mut [u8],
    ) -> Poll<io::Result<usize>> {
        Poll::Ready(io::Read::read(&mut self.request, buffer))
    }
}

impl AsyncWrite for InMemory<'_> {
    fn poll_write(mut self: Pin<&mut Self>, _: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        self.response.extend_from_slice(bytes);
        Poll::Ready(Ok(bytes.len()))
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_close(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}
