//! The server and the page as a browser meets them.

mod browser;
mod common;
mod hands;
mod page;
mod recorded;
mod server;
