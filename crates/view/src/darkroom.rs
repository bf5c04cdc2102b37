//! Pictures by paths of light, which come in pass by pass while all else goes on.

use crate::hub::{Hub, PageId};
use crate::wish::PictureWish;
use nalgebra::{Point3, Vector3};
use rapunzel_export::Frame;
use rapunzel_export::surface::Placed;
use rapunzel_render::{
    Camera, Film, LightSearch, PathTracer, Projection, RenderScene, Tone, write_png,
};
use rapunzel_studio::{StageOptions, StudioError, staged};
use serde_json::json;
use std::collections::BTreeMap;
use std::num::NonZero;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

/// The first bytes of a picture.
const MARK: &[u8; 4] = b"RPP1";
/// Longest side of a picture, pixels, and samples of a pixel at most.
const LONGEST: u32 = 2048;
const MOST_SAMPLES: u32 = 1024;
/// Pictures that wait at most, and that are exposed at once.
const WAITING: usize = 8;
/// How often is looked whether all ends while nothing is to be done.
const LOOK: Duration = Duration::from_millis(50);

/// A picture that is to be drawn.
pub(crate) struct Sitting {
    pub(crate) page: PageId,
    pub(crate) wish: PictureWish,
    pub(crate) frame: Frame,
    pub(crate) objects: Vec<Placed>,
    pub(crate) options: StageOptions,
}

/// What is asked of a darkroom.
enum Job {
    Draw(Box<Sitting>),
    End(PageId),
}

/// A thread that draws pictures.
#[derive(Debug)]
pub(crate) struct Darkroom {
    jobs: SyncSender<Job>,
    /// Jobs that it has not looked at yet.
    news: Arc<AtomicUsize>,
}

/// A picture that is being exposed.
struct Exposure {
    wish: PictureWish,
    scene: RenderScene,
    camera: Camera,
    film: Film,
    done: u32,
}

impl Darkroom {
    /// Starts the thread; none where there can be no more threads.
    pub(crate) fn start(hub: Arc<Hub>) -> Option<Self> {
        let (jobs, heard) = sync_channel(WAITING);
        let news = Arc::new(AtomicUsize::new(0));
        let told = Arc::clone(&news);
        // One core is left to what is simulated.
        let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
        let pool = rayon::ThreadPoolBuilder::new().num_threads((cores - 1).max(1)).build().ok()?;
        let work = move || work(&hub, &pool, &heard, &told);
        std::thread::Builder::new().name("darkroom".into()).spawn(work).ok()?;
        Some(Self { jobs, news })
    }

    /// Draws a picture in place of the one that its page has; where too many wait, it is not drawn.
    pub(crate) fn draw(&self, sitting: Sitting) {
        self.tell(Job::Draw(Box::new(sitting)));
    }

    /// Draws no more for a page.
    pub(crate) fn end(&self, page: PageId) {
        self.tell(Job::End(page));
    }

    fn tell(&self, job: Job) {
        self.news.fetch_add(1, Ordering::Relaxed);
        if self.jobs.try_send(job).is_err() {
            self.news.fetch_sub(1, Ordering::Relaxed);
        }
    }
}

/// Draws what is asked for, a pass of each picture in turn, until all ends.
fn work(hub: &Hub, pool: &rayon::ThreadPool, heard: &Receiver<Job>, news: &AtomicUsize) {
    let mut exposures: BTreeMap<PageId, Exposure> = BTreeMap::new();
    while !hub.has_ended() {
        let wait = if exposures.is_empty() { LOOK } else { Duration::ZERO };
        match heard.recv_timeout(wait) {
            Ok(job) => {
                news.fetch_sub(1, Ordering::Relaxed);
                match job {
                    Job::End(page) => {
                        exposures.remove(&page);
                    }
                    Job::Draw(sitting) => {
                        let page = sitting.page;
                        match pool.install(|| Exposure::new(*sitting)) {
                            Ok(exposure) => {
                                exposures.insert(page, exposure);
                            }
                            Err(error) => complain(hub, page, &error),
                        }
                    }
                }
                continue;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        let stop = || hub.has_ended() || news.load(Ordering::Relaxed) > 0;
        exposures.retain(|page, exposure| {
            if stop() || !pool.install(|| exposure.pass(&stop)) {
                return true;
            }
            let sent = exposure.bytes().is_ok_and(|bytes| hub.send_picture(*page, bytes));
            sent && exposure.done < exposure.wish.samples
        });
    }
}

fn complain(hub: &Hub, page: PageId, error: &StudioError) {
    let message = format!("there is no picture: {error}");
    hub.note_to(page, &json!({ "is": "complaint", "message": message }).to_string());
}

impl Exposure {
    fn new(sitting: Sitting) -> Result<Self, StudioError> {
        let Sitting { mut wish, frame, objects, options, .. } = sitting;
        wish.samples = wish.samples.clamp(1, MOST_SAMPLES);
        let scene = staged(&frame, &objects, &options)?;
        let (eye, target) = (Point3::from(wish.eye), Point3::from(wish.target));
        let sight: Vector3<f64> = target - eye;
        let level = sight.xy().norm() > 1e-6 * sight.norm();
        let up = if level { Vector3::z() } else { Vector3::y() };
        let projection = Projection::Perspective { field_of_view: wish.field };
        let camera = Camera::new(eye, &target, &up, projection)?;
        let film = Film::new(wish.size.map(|side| side.clamp(1, LONGEST)))?;
        Ok(Self { wish, scene, camera, film, done: 0 })
    }

    /// Doubles the samples; false if it was stopped, which loses nothing.
    fn pass(&mut self, stop: &(dyn Fn() -> bool + Sync)) -> bool {
        let Self { wish, scene, camera, film, done } = self;
        let tracer = PathTracer { scene, camera, seed: 1, order: None, search: LightSearch::Both };
        let samples = (2 * *done).clamp(1, wish.samples);
        tracer.expose(film, samples, stop);
        let whole = !stop();
        if whole {
            *done = samples;
        }
        whole
    }

    /// The picture as it is, little-endian: mark, its number, samples so far and in the end (3
    /// u32), and a PNG.
    fn bytes(&self) -> Result<Vec<u8>, StudioError> {
        let mut bytes = MARK.to_vec();
        for number in [self.wish.number, self.done, self.wish.samples] {
            bytes.extend(number.to_le_bytes());
        }
        write_png(&mut bytes, &self.film, Tone::Filmic, 0.0, false)?;
        Ok(bytes)
    }
}
