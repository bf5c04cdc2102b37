//! What tells a layer of USD.

/// Name of the format.
pub(crate) const NAME: &str = "USD";

/// First bytes of a text.
pub(crate) const TEXT_MARK: &[u8] = b"#usda";

/// First bytes of a binary file.
pub(crate) const BINARY_MARK: &[u8] = b"PXR-USDC";
