use std::io;
use std::net::SocketAddr;
use thiserror::Error;

/// Why there is no page.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ViewError {
    /// The address cannot be listened at.
    #[error("cannot listen at {address}: {source}; take another port, or 0 for any that is free")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// What the system says.
        source: io::Error,
    },
    /// Others than this machine could come without a token.
    #[error("{address} can be reached from other machines: give a token that pages must bring")]
    Open {
        /// The address.
        address: SocketAddr,
    },
    /// A thread cannot be started.
    #[error("cannot start a thread: {0}; close other programs")]
    Thread(io::Error),
}
