//! Answers to browsers.

use crate::request::Refusal;
use std::io::{self, Write};

/// What every answer forbids: other sites' scripts, styles and frames, and guesses at types.
const GUARDS: &str = "Content-Security-Policy: default-src 'none'; script-src 'self'; \
    style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; \
    form-action 'none'; frame-ancestors 'none'\r\n\
    X-Frame-Options: DENY\r\n\
    X-Content-Type-Options: nosniff\r\n\
    Referrer-Policy: no-referrer\r\n\
    Cross-Origin-Resource-Policy: same-origin\r\n\
    Cross-Origin-Opener-Policy: same-origin\r\n\
    Cache-Control: no-store\r\n";

/// Writes an answer with a body, of which `HEAD` sees the length only.
pub(crate) fn give(
    to: &mut impl Write,
    (kind, body): (&str, &[u8]),
    cookie: Option<&str>,
    with_body: bool,
) -> io::Result<()> {
    let cookie = cookie.map(|cookie| format!("Set-Cookie: {cookie}\r\n")).unwrap_or_default();
    let head = format!(
        "HTTP/1.1 200 OK\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n{GUARDS}{cookie}\
         Connection: close\r\n\r\n",
        body.len()
    );
    to.write_all(head.as_bytes())?;
    if with_body {
        to.write_all(body)?;
    }
    to.flush()
}

/// Writes why a request is not answered as it asks.
pub(crate) fn refuse(to: &mut impl Write, refusal: Refusal) -> io::Result<()> {
    let (status, text) = match refusal {
        Refusal::Malformed => ("400 Bad Request", "this is no request of HTTP/1.1"),
        Refusal::TooLarge => ("431 Request Header Fields Too Large", "the request is too long"),
        Refusal::TooSlow => ("408 Request Timeout", "the request came too slowly"),
        Refusal::Forbidden => {
            ("403 Forbidden", "open the address that the program printed, with its token if any")
        }
        Refusal::Method => ("405 Method Not Allowed", "there is only GET here"),
        Refusal::NotFound => ("404 Not Found", "there is no such page"),
    };
    let allow = if refusal == Refusal::Method { "Allow: GET, HEAD\r\n" } else { "" };
    let answer = format!(
        "HTTP/1.1 {status}\r\nContent-Type: text/plain; charset=utf-8\r\n\
         Content-Length: {}\r\n{GUARDS}{allow}Connection: close\r\n\r\n{text}\n",
        text.len() + 1
    );
    to.write_all(answer.as_bytes())?;
    to.flush()
}

/// Writes that a socket is open, with the answer to the key of its handshake.
pub(crate) fn open_socket(to: &mut impl Write, key: &str) -> io::Result<()> {
    let accept = tungstenite::handshake::derive_accept_key(key.as_bytes());
    let answer = format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Accept: {accept}\r\n\r\n"
    );
    to.write_all(answer.as_bytes())?;
    to.flush()
}
