//! The server and the page as a browser meets them.

mod accessible;
mod axe;
mod browser;
mod common;
mod frames;
mod hands;
mod left;
mod measured;
mod objects;
mod page;
mod pictures;
mod recorded;
mod server;
mod shipped;
mod shows;
