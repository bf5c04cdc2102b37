//! The scenes and cases that ship, inside the program.

macro_rules! templates {
    ($($name:literal),+ $(,)?) => {
        /// Names of the scenes.
        pub(crate) const NAMES: &[&str] = &[$($name),+];
        /// Texts of the scenes, in the order of the names.
        const TEXTS: &[&str] = &[$(include_str!(concat!("../../../scenes/", $name, ".ron"))),+];
    };
}

templates![
    "lock-under-gravity",
    "sine-under-gravity",
    "helix-with-end-load",
    "straight-rod-with-torque",
    "prestressed-spring",
    "buckling",
    "lock-pulled",
    "lock-falling",
    "lock-on-moving-root",
    "water-wave",
    "fishing-rod",
    "twisting-machine",
    "joined/twisted-ring",
    "joined/net",
    "joined/braid",
    "joined/mobile",
    "joined/chain",
    "contact/lock-on-ball",
    "contact/bundle-on-slope",
    "contact/bundle-on-terrain",
    "contact/helical-bundle-on-ball",
    "contact/horizontal-bundle-on-ball",
    "contact/partly-elastic",
    "contact/partly-elastic-limp",
    "contact/friction-none",
    "contact/friction-isotropic",
    "contact/friction-anisotropic",
    "contact/comb",
    "contact/knot",
    "contact/figure-eight",
    "contact/head",
    "contact/turned-head",
    "contact/wrapped",
    "contact/coiling",
    "contact/plectoneme",
    "charge/tress",
    "charge/tress-without-gravity",
    "charge/van-de-graaff",
    "mass-spring/rope",
    "mass-spring/rope-in-wind",
    "mass-spring/chain",
    "mass-spring/cloth-on-a-line",
    "mass-spring/flag",
    "mass-spring/net-beyond-its-limit",
    "mass-spring/thin-beam",
    "mass-spring/beam-buckling",
    "mass-spring/cube",
    "mass-spring/cube-under-lid",
    "mass-spring/thick-beam",
    "mass-spring/ring",
    "mass-spring/ball",
    "static/hose-between-flanges",
    "static/tress-root",
    "static/follower-load",
    "static/upright-rod",
    "static/two-places",
    "static/fishing-rod",
    "static/column",
    "static/snapping-arch",
    "static/twisted-ring",
    "static/joined-rods",
    "style/bob",
    "style/long",
    "style/afro",
    "style/wavy",
    "style/curly",
    "style/standing",
    "style/tress",
    "style/shaken-head",
];

/// Names and texts of all that ships.
pub(crate) fn scenes() -> impl Iterator<Item = (&'static str, &'static str)> {
    NAMES.iter().copied().zip(TEXTS.iter().copied())
}

/// The text of a scene that ships.
pub(crate) fn text(name: &str) -> Option<&'static str> {
    NAMES.iter().position(|n| *n == name).map(|i| TEXTS[i])
}
