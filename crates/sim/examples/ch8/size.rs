//! How large scenes are.

use crate::film::{Film, play, scene};
use rapunzel_repro::Fallible;
use rapunzel_repro::plot::Picture;
use rapunzel_sim::scene::Arrangement;
use rapunzel_sim::{Scene, World};

/// How large scenes are.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Size {
    Reduced,
    /// As they ship.
    Full,
}

impl Size {
    /// A scene of the folder `scenes/contact`; reduced, every bundle has `count` fibers of
    /// `segments` segments, as dense as they were.
    pub(crate) fn scene(self, name: &str, count: usize, segments: usize) -> Fallible<Scene> {
        let mut scene = scene(&format!("contact/{name}"))?;
        if self == Self::Reduced {
            for bundle in &mut scene.fibers {
                if let Arrangement::Ellipse { semi_axes, count: all } = &mut bundle.arrangement {
                    let smaller = (count as f64 / *all as f64).sqrt();
                    semi_axes.iter_mut().for_each(|axis| *axis *= smaller);
                    *all = count;
                }
                bundle.segments = segments;
            }
        }
        Ok(scene)
    }
}

/// Runs a scene and takes pictures at `times`, s; `observe` sees its start and what every step
/// leaves.
pub(crate) fn filmed(
    scene: &Scene,
    times: &[f64],
    mut observe: impl FnMut(&World),
) -> Fallible<Film> {
    let mut film = Film::at(times);
    play(scene, |world| {
        film.observe(world);
        observe(world);
    })?;
    Ok(film)
}

/// The pictures of a film, each under `name`.
pub(crate) fn captioned(name: &str, film: Film) -> impl Iterator<Item = Picture> {
    let under = move |caption: String| format!("{name}, {caption}");
    film.pictures.into_iter().map(move |p| Picture { caption: under(p.caption), ..p })
}

/// Extents of the axis-parallel box around all fibers, m.
pub(crate) fn extents(world: &World) -> nalgebra::Vector3<f64> {
    let states = (0..world.assembly().fibers().len()).map(|fiber| world.state(fiber));
    let nodes: Vec<_> = states.flat_map(|state| state.positions).collect();
    let Some(&first) = nodes.first() else { return nalgebra::Vector3::zeros() };
    let [low, high] = nodes.iter().fold([first; 2], |[low, high], p| [low.inf(p), high.sup(p)]);
    high - low
}
