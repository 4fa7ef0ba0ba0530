//! HTTP server of the view: one thread, and a bounded number of connections with timeouts.

use std::convert::Infallible;
use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use futures_lite::future;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use smol::channel::{self, Receiver, Sender};
use smol::io::{AsyncRead, AsyncWrite};
use smol::lock::Semaphore;
use smol::net::{TcpListener, TcpStream};
use smol::{LocalExecutor, Timer};
use smol_hyper::rt::{FuturesIo, SmolTimer};

use crate::address::ViewAddress;
use crate::http_service::{HttpService, VIEWERS};
use crate::latest_evaluation::EvaluationSlot;
use crate::state_control::StateControl;
use crate::watched_stream::WatchedStream;
use clearance_monitor::{Evaluation, MonitorSettings};

/// Largest number of connections at once; a page needs two beside its updates.
const CONNECTIONS: usize = 4 * VIEWERS;

/// Timeout for receiving a request.
const REQUEST_TIME: Duration = Duration::from_secs(5);

/// Timeout for a browser that does not read its response.
const STANDSTILL: Duration = Duration::from_secs(5);

/// Largest size (bytes) of a request, and of the unsent part of a response.
const BUFFER: usize = 64 << 10;

/// Error: the server of the view cannot be started.
#[derive(Debug, thiserror::Error)]
#[error("the view can not be served at {address}: {error}")]
pub struct ViewError {
    address: SocketAddr,
    error: std::io::Error,
}

/// Callback that receives every evaluation and its settings, for a display outside of ROS. It must return quickly.
pub type Observer = Box<dyn FnMut(&Evaluation, &MonitorSettings) + Send>;

/// A running server of the view; dropping it stops the server.
#[derive(Debug)]
pub struct View {
    url: String,
    slot: Arc<EvaluationSlot>,
    stop: Sender<()>,
    thread: Option<JoinHandle<()>>,
}

impl View {
    /// Starts the server at an address.
    pub fn open(address: &ViewAddress) -> Result<Self, ViewError> {
        Self::start(address, Arc::default(), None)
    }

    /// Starts the server of a slot; with a control, browsers may move the robot.
    pub(crate) fn start(
        address: &ViewAddress,
        slot: Arc<EvaluationSlot>,
        control: Option<Arc<StateControl>>,
    ) -> Result<Self, ViewError> {
        let failed = |error| ViewError { address: address.socket, error };
        let (listener, socket) = listen(address).map_err(failed)?;
        let (stop, stopped) = channel::bounded(1);
        let http = Arc::new(HttpService::new(Arc::clone(&slot), control));
        let thread = thread::Builder::new().name("view".to_owned());
        let thread = thread.spawn(move || serve(&listener, &http, &stopped)).map_err(failed)?;
        Ok(Self { url: format!("http://{socket}/"), slot, stop, thread: Some(thread) })
    }

    /// URL of the page.
    #[must_use]
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Callback that passes evaluations to the view; it never waits.
    #[must_use]
    pub fn observer(&self) -> Observer {
        let slot = Arc::clone(&self.slot);
        Box::new(move |evaluation, settings| slot.put(evaluation, settings))
    }
}

impl Drop for View {
    fn drop(&mut self) {
        self.stop.close();
        if let Some(thread) = self.thread.take() {
            // a panic of the view's thread has no effect on the node
            let _ = thread.join();
        }
    }
}

fn listen(address: &ViewAddress) -> std::io::Result<(TcpListener, SocketAddr)> {
    let bind = |socket: SocketAddr| std::net::TcpListener::bind(socket);
    let listener = match bind(address.socket) {
        Err(error) if address.any_port && error.kind() == std::io::ErrorKind::AddrInUse => {
            bind(SocketAddr::new(address.socket.ip(), 0))?
        }
        other => other?,
    };
    let socket = listener.local_addr()?;
    Ok((listener.try_into()?, socket))
}

fn serve(listener: &TcpListener, http: &Arc<HttpService>, stopped: &Receiver<()>) {
    let executor = LocalExecutor::new();
    let permits = Arc::new(Semaphore::new(CONNECTIONS));
    let accept = async {
        loop {
            // further connections wait in the system's queue until one of these ends
            let permit = permits.acquire_arc().await;
            match listener.accept().await {
                Ok((stream, _)) => {
                    let http = Arc::clone(http);
                    let connection = async move {
                        serve_connection(stream, &http).await;
                        drop(permit);
                    };
                    executor.spawn(connection).detach();
                }
                Err(error) => {
                    log::debug!("the view: a connection failed: {error}");
                    Timer::after(Duration::from_millis(100)).await;
                }
            }
        }
    };
    let stop = async {
        // no message is ever sent: closing the channel signals the end
        let _ = stopped.recv().await;
    };
    smol::block_on(executor.run(future::or(stop, accept)));
}

/// Responds to one request, unless the browser receives nothing of the response for too long.
async fn serve_connection(stream: TcpStream, http: &Arc<HttpService>) {
    let stream = WatchedStream::new(stream);
    let blocked = stream.blocked();
    future::or(respond(stream, http), blocked.for_long(STANDSTILL)).await;
}

/// Answers one request.
pub async fn respond(stream: impl AsyncRead + AsyncWrite + Unpin, http: &Arc<HttpService>) {
    let service = {
        let http = Arc::clone(http);
        service_fn(move |request| {
            let http = Arc::clone(&http);
            async move { Ok::<_, Infallible>(http.respond(request).await) }
        })
    };
    let connection = http1::Builder::new()
        .timer(SmolTimer::new())
        .header_read_timeout(REQUEST_TIME)
        .keep_alive(false)
        .max_buf_size(BUFFER)
        .serve_connection(FuturesIo::new(stream), service);
    if let Err(error) = connection.await {
        log::debug!("the view: a browser has gone: {error}");
    }
}
