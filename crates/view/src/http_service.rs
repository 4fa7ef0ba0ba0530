//! Responses to HTTP requests: page, geometry, stream of updates and slider moves; rejects requests of other origins.

use std::convert::Infallible;
use std::net::IpAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::time::{Duration, Instant};

use clearance_monitor::Revision;
use futures_lite::future;
use futures_lite::{Stream, stream};
use http_body_util::{BodyExt, Limited, StreamBody};
use hyper::body::{Bytes, Frame, Incoming};
use hyper::header::{self, HeaderValue};
use hyper::http::uri::Authority;
use hyper::{HeaderMap, Method, Request, Response, StatusCode};
use smol::Timer;
use smol::lock::{Semaphore, SemaphoreGuardArc};

use crate::assets::{ASSETS, TEXT};
use crate::geometry_documents;
use crate::latest_evaluation::{EvaluationSlot, TimedEvaluation};
use crate::state_control::{SliderMove, StateControl};
use crate::update_message::update;

/// Shortest time between two updates of one browser.
const UPDATE_PERIOD: Duration = Duration::from_millis(33);

/// Longest time between two updates. A page without updates for longer shows that nothing is known.
const LONGEST_PAUSE: Duration = Duration::from_millis(500);

/// Duration of one stream of updates. Browsers request another one at once, while a browser that reads nothing loses
/// its permit. The buffers of both systems hold megabytes of updates, so the connection itself would not show this for
/// minutes.
const STREAM_TIME: Duration = Duration::from_secs(4);

/// First line of a stream: time (ms) after which a browser reconnects.
const RETRY: &str = "retry: 20\n";

/// Largest number of browsers that receive updates at once.
pub const VIEWERS: usize = 8;

/// Largest number of geometry documents in memory at once. Further requests wait until one has been sent.
const DOCUMENTS: usize = 2;

/// Largest size (bytes) of the content of a request.
const CONTENT: usize = 1 << 10;

/// Timeout for receiving the content of a request.
const CONTENT_TIME: Duration = Duration::from_secs(5);

/// Size (bytes) of the pieces in which a response is written.
const CHUNK: usize = 64 << 10;

/// Content security policy: the page loads nothing from other origins, and no other page can embed or read it.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; \
                      base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

type Chunks = Pin<Box<dyn Stream<Item = Result<Frame<Bytes>, Infallible>> + Send>>;
pub type HttpResponse = Response<StreamBody<Chunks>>;

/// Handles all requests.
#[derive(Debug)]
pub struct HttpService {
    slot: Arc<EvaluationSlot>,
    /// The state that browsers may move; none beside a node.
    control: Option<Arc<StateControl>>,
    viewers: Arc<Semaphore>,
    documents: Arc<Semaphore>,
    /// One move of a slider is evaluated at a time.
    moves: Arc<Semaphore>,
}

impl HttpService {
    pub fn new(slot: Arc<EvaluationSlot>, control: Option<Arc<StateControl>>) -> Self {
        let permits = |count| Arc::new(Semaphore::new(count));
        Self { slot, control, viewers: permits(VIEWERS), documents: permits(DOCUMENTS), moves: permits(1) }
    }

    pub async fn respond(&self, request: Request<Incoming>) -> HttpResponse {
        if !is_for_this_machine(request.headers()) {
            let why = "open the view by an IP address or as localhost: under any other name it is not served";
            return rejection(StatusCode::MISDIRECTED_REQUEST, why);
        }
        if !is_of_same_origin(request.headers()) {
            let why = "pages from elsewhere cannot read the view: open it in a tab of its own";
            return rejection(StatusCode::FORBIDDEN, why);
        }
        if let Some(control) = self.control.as_ref().filter(|_| request.uri().path() == "/state") {
            return move_slider(control, &self.moves, request).await;
        }
        if request.method() != Method::GET {
            return rejection(StatusCode::METHOD_NOT_ALLOWED, "there is nothing but GET here");
        }
        match request.uri().path() {
            "/robot" => self.geometry(geometry_documents::robot).await,
            "/world" => self.geometry(geometry_documents::world).await,
            "/updates" => self.updates(),
            "/joints" => self.joints(),
            path => match ASSETS.iter().find(|asset| asset.path == path) {
                Some(asset) => whole(StatusCode::OK, asset.kind, Bytes::from_static(asset.content), None),
                None => rejection(StatusCode::NOT_FOUND, "there is no such page"),
            },
        }
    }

    /// Document about the robot and world of the last evaluation.
    async fn geometry(&self, document: fn(&Revision) -> Bytes) -> HttpResponse {
        let permit = self.documents.acquire_arc().await;
        let timed_evaluation = self.slot.last().clone();
        let Some(revision) =
            timed_evaluation.and_then(|timed_evaluation| timed_evaluation.evaluation.revision.clone())
        else {
            return rejection(StatusCode::NOT_FOUND, "there is no robot yet");
        };
        // building large meshes takes a while, so it runs on another thread and other browsers continue
        // the permit belongs to that work, which continues after the browser has disconnected
        let (document, permit) = smol::unblock(move || (document(&revision), permit)).await;
        whole(StatusCode::OK, "application/octet-stream", document, Some(permit))
    }

    /// Ranges of the sliders.
    fn joints(&self) -> HttpResponse {
        let Some(control) = &self.control else {
            return rejection(StatusCode::NOT_FOUND, "the node moves this robot: there are no sliders");
        };
        // serialising names and numbers cannot fail
        let text = serde_json::to_vec(control.sliders()).unwrap_or_default();
        whole(StatusCode::OK, "application/json", text.into(), None)
    }

    fn updates(&self) -> HttpResponse {
        let Some(permit) = self.viewers.try_acquire_arc() else {
            let why = "too many browsers watch already: close one of them";
            return rejection(StatusCode::SERVICE_UNAVAILABLE, why);
        };
        let events = stream::unfold(UpdateStream::new(self, permit), |mut updates| async {
            let event = updates.next_event().await?;
            Some((Ok(Frame::data(event)), updates))
        });
        response(StatusCode::OK, "text/event-stream", Box::pin(events))
    }
}

/// Update stream of one browser.
struct UpdateStream {
    slot: Arc<EvaluationSlot>,
    control: Option<Arc<StateControl>>,
    _permit: SemaphoreGuardArc,
    since: Instant,
    /// Last update sent, and its time.
    last: Option<(Option<Arc<TimedEvaluation>>, Instant)>,
}

impl UpdateStream {
    fn new(service: &HttpService, permit: SemaphoreGuardArc) -> Self {
        let (slot, control) = (Arc::clone(&service.slot), service.control.clone());
        Self { slot, control, _permit: permit, since: Instant::now(), last: None }
    }

    /// Waits for the next update: the newest evaluation once there is one, at most once per `UPDATE_PERIOD`, or the
    /// last one again after a pause. `None` when the stream has reached its duration.
    async fn next_event(&mut self) -> Option<Bytes> {
        while self.since.elapsed() < STREAM_TIME {
            let timed_evaluation = self.slot.last().clone();
            let is_due = self.last.as_ref().is_none_or(|(last, at)| {
                let is_new = last.as_ref().map(Arc::as_ptr) != timed_evaluation.as_ref().map(Arc::as_ptr);
                at.elapsed() >= if is_new { UPDATE_PERIOD } else { LONGEST_PAUSE }
            });
            if is_due {
                let now = Instant::now();
                let begin = if self.last.is_none() { RETRY } else { "" };
                let text = update(timed_evaluation.as_deref(), now, self.control.as_deref());
                let event = format!("{begin}data: {text}\n\n");
                self.last = Some((timed_evaluation, now));
                return Some(event.into());
            }
            Timer::after(UPDATE_PERIOD / 4).await;
        }
        None
    }
}

/// Moves a slider as a browser requests it: POST of a JSON text. Its content is not trusted.
async fn move_slider(
    control: &Arc<StateControl>,
    moves: &Arc<Semaphore>,
    request: Request<Incoming>,
) -> HttpResponse {
    if request.method() != Method::POST {
        return rejection(StatusCode::METHOD_NOT_ALLOWED, "a state is only set, by POST");
    }
    if request.headers().get(header::CONTENT_TYPE).is_none_or(|kind| kind != "application/json") {
        return rejection(StatusCode::UNSUPPORTED_MEDIA_TYPE, "a state is set by application/json");
    }
    let read = async { Limited::new(request.into_body(), CONTENT).collect().await.ok() };
    let late = async {
        Timer::after(CONTENT_TIME).await;
        None
    };
    let content = future::or(read, late).await.map(http_body_util::Collected::to_bytes);
    let Some(Ok(wanted)) = content.map(|content| serde_json::from_slice::<SliderMove>(&content)) else {
        let why = r#"the request must be like {"joint": "joint1", "position": 0.5}"#;
        return rejection(StatusCode::BAD_REQUEST, why);
    };
    let (control, permit) = (Arc::clone(control), moves.acquire_arc().await);
    // contacts of large meshes take a while, so it runs on another thread and other browsers continue
    // the permit belongs to that work, which continues after the browser has disconnected
    let moved = smol::unblock(move || {
        let moved = control.move_slider(&wanted);
        drop(permit);
        moved
    });
    match moved.await {
        Ok(()) => whole(StatusCode::OK, TEXT, Bytes::new(), None),
        Err(why) => rejection(StatusCode::BAD_REQUEST, why),
    }
}

/// Whether the host name in the request is an IP address or `localhost`. Any other name may have been pointed to this
/// machine by another site's page, which could then read the view (DNS rebinding).
fn is_for_this_machine(headers: &HeaderMap) -> bool {
    let mut hosts = headers.get_all(header::HOST).iter();
    let (Some(host), None) = (hosts.next(), hosts.next()) else {
        return false;
    };
    let Ok(authority) = Authority::try_from(host.as_bytes()) else {
        return false;
    };
    let name = authority.host().trim_start_matches('[').trim_end_matches(']');
    !host.as_bytes().contains(&b'@')
        && (name.eq_ignore_ascii_case("localhost") || name.parse::<IpAddr>().is_ok())
}

/// Whether a request comes from a page of this view, or from no page. For any other page, the browser sends its origin.
fn is_of_same_origin(headers: &HeaderMap) -> bool {
    let mut origins = headers.get_all(header::ORIGIN).iter();
    let (origin, another) = (origins.next(), origins.next());
    let own = headers.get(header::HOST).map(|host| [b"http://", host.as_bytes()].concat());
    let is_own =
        origin.is_none_or(|origin| own.is_some_and(|own| origin.as_bytes().eq_ignore_ascii_case(&own)));
    let is_from_another_site =
        headers.get("sec-fetch-site").is_some_and(|site| site == "cross-site" || site == "same-site");
    // any site may link to the page itself
    let is_navigation = headers.get("sec-fetch-mode").is_some_and(|mode| mode == "navigate");
    is_own && another.is_none() && (!is_from_another_site || is_navigation)
}

fn rejection(status: StatusCode, why: &'static str) -> HttpResponse {
    whole(status, TEXT, Bytes::from_static(why.as_bytes()), None)
}

/// Response of known length, sent piece by piece. Its permit, if it has one, is released once it has been sent.
fn whole(
    status: StatusCode,
    kind: &'static str,
    content: Bytes,
    permit: Option<SemaphoreGuardArc>,
) -> HttpResponse {
    let length = content.len();
    let chunks = stream::unfold((content, permit), |(mut left, permit)| async {
        if left.is_empty() {
            return None;
        }
        let chunk = left.split_to(left.len().min(CHUNK));
        Some((Ok(Frame::data(chunk)), (left, permit)))
    });
    let mut response = response(status, kind, Box::pin(chunks));
    response.headers_mut().insert(header::CONTENT_LENGTH, length.into());
    response
}

fn response(status: StatusCode, kind: &'static str, chunks: Chunks) -> HttpResponse {
    let mut response = Response::new(StreamBody::new(chunks));
    *response.status_mut() = status;
    for (name, value) in [
        (header::CONTENT_TYPE, kind),
        (header::CACHE_CONTROL, "no-store"),
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ] {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_pages_of_the_view_itself_read_it() {
        let asked = |lines: &[(&'static str, &'static str)]| {
            let mut headers = HeaderMap::new();
            headers.append(header::HOST, HeaderValue::from_static("127.0.0.1:8642"));
            for (name, value) in lines {
                headers.append(*name, HeaderValue::from_static(value));
            }
            is_of_same_origin(&headers)
        };
        assert!(
            asked(&[]) && asked(&[("origin", "http://127.0.0.1:8642"), ("sec-fetch-site", "same-origin")])
        );
        assert!(asked(&[("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate")]));
        for strange in [
            "http://127.0.0.1:8643",
            "http://localhost:8642",
            "https://127.0.0.1:8642",
            "http://evil.example",
            "http://127.0.0.1:8642.evil.example",
            "null",
            "",
        ] {
            assert!(!asked(&[("origin", strange)]), "{strange}");
        }
        let own = ("origin", "http://127.0.0.1:8642");
        assert!(!asked(&[own, ("origin", "http://evil.example")]) && !asked(&[own, own]));
        assert!(!asked(&[("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "no-cors")]));
    }

    #[test]
    fn only_numbers_and_localhost_are_served() {
        let asked = |hosts: &[&str]| {
            let mut headers = HeaderMap::new();
            for host in hosts {
                headers.append(header::HOST, HeaderValue::from_str(host).unwrap());
            }
            is_for_this_machine(&headers)
        };
        for own in ["127.0.0.1:8642", "localhost:8642", "LOCALHOST", "[::1]:8642", "10.0.0.7", "127.0.0.1"] {
            assert!(asked(&[own]), "{own}");
        }
        for strange in [
            "evil.example:8642",
            "localhost.evil.example",
            "",
            "127.0.0.1.nip.io",
            "evil@127.0.0.1",
            "1.2.3",
            "[x]",
        ] {
            assert!(!asked(&[strange]), "{strange}");
        }
        assert!(!asked(&[]));
        assert!(!asked(&["127.0.0.1", "evil.example"]));
    }
}
