//! Requests of browsers, read with bounds on their size and their time.

use std::io::{self, Read};
use std::time::{Duration, Instant};

/// Largest head of a request, bytes.
const LARGEST_HEAD: usize = 16 * 1024;
/// Most headers of a request.
const MOST_HEADERS: usize = 64;
/// The longest that a head may take to arrive: browsers open connections before they ask.
pub(crate) const PATIENCE: Duration = Duration::from_secs(20);

/// What the head of a request says, as far as it matters here.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Request {
    pub(crate) method: String,
    /// The path, without what follows a question mark.
    pub(crate) path: String,
    /// What follows the question mark.
    pub(crate) query: String,
    pub(crate) host: Option<String>,
    pub(crate) origin: Option<String>,
    pub(crate) cookie: Option<String>,
    /// The key of a handshake, if the request asks for a WebSocket.
    pub(crate) socket_key: Option<String>,
}

/// Why a request is not answered as it asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// It is no request of HTTP/1.1.
    Malformed,
    /// Its head is too long.
    TooLarge,
    /// It did not arrive in time.
    TooSlow,
    /// It comes from a page or for a host that is not this one, or without the token.
    Forbidden,
    /// It asks for a method that there is not.
    Method,
    /// It asks for what there is not.
    NotFound,
}

impl Request {
    /// Reads the head of a request. The stream must give up reading after a while by itself.
    pub(crate) fn read(from: &mut impl Read) -> Result<Self, Refusal> {
        let begin = Instant::now();
        let (mut head, mut part) = (Vec::new(), [0; 2048]);
        loop {
            let count = match from.read(&mut part) {
                Ok(0) => return Err(Refusal::Malformed),
                Ok(count) => count,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(_) => return Err(Refusal::TooSlow),
            };
            head.extend_from_slice(&part[..count]);
            if let Some(request) = Self::parse(&head)? {
                return Ok(request);
            }
            if head.len() > LARGEST_HEAD {
                return Err(Refusal::TooLarge);
            }
            if begin.elapsed() > PATIENCE {
                return Err(Refusal::TooSlow);
            }
        }
    }

    /// A request of a whole head; none as long as it is not whole.
    fn parse(head: &[u8]) -> Result<Option<Self>, Refusal> {
        let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
        let mut parsed = httparse::Request::new(&mut headers);
        let status = parsed.parse(head).map_err(|error| match error {
            httparse::Error::TooManyHeaders => Refusal::TooLarge,
            _ => Refusal::Malformed,
        })?;
        if status.is_partial() {
            return Ok(None);
        }
        let target = parsed.path.unwrap_or_default();
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        let of = |name: &str| {
            let mut values = parsed.headers.iter().filter(|h| h.name.eq_ignore_ascii_case(name));
            let (first, second) = (values.next(), values.next());
            // What is said twice is not understood, so that nobody can mean another of the two.
            let one = first.filter(|_| second.is_none())?;
            std::str::from_utf8(one.value).ok().map(str::to_owned)
        };
        let has = |name: &str, word: &str| {
            of(name).is_some_and(|v| v.split(',').any(|w| w.trim().eq_ignore_ascii_case(word)))
        };
        let is_socket = has("upgrade", "websocket")
            && has("connection", "upgrade")
            && of("sec-websocket-version").as_deref() == Some("13");
        Ok(Some(Self {
            method: parsed.method.unwrap_or_default().to_owned(),
            path: path.to_owned(),
            query: query.to_owned(),
            host: of("host"),
            origin: of("origin"),
            cookie: of("cookie"),
            socket_key: of("sec-websocket-key").filter(|_| is_socket),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Request, Refusal> {
        Request::read(&mut text.as_bytes())
    }

    #[test]
    fn a_head_is_read() {
        let request = read("GET /a?b=c HTTP/1.1\r\nHost: x\r\nORIGIN: http://x\r\n\r\nrest");
        let request = request.expect("a request");
        assert_eq!((request.method.as_str(), request.path.as_str()), ("GET", "/a"));
        assert_eq!((request.query.as_str(), request.host.as_deref()), ("b=c", Some("x")));
        assert_eq!((request.origin.as_deref(), request.socket_key), (Some("http://x"), None));
    }

    #[test]
    fn what_is_said_twice_is_not_said() {
        let request = read("GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n").expect("a request");
        assert_eq!(request.host, None);
    }

    #[test]
    fn what_is_no_head_is_refused() {
        assert_eq!(read("\x16\x03\x01\x02 garbage\r\n\r\n"), Err(Refusal::Malformed));
        assert_eq!(read("GET / HTTP/1.1\r\nHost: a"), Err(Refusal::Malformed));
        let long = format!("GET / HTTP/1.1\r\nA: {}", "a".repeat(LARGEST_HEAD));
        assert_eq!(read(&long), Err(Refusal::TooLarge));
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "A: a\r\n".repeat(MOST_HEADERS + 1));
        assert_eq!(read(&many), Err(Refusal::TooLarge));
    }
}
