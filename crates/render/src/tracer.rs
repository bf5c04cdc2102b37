use crate::path::trace;
use crate::{Camera, Film, FilmSample, LightSearch, PathRandom, RenderScene};
use rayon::prelude::*;

/// A path tracer: a scene, seen by a camera.
pub struct PathTracer<'a> {
    /// What is seen.
    pub scene: &'a RenderScene,
    /// Who sees it.
    pub camera: &'a Camera,
    /// The seed of all random numbers.
    pub seed: u64,
    /// The order of scattering: paths end after `order + 1` events. None ends them by chance, which
    /// leaves out nothing.
    pub order: Option<u32>,
    /// How light is looked for.
    pub search: LightSearch,
}

impl PathTracer<'_> {
    /// What the path of a number finds in a pixel (column and row) of a picture of a size.
    #[must_use]
    pub fn sample(&self, size: [u32; 2], pixel: [u32; 2], number: u32) -> FilmSample {
        let index = u64::from(pixel[1]) * u64::from(size[0]) + u64::from(pixel[0]);
        let mut random = PathRandom::new(self.seed, index, u64::from(number));
        let (within, lens) = (random.pair(), random.pair());
        let time = random.number();
        let ray = self.camera.ray(size, pixel, within, lens, time);
        let events = self.order.map(|order| order.saturating_add(1));
        trace(self.scene, ray, events, self.search, &mut random)
    }

    /// Adds samples to every pixel until it has had `samples`, row by row on all threads; rows that
    /// have not begun when `stop` says so are left as they are. A picture that was stopped goes on
    /// to the same bits, and so does one on another number of threads.
    pub fn expose(&self, film: &mut Film, samples: u32, stop: &(dyn Fn() -> bool + Sync)) {
        let size = film.size();
        film.rows_mut().enumerate().for_each(|(row, pixels)| {
            let Ok(row) = u32::try_from(row) else { return };
            if stop() {
                return;
            }
            for (column, pixel) in (0..).zip(pixels) {
                for number in pixel.samples() + pixel.rejected()..samples {
                    pixel.add(&self.sample(size, [column, row], number));
                }
            }
        });
    }
}
