//! Short parallel phases, one after another, by threads that stay awake in between.
//!
//! A loop of some ten microseconds costs what a second thread saves if that has to be woken for it.
//! Here one thread leads: it orders a phase, does parts of it as everybody does, and goes on when all
//! are done. Helpers that are late, or never come, are not waited for: whoever finds a part that is
//! neither done nor taken does it. They leave when long nothing is ordered, and are called again; so
//! none waits for ever, whatever else the threads are used for.

use rayon::Scope;
use std::cell::RefCell;
use std::hint::spin_loop;
use std::marker::PhantomData;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError, RwLock, TryLockError};
use std::thread::yield_now;

/// How often a thread looks again before it lets others run, and helpers before they leave.
const AWAKE: usize = 1000;
const PATIENCE: usize = 2000;
/// How often the leader looks whether all is done before it looks for what nobody does.
const RETURN: usize = 64;

/// The phase after the last.
const OVER: usize = usize::MAX;

/// The parts of some work, and who does them, each in a room `R` that stays in its caches.
pub(super) struct Crew<P, O, R, A> {
    parts: Vec<Part<P>>,
    act: A,
    room: PhantomData<fn() -> R>,
    order: RwLock<Option<O>>,
    /// The number of the phase at hand.
    phase: AtomicUsize,
    /// How many parts have been done in all phases.
    done: AtomicUsize,
    /// Helpers that have been called and have not left.
    helpers: AtomicUsize,
}

/// A part, and the phase in which it was done last, which only who holds the part changes.
struct Part<P> {
    phase: AtomicUsize,
    own: Mutex<P>,
}

/// The leader's hold of a crew.
pub(super) struct Lead<'c, 'scope, P, O, R, A> {
    crew: &'scope Crew<P, O, R, A>,
    scope: &'c Scope<'scope>,
    room: RefCell<R>,
}

impl<P: Send, O: Send + Sync, R: Default, A: Fn(&O, &mut P, &mut R) + Sync> Crew<P, O, R, A> {
    /// A crew that does `parts` of every order, in any order and side by side, by `act`.
    pub(super) fn new(parts: impl Iterator<Item = P>, act: A) -> Self {
        let number = || AtomicUsize::new(0);
        Self {
            parts: parts.map(|own| Part { phase: number(), own: Mutex::new(own) }).collect(),
            act,
            room: PhantomData,
            order: RwLock::new(None),
            phase: number(),
            done: number(),
            helpers: number(),
        }
    }

    /// Lets the calling thread lead.
    pub(super) fn led<'a, T: Send>(
        &'a self,
        lead: impl FnOnce(&Lead<'_, 'a, P, O, R, A>) -> T + Send,
    ) -> T {
        rayon::scope(|scope| {
            let result = lead(&Lead { crew: self, scope, room: RefCell::default() });
            self.phase.store(OVER, Ordering::Release);
            result
        })
    }

    /// Does what is left of a phase, from some part on.
    fn work(&self, phase: usize, first: usize, room: &mut R) {
        let order = self.order.read().unwrap_or_else(PoisonError::into_inner);
        let Some(order) = &*order else { return };
        let (behind, ahead) = self.parts.split_at(first);
        for part in ahead.iter().chain(behind) {
            let is_done = || part.phase.load(Ordering::Relaxed) >= phase;
            if is_done() {
                continue;
            }
            // Who finds a lock poisoned does the part again, and learns why.
            let mut own = match part.own.try_lock() {
                Ok(own) => own,
                Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
                Err(TryLockError::WouldBlock) => continue,
            };
            if !is_done() {
                (self.act)(order, &mut own, room);
                part.phase.store(phase, Ordering::Relaxed);
                self.done.fetch_add(1, Ordering::Release);
            }
        }
    }

    /// Does parts of all phases that are ordered.
    fn help(&self) {
        let first = self.parts.len() / 2;
        let (mut last, mut looks, mut room) = (0, 0, R::default());
        while looks < PATIENCE {
            let phase = self.phase.load(Ordering::Acquire);
            if phase == OVER {
                break;
            }
            if phase == last {
                wait(&mut looks);
            } else {
                self.work(phase, first, &mut room);
                (last, looks) = (phase, 0);
            }
        }
        self.helpers.fetch_sub(1, Ordering::Relaxed);
    }
}

impl<'scope, P, O, R, A> Lead<'_, 'scope, P, O, R, A>
where
    P: Send,
    O: Send + Sync,
    R: Default,
    A: Fn(&O, &mut P, &mut R) + Sync,
{
    /// Has all parts done.
    pub(super) fn order(&self, order: O) {
        let crew = self.crew;
        let phase = crew.phase.load(Ordering::Relaxed) + 1;
        *crew.order.write().unwrap_or_else(PoisonError::into_inner) = Some(order);
        crew.phase.store(phase, Ordering::Release);
        let most = rayon::current_num_threads().min(crew.parts.len());
        while crew.helpers.load(Ordering::Relaxed) + 1 < most {
            crew.helpers.fetch_add(1, Ordering::Relaxed);
            self.scope.spawn(|_| crew.help());
        }
        let mut looks = 0_usize;
        loop {
            // A helper that is late may have held a part in passing.
            if looks.is_multiple_of(RETURN) {
                crew.work(phase, 0, &mut self.room.borrow_mut());
            }
            if crew.done.load(Ordering::Acquire) == phase * crew.parts.len() {
                return;
            }
            wait(&mut looks);
        }
    }

    /// Looks at all parts, in their order.
    pub(super) fn each(&self, mut look: impl FnMut(&mut P)) {
        for part in &self.crew.parts {
            look(&mut part.own.lock().unwrap_or_else(PoisonError::into_inner));
        }
    }
}

/// Looks again a little later.
fn wait(looks: &mut usize) {
    *looks += 1;
    if *looks > AWAKE { yield_now() } else { spin_loop() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every part once in each phase, after all of the phase before.
    #[test]
    fn phases_follow_one_another() {
        for count in [0, 1, 2, 7, 100] {
            let sum = AtomicUsize::new(0);
            let act = |order: &usize, part: &mut usize, (): &mut ()| {
                assert_eq!(*part, *order);
                assert_eq!(sum.load(Ordering::Relaxed) / count, *order);
                *part += 1;
                sum.fetch_add(1, Ordering::Relaxed);
            };
            let crew = Crew::new(std::iter::repeat_n(0, count), act);
            let seen = crew.led(|lead| {
                (0..1000).for_each(|phase| lead.order(phase));
                let mut seen = Vec::new();
                lead.each(|part| seen.push(*part));
                seen
            });
            assert_eq!(seen, vec![1000; count]);
        }
    }

    /// Side by side, in a pool of one thread, and where nothing is ordered for long.
    #[test]
    fn crews_share_threads() {
        let count = |phases: usize| {
            let crew = Crew::new(0..5, |_: &(), part: &mut usize, (): &mut ()| *part += 1);
            crew.led(|lead| {
                for phase in 0..phases {
                    if phase % 10 == 0 {
                        std::thread::sleep(std::time::Duration::from_millis(1));
                    }
                    lead.order(());
                }
                let mut sum = 0;
                lead.each(|part| sum += *part);
                sum
            })
        };
        let side_by_side = || {
            rayon::scope(|scope| {
                for phases in 0..20 {
                    scope.spawn(move |_| assert_eq!(count(phases), 10 + 5 * phases));
                }
            });
        };
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("threads").install(side_by_side);
        }
    }

    /// A part that fails is told, whoever did it.
    #[test]
    fn panics_come_back() {
        let act = |_: &(), part: &mut usize, (): &mut ()| assert!(*part < 40, "too many");
        let crew = Crew::new(0..50, act);
        let led = std::panic::AssertUnwindSafe(|| crew.led(|lead| lead.order(())));
        assert!(std::panic::catch_unwind(led).is_err());
    }
}
