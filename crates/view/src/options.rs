use crate::GalleryScene;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;

/// What is shown, and to whom.
#[derive(Debug, Clone)]
pub struct Options {
    /// Where to listen.
    pub address: SocketAddr,
    /// What pages must bring; needed for an address that other machines can reach.
    pub token: Option<String>,
    /// A scene, a run, a style or a file of strands; the gallery without one.
    pub what: Option<PathBuf>,
    /// A run or what else can be shown as a still, shown together with `what`.
    pub beside: Option<PathBuf>,
    /// The scenes of the gallery.
    pub gallery: Vec<GalleryScene>,
    /// Where scenes of the gallery that were changed are saved.
    pub folder: PathBuf,
    /// Whether what is shown runs from the start, without a page that asks for it.
    pub runs: bool,
}

impl Options {
    /// The gallery, on a free port of this machine, whose changed scenes are saved in `folder`.
    #[must_use]
    pub fn local(folder: PathBuf) -> Self {
        let address = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 0);
        Self {
            address,
            token: None,
            what: None,
            beside: None,
            gallery: Vec::new(),
            folder,
            runs: false,
        }
    }
}
