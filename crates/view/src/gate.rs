//! Who may come in: by the host that is asked for, the page that asks, and a token.

use crate::request::{Refusal, Request};
use std::net::SocketAddr;

/// Name of the cookie that holds the token.
const COOKIE: &str = "rapunzel-token";

/// What a request must bring.
#[derive(Debug)]
pub(crate) struct Gate {
    address: SocketAddr,
    token: Option<String>,
}

/// What a request that may come in is told.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Admission {
    /// It comes in.
    Plain,
    /// It brought the token in its address, which a cookie keeps from now on.
    WithCookie(String),
}

impl Gate {
    pub(crate) fn new(address: SocketAddr, token: Option<String>) -> Self {
        Self { address, token }
    }

    /// The address of the page, with the token.
    pub(crate) fn url(&self) -> String {
        match &self.token {
            Some(token) => format!("http://{}/?token={token}", self.address),
            None => format!("http://{}/", self.address),
        }
    }

    /// Looks whether a request may come in.
    ///
    /// A page of another site can send requests here, and by a name that its owner points to this
    /// machine also read the answers: so host and origin must be those of this server. By a token a
    /// machine may be asked for by any name, as whoever has it has been told it by the user.
    pub(crate) fn admit(&self, request: &Request) -> Result<Admission, Refusal> {
        let host = request.host.as_deref().ok_or(Refusal::Forbidden)?;
        if self.token.is_none() && !self.is_own(host) {
            return Err(Refusal::Forbidden);
        }
        let own = format!("http://{host}");
        let foreign = request.origin.as_ref().is_some_and(|origin| *origin != own);
        if foreign || (request.socket_key.is_some() && request.origin.is_none()) {
            return Err(Refusal::Forbidden);
        }
        let Some(token) = &self.token else { return Ok(Admission::Plain) };
        let cookies = request.cookie.as_deref().unwrap_or_default().split(';');
        if cookies.filter_map(|c| c.trim().strip_prefix(COOKIE)).any(|c| is(c, token)) {
            return Ok(Admission::Plain);
        }
        let brought = request.query.split('&').filter_map(|pair| pair.strip_prefix("token"));
        if brought.into_iter().any(|t| is(t, token)) {
            let cookie = format!("{COOKIE}={token}; HttpOnly; SameSite=Strict; Path=/");
            return Ok(Admission::WithCookie(cookie));
        }
        Err(Refusal::Forbidden)
    }

    fn is_own(&self, host: &str) -> bool {
        let port = self.address.port();
        let names = [self.address.ip().to_string(), "localhost".into(), "127.0.0.1".into()];
        names.iter().any(|name| host.eq_ignore_ascii_case(&format!("{name}:{port}")))
            || host == self.address.to_string()
    }
}

/// Whether what follows a name is `=` and the token, compared in a time that does not tell where
/// they differ.
fn is(text: &str, token: &str) -> bool {
    let Some(text) = text.strip_prefix('=') else { return false };
    let differ = text.bytes().zip(token.bytes()).fold(0, |differ, (a, b)| differ | (a ^ b));
    text.len() == token.len() && differ == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(host: &str, origin: Option<&str>) -> Request {
        Request {
            host: Some(host.to_owned()),
            origin: origin.map(str::to_owned),
            ..Request::default()
        }
    }

    #[test]
    fn only_this_host_and_its_own_pages_come_in() {
        let gate = Gate::new("127.0.0.1:4000".parse().expect("an address"), None);
        assert_eq!(gate.admit(&request("127.0.0.1:4000", None)), Ok(Admission::Plain));
        let own = request("localhost:4000", Some("http://localhost:4000"));
        assert_eq!(gate.admit(&own), Ok(Admission::Plain));
        for (host, origin) in [
            ("evil.example:4000", None),
            ("127.0.0.1:4001", None),
            ("127.0.0.1", None),
            ("127.0.0.1:4000", Some("http://evil.example")),
            ("127.0.0.1:4000", Some("https://127.0.0.1:4000")),
            ("127.0.0.1:4000", Some("null")),
        ] {
            let refused = gate.admit(&request(host, origin));
            assert_eq!(refused, Err(Refusal::Forbidden), "{host} {origin:?}");
        }
        let no_host = Request::default();
        assert_eq!(gate.admit(&no_host), Err(Refusal::Forbidden));
    }

    #[test]
    fn a_socket_says_where_it_comes_from() {
        let gate = Gate::new("127.0.0.1:4000".parse().expect("an address"), None);
        let mut socket = request("127.0.0.1:4000", None);
        socket.socket_key = Some("key".into());
        assert_eq!(gate.admit(&socket), Err(Refusal::Forbidden));
        socket.origin = Some("http://127.0.0.1:4000".into());
        assert_eq!(gate.admit(&socket), Ok(Admission::Plain));
    }

    #[test]
    fn a_token_is_brought_once_and_then_kept_in_a_cookie() {
        let gate = Gate::new("0.0.0.0:4000".parse().expect("an address"), Some("abc".into()));
        assert_eq!(gate.url(), "http://0.0.0.0:4000/?token=abc");
        let mut asks = request("pc.example:4000", None);
        assert_eq!(gate.admit(&asks), Err(Refusal::Forbidden));
        for wrong in ["token=ab", "token=abcd", "token=abd", "token", "tokens=abc"] {
            asks.query = wrong.into();
            assert_eq!(gate.admit(&asks), Err(Refusal::Forbidden), "{wrong}");
        }
        asks.query = "token=abc".into();
        let Ok(Admission::WithCookie(cookie)) = gate.admit(&asks) else {
            panic!("it has the token")
        };
        asks.query.clear();
        asks.cookie = cookie.split(';').next().map(str::to_owned);
        assert_eq!(gate.admit(&asks), Ok(Admission::Plain));
    }
}
