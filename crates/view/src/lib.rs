#![doc = include_str!("../README.md")]

mod answer;
mod assets;
mod clock;
mod driver;
mod error;
mod frame;
mod gallery;
mod gate;
mod hands;
mod hub;
mod knobs;
mod layout;
mod live;
mod mailbox;
mod modes;
mod options;
mod order;
mod recorded;
mod request;
mod server;
mod socket;
mod stage;
mod state;
mod stream;
mod watch;

pub use error::ViewError;
pub use gallery::GalleryScene;
pub use options::Options;
pub use server::Server;
