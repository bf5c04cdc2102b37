//! One page at its socket: a thread that reads and one that writes.

use crate::hub::Hub;
use crate::mailbox::Letter;
use crate::order::Order;
use crate::stream::SharedStream;
use std::net::TcpStream;
use std::sync::Arc;
use std::thread;
use std::time::Duration;
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Message, Utf8Bytes, WebSocket};

/// Largest message of a page, bytes.
const LARGEST_MESSAGE: usize = 16 * 1024;
/// Without anything to say for so long, a page is asked whether it is there.
const QUIET: Duration = Duration::from_secs(5);
/// A page that says nothing for so long, not even that it is there, is dropped.
const SILENCE: Duration = Duration::from_secs(20);
/// A page that takes nothing for so long is dropped.
const STUCK: Duration = Duration::from_secs(10);
/// Pages at once.
const MOST_PAGES: usize = 200;

/// Serves a page until it goes, or does what a page does not do.
pub(crate) fn serve(stream: TcpStream, hub: &Hub) {
    let Ok(shared) = SharedStream::new(stream, SILENCE, STUCK) else { return };
    let config = WebSocketConfig::default()
        .max_message_size(Some(LARGEST_MESSAGE))
        .max_frame_size(Some(LARGEST_MESSAGE))
        .read_buffer_size(LARGEST_MESSAGE)
        // Every message goes out as one piece, so that those of both threads do not mix.
        .write_buffer_size(0);
    let Some((page, mailbox)) = hub.join(MOST_PAGES) else { return };
    let mut reads = WebSocket::from_raw_socket(shared.clone(), Role::Server, Some(config));
    let writer = {
        let (mailbox, shared) = (Arc::clone(&mailbox), shared.clone());
        let mut writes = WebSocket::from_raw_socket(shared.clone(), Role::Server, Some(config));
        let write = move || {
            loop {
                let message = match mailbox.next(QUIET) {
                    Letter::Text(text) => Message::Text(Utf8Bytes::from(text.as_ref())),
                    Letter::Bytes(bytes) => Message::Binary(bytes),
                    Letter::Nothing => Message::Ping(Vec::new().into()),
                    Letter::End => break,
                };
                if writes.send(message).is_err() {
                    break;
                }
            }
            // A last word, if the page still listens; then the reader wakes up too.
            let _ = writes.close(None);
            let _ = writes.flush();
            shared.shut_down();
        };
        thread::Builder::new().name("page".into()).spawn(write)
    };
    if writer.is_ok() {
        loop {
            match reads.read() {
                Ok(Message::Text(text)) => match Order::read(&text) {
                    Some(order) => hub.ask(page, order),
                    None => break,
                },
                Ok(Message::Ping(_) | Message::Pong(_)) => {}
                // What is no order, is broken or silent, or has gone.
                Ok(_) | Err(_) => break,
            }
        }
    }
    hub.leave(page);
    if let Ok(writer) = writer {
        let _ = writer.join();
    }
}
