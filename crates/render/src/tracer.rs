use crate::path::trace;
use crate::{
    Camera, Film, FilmPixel, FilmSample, FirstSurface, LightSearch, PathRandom, RenderScene,
};
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

    /// Part of the light of fibres that the order leaves out, in `[0, 1]` but for noise: of what
    /// reaches the camera from them in a picture of a size with so many samples of a pixel, traced
    /// with the order and without it by paths that are the same as far as both go.
    #[must_use]
    pub fn left_out(&self, size: [u32; 2], samples: u32) -> f64 {
        let whole = PathTracer { order: None, ..*self };
        let of_row = |row: u32| {
            let mut sums = [0.0; 2];
            for (column, number) in (0..size[0]).flat_map(|c| (0..samples).map(move |n| (c, n))) {
                for (sum, tracer) in sums.iter_mut().zip([self, &whole]) {
                    let sample = tracer.sample(size, [column, row], number);
                    let of_fiber = |surface: &FirstSurface| surface.fiber != FilmPixel::NO_FIBER;
                    if sample.surface.as_ref().is_some_and(of_fiber) {
                        *sum += sample.radiance.mean();
                    }
                }
            }
            sums
        };
        // Rows are added in their order, whoever traced them.
        let rows: Vec<_> = (0..size[1]).into_par_iter().map(of_row).collect();
        let [kept, all] = [0, 1].map(|k| rows.iter().map(|row| row[k]).sum::<f64>());
        if all > 0.0 { 1.0 - kept / all } else { 0.0 }
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
