#![doc = include_str!("../README.md")]

mod answer;
mod assets;
mod clock;
mod darkroom;
mod drag;
mod driver;
mod error;
mod extras;
mod field_lines;
mod frame;
mod gallery;
mod gate;
mod hands;
mod hub;
mod keep;
mod knobs;
mod layout;
mod live;
mod mailbox;
mod modes;
mod obey;
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
mod wish;

pub use error::ViewError;
pub use gallery::GalleryScene;
pub use options::Options;
pub use server::Server;
