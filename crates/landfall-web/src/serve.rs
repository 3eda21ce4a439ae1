//! The server of the playground, on the loopback interface.
//!
//! Its URL has a secret token. A request needs the token, the host of that URL and, if it names one,
//! its origin; it gets the page, the files that the caller serves, or what the engine of the
//! playground answers, and nothing else.

use std::io::Read;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use data_encoding::HEXLOWER;
use landfall_layout::Error;
use oxhttp::model::{Body, HeaderValue, Method, Request, Response, StatusCode};
use oxhttp::{ListeningServer, Server};
use serde::Deserialize;

use crate::playground::page::{Engine, Opened, page};
use crate::playground::{self, MAX_BYTES};

/// Connections at a time.
const CONNECTIONS: usize = 32;

/// Time that a request or its answer may take on the wire.
const TIMEOUT: Duration = Duration::from_secs(10);

/// Time that a request waits for a change of a file.
const MAX_WAIT: Duration = Duration::from_secs(8);

/// Requests that wait for a change: the other connections answer questions.
const MAX_WAITING: usize = CONNECTIONS / 2;

/// Time between two looks at the files while a request waits.
const INTERVAL: Duration = Duration::from_millis(150);

/// The files of a page.
pub trait ServedFiles: Send {
    /// Reads what has changed, and returns a number that every change raises.
    fn look(&mut self) -> u64;

    /// The files as an array in JSON.
    fn json(&self) -> String;

    /// Writes a scene back to its file.
    ///
    /// # Errors
    ///
    /// It is no scene of the page, the text is no JSON, or the file cannot be written.
    fn save(&self, path: &str, text: &str) -> Result<(), Error>;
}

/// A page that is served as long as this value lives.
pub struct ServedPage {
    /// Where it is, with the token.
    pub url: String,
    _server: ListeningServer,
}

impl std::fmt::Debug for ServedPage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ServedPage").finish_non_exhaustive()
    }
}

/// Serves the page of these files at a port of the loopback interface; 0 takes a free one.
///
/// # Errors
///
/// The port is taken, or the system gives no random bits for the token.
pub fn serve(
    port: u16,
    opened: &Opened<'_>,
    files: impl ServedFiles + 'static,
) -> Result<ServedPage, Error> {
    let (page, policy) = page(Engine::Server(opened));
    let address = free_address(port)?;
    let place = PageAddress { host: address.to_string(), token: token()? };
    let url = place.url();
    let files = Mutex::new(Box::new(files) as Box<dyn ServedFiles>);
    let site = Arc::new(ServedSite { place, page, policy, files, waiting: AtomicUsize::new(0) });
    let server = Server::new(move |request| site.answer(request))
        .with_global_timeout(TIMEOUT)
        .with_max_concurrent_connections(CONNECTIONS)
        .bind(address);
    let _server = server.spawn().map_err(|cause| cannot_bind(address, &cause))?;
    Ok(ServedPage { url, _server })
}

/// An address of the loopback interface that nobody listens at.
fn free_address(port: u16) -> Result<SocketAddr, Error> {
    let wanted = SocketAddr::from((Ipv4Addr::LOCALHOST, port));
    // The server binds it again: whoever is faster then makes that fail.
    TcpListener::bind(wanted)
        .and_then(|listener| listener.local_addr())
        .map_err(|cause| cannot_bind(wanted, &cause))
}

fn cannot_bind(address: SocketAddr, cause: &std::io::Error) -> Error {
    let message = format!("cannot be listened at: {}", landfall_layout::file::reason(cause));
    Error::new(address.to_string(), message).with_help("name another port with `--port`")
}

/// 128 random bits in hexadecimal.
fn token() -> Result<String, Error> {
    let mut bytes = [0u8; 16];
    getrandom::fill(&mut bytes)
        .map_err(|cause| Error::new("the token", format!("cannot be drawn: {cause}")))?;
    Ok(HEXLOWER.encode(&bytes))
}

/// Where the page is.
struct PageAddress {
    /// Address and port.
    host: String,
    token: String,
}

impl PageAddress {
    fn url(&self) -> String {
        format!("http://{}/{}/", self.host, self.token)
    }

    /// What follows the token in the path of a request that may be answered.
    fn allows<'r>(&self, request: &'r Request<Body>) -> Result<&'r str, StatusCode> {
        let all = |name: &str| request.headers().get_all(name).iter();
        let mut hosts = all("host");
        let is_own = hosts.next().is_some_and(|host| host.as_bytes() == self.host.as_bytes());
        let origin = format!("http://{}", self.host);
        let is_from_page = all("origin").all(|given| given.as_bytes() == origin.as_bytes())
            && all("sec-fetch-site")
                .all(|site| matches!(site.as_bytes(), b"same-origin" | b"none"));
        if !is_own || hosts.next().is_some() || !is_from_page {
            return Err(StatusCode::FORBIDDEN);
        }
        let (token, rest) = request
            .uri()
            .path()
            .strip_prefix('/')
            .and_then(|path| path.split_once('/'))
            .ok_or(StatusCode::NOT_FOUND)?;
        if is_same(token.as_bytes(), self.token.as_bytes()) {
            Ok(rest)
        } else {
            Err(StatusCode::NOT_FOUND)
        }
    }
}

/// Compares in a time that does not depend on where the two differ.
fn is_same(given: &[u8], secret: &[u8]) -> bool {
    let differ = given.iter().zip(secret).fold(0, |all, (a, b)| all | (a ^ b));
    given.len() == secret.len() && differ == 0
}

/// What the server answers with.
struct ServedSite {
    place: PageAddress,
    page: String,
    policy: String,
    files: Mutex<Box<dyn ServedFiles>>,
    /// Requests that wait for a change.
    waiting: AtomicUsize,
}

impl ServedSite {
    fn answer(&self, request: &mut Request<Body>) -> Response<Body> {
        // oxhttp sends the error 500 over a connection that was quiet for the time limit, and a
        // browser may take it for the answer to its next request: each answer ends its connection.
        request.headers_mut().insert("connection", HeaderValue::from_static("close"));
        let (status, kind, text) = match self.content(request) {
            Ok((kind, text)) => (StatusCode::OK, kind, text),
            Err(status) => (status, "text/plain", String::new()),
        };
        Response::builder()
            .status(status)
            .header("Content-Type", format!("{kind}; charset=utf-8"))
            .header("Content-Security-Policy", format!("{}; frame-ancestors 'none'", self.policy))
            .header("X-Content-Type-Options", "nosniff")
            .header("Referrer-Policy", "no-referrer")
            .header("Cross-Origin-Opener-Policy", "same-origin")
            .header("Cross-Origin-Resource-Policy", "same-origin")
            .header("Cache-Control", "no-store")
            .body(Body::from(text))
            .expect("the headers are well formed")
    }

    fn content(&self, request: &mut Request<Body>) -> Result<(&'static str, String), StatusCode> {
        const JSON: &str = "application/json";
        let method = request.method().clone();
        match (&method, self.place.allows(request)?) {
            (&Method::GET, "") => Ok(("text/html", self.page.clone())),
            (&Method::GET, "files") => Ok((JSON, self.changed(request.uri().query()))),
            (&Method::POST, "answer") => Ok((JSON, playground_answer(&body(request)?))),
            (&Method::POST, "save") => self.save(&body(request)?),
            (_, "" | "files" | "answer" | "save") => Err(StatusCode::METHOD_NOT_ALLOWED),
            _ => Err(StatusCode::NOT_FOUND),
        }
    }
}

impl ServedSite {
    /// The files as JSON: at once, or once they differ from the version that `since=VERSION` names; after
    /// a while without them.
    fn changed(&self, query: Option<&str>) -> String {
        let known = query.and_then(|query| query.strip_prefix("since=")?.parse().ok());
        let _waiting = Waiting::new(&self.waiting);
        let most = match self.waiting.load(Ordering::Relaxed) > MAX_WAITING {
            true => Duration::ZERO,
            false => MAX_WAIT,
        };
        let asked = Instant::now();
        loop {
            {
                let mut files = self.files.lock().unwrap_or_else(PoisonError::into_inner);
                let version = files.look();
                let is_known = known == Some(version);
                if !is_known || asked.elapsed() >= most {
                    let files = if is_known { "[]".to_string() } else { files.json() };
                    return format!("{{\"version\":{version},\"files\":{files}}}");
                }
            }
            std::thread::sleep(INTERVAL);
        }
    }

    /// Writes a scene back; the answer is empty, or says why not.
    fn save(&self, request: &str) -> Result<(&'static str, String), StatusCode> {
        let Ok(Save { path, text }) = serde_json::from_str(request) else {
            return Err(StatusCode::BAD_REQUEST);
        };
        let files = self.files.lock().unwrap_or_else(PoisonError::into_inner);
        let answer = files.save(&path, &text).err();
        let told = answer.map(|error| format!("{} {}", error.path, error.message));
        Ok(("text/plain", told.unwrap_or_default()))
    }
}

/// A request that waits for a change, counted as long as it does.
struct Waiting<'a>(&'a AtomicUsize);

impl<'a> Waiting<'a> {
    fn new(count: &'a AtomicUsize) -> Waiting<'a> {
        count.fetch_add(1, Ordering::Relaxed);
        Waiting(count)
    }
}

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

/// A scene to be written.
#[derive(Deserialize)]
struct Save {
    path: String,
    text: String,
}

/// The text of a request, which must be JSON: a form of another page cannot send that.
fn body(request: &mut Request<Body>) -> Result<String, StatusCode> {
    let kind = request.headers().get("content-type");
    if kind.is_none_or(|kind| kind.as_bytes() != b"application/json") {
        return Err(StatusCode::UNSUPPORTED_MEDIA_TYPE);
    }
    let mut text = String::new();
    let mut body = request.body_mut().take(MAX_BYTES as u64 + 1);
    body.read_to_string(&mut text).map_err(|_| StatusCode::BAD_REQUEST)?;
    if text.len() > MAX_BYTES { Err(StatusCode::PAYLOAD_TOO_LARGE) } else { Ok(text) }
}

/// The answer of the engine; a panic is one, too.
fn playground_answer(request: &str) -> String {
    std::panic::catch_unwind(|| playground::answer(request)).unwrap_or_else(|_| {
        "{\"error\":\"landfall panicked, which is a bug in landfall; please report the shader\"}"
            .to_string()
    })
}
