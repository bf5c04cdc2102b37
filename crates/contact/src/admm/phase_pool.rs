//! Short parallel phases, one after another, by threads that stay awake in between.
//!
//! A loop of some ten microseconds costs what a second thread saves if that has to be woken for it.
//! Here one thread leads: it starts a phase, does parts of it as everybody does, and goes on when
//! all are done. Helpers that are late, or never come, are not waited for: whoever finds a part
//! that is neither done nor taken does it. They leave when long no phase is started, and are called
//! again; so none waits for ever, whatever else the threads are used for.

use rayon::Scope;
use std::cell::RefCell;
use std::hint::spin_loop;
use std::marker::PhantomData;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError, RwLock, TryLockError};
use std::thread::yield_now;

/// Looks at the phase after which a waiting thread lets others run.
const SPINS_BEFORE_YIELD: usize = 1000;
/// Looks at the phase after which a helper leaves.
const SPINS_BEFORE_LEAVING: usize = 2000;
/// Looks of the leader whether all is done, after which it takes up what nobody does.
const SPINS_BEFORE_WORK: usize = 64;

/// Number of the phase after the last.
const FINISHED: usize = usize::MAX;

/// The parts `P` of some work and the function `A` that does a phase `O` of one of them, in a
/// workspace `R` of the thread.
pub(super) struct PhasePool<P, O, R, A> {
    parts: Vec<PoolPart<P>>,
    run_part: A,
    workspace: PhantomData<fn() -> R>,
    phase: RwLock<Option<O>>,
    /// Number of the phase at hand, from one.
    phase_number: AtomicUsize,
    /// Number of parts that have been done in all phases.
    done: AtomicUsize,
    /// Number of helpers that have been called and have not left.
    helpers: AtomicUsize,
}

/// A part, and the phase in which it was done last, which only who holds the part changes.
struct PoolPart<P> {
    phase_number: AtomicUsize,
    own: Mutex<P>,
}

/// The thread that starts the phases of a pool.
pub(super) struct Leader<'c, 'scope, P, O, R, A> {
    pool: &'scope PhasePool<P, O, R, A>,
    scope: &'c Scope<'scope>,
    workspace: RefCell<R>,
}

impl<P: Send, O: Send + Sync, R: Default, A: Fn(&O, &mut P, &mut R) + Sync> PhasePool<P, O, R, A> {
    /// A pool that does every phase of all `parts`, in any order and side by side, by `run_part`.
    /// That must not wait for other threads: while one waits it may be given more of this work, and
    /// would wait for itself.
    pub(super) fn new(parts: impl Iterator<Item = P>, run_part: A) -> Self {
        let number = || AtomicUsize::new(0);
        Self {
            parts: parts
                .map(|own| PoolPart { phase_number: number(), own: Mutex::new(own) })
                .collect(),
            run_part,
            workspace: PhantomData,
            phase: RwLock::new(None),
            phase_number: number(),
            done: number(),
            helpers: number(),
        }
    }

    /// Lets the calling thread lead, by `lead`, and returns what that does.
    pub(super) fn with_leader<'a, T: Send>(
        &'a self,
        lead: impl FnOnce(&Leader<'_, 'a, P, O, R, A>) -> T + Send,
    ) -> T {
        rayon::scope(|scope| {
            let result = lead(&Leader { pool: self, scope, workspace: RefCell::default() });
            self.phase_number.store(FINISHED, Ordering::Release);
            result
        })
    }

    /// Does what is left of a phase, from part `first` on and then from the beginning.
    fn work(&self, phase_number: usize, first: usize, workspace: &mut R) {
        let phase = self.phase.read().unwrap_or_else(PoisonError::into_inner);
        let Some(phase) = &*phase else { return };
        let (behind, ahead) = self.parts.split_at(first);
        for part in ahead.iter().chain(behind) {
            let is_done = || part.phase_number.load(Ordering::Relaxed) >= phase_number;
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
                (self.run_part)(phase, &mut own, workspace);
                part.phase_number.store(phase_number, Ordering::Relaxed);
                self.done.fetch_add(1, Ordering::Release);
            }
        }
    }

    /// Does parts of all phases that are started, until none has been for long.
    fn help(&self) {
        let first = self.parts.len() / 2;
        let (mut last, mut looks, mut workspace) = (0, 0, R::default());
        while looks < SPINS_BEFORE_LEAVING {
            let phase_number = self.phase_number.load(Ordering::Acquire);
            if phase_number == FINISHED {
                break;
            }
            if phase_number == last {
                wait(&mut looks);
            } else {
                self.work(phase_number, first, &mut workspace);
                (last, looks) = (phase_number, 0);
            }
        }
        self.helpers.fetch_sub(1, Ordering::Relaxed);
    }
}

impl<'scope, P, O, R, A> Leader<'_, 'scope, P, O, R, A>
where
    P: Send,
    O: Send + Sync,
    R: Default,
    A: Fn(&O, &mut P, &mut R) + Sync,
{
    /// Does a phase of all parts, and returns when all are done.
    pub(super) fn run(&self, phase: O) {
        let pool = self.pool;
        let phase_number = pool.phase_number.load(Ordering::Relaxed) + 1;
        *pool.phase.write().unwrap_or_else(PoisonError::into_inner) = Some(phase);
        pool.phase_number.store(phase_number, Ordering::Release);
        // Helpers that have left are called again.
        let most = rayon::current_num_threads().min(pool.parts.len());
        while pool.helpers.load(Ordering::Relaxed) + 1 < most {
            pool.helpers.fetch_add(1, Ordering::Relaxed);
            self.scope.spawn(|_| pool.help());
        }
        let mut looks = 0_usize;
        loop {
            // A helper that is late may have held a part in passing.
            if looks.is_multiple_of(SPINS_BEFORE_WORK) {
                pool.work(phase_number, 0, &mut self.workspace.borrow_mut());
            }
            if pool.done.load(Ordering::Acquire) == phase_number * pool.parts.len() {
                return;
            }
            wait(&mut looks);
        }
    }

    /// Looks at all parts, in their order.
    pub(super) fn for_each(&self, mut look: impl FnMut(&mut P)) {
        for part in &self.pool.parts {
            look(&mut part.own.lock().unwrap_or_else(PoisonError::into_inner));
        }
    }
}

/// Looks again a little later.
fn wait(looks: &mut usize) {
    *looks += 1;
    if *looks > SPINS_BEFORE_YIELD { yield_now() } else { spin_loop() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every part once in each phase, after all of the phase before.
    #[test]
    fn phases_follow_one_another() {
        for count in [0, 1, 2, 7, 100] {
            let sum = AtomicUsize::new(0);
            let run_part = |phase: &usize, part: &mut usize, (): &mut ()| {
                assert_eq!(*part, *phase);
                assert_eq!(sum.load(Ordering::Relaxed) / count, *phase);
                *part += 1;
                sum.fetch_add(1, Ordering::Relaxed);
            };
            let pool = PhasePool::new(std::iter::repeat_n(0, count), run_part);
            let seen = pool.with_leader(|leader| {
                (0..1000).for_each(|number| leader.run(number));
                let mut seen = Vec::new();
                leader.for_each(|part| seen.push(*part));
                seen
            });
            assert_eq!(seen, vec![1000; count]);
        }
    }

    /// Side by side, in a pool of one thread, and where no phase is started for long.
    #[test]
    fn pools_share_threads() {
        let count = |phases: usize| {
            let pool = PhasePool::new(0..5, |_: &(), part: &mut usize, (): &mut ()| *part += 1);
            pool.with_leader(|leader| {
                for phase in 0..phases {
                    if phase % 10 == 0 {
                        std::thread::sleep(std::time::Duration::from_millis(1));
                    }
                    leader.run(());
                }
                let mut sum = 0;
                leader.for_each(|part| sum += *part);
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
        let run_part = |_: &(), part: &mut usize, (): &mut ()| assert!(*part < 40, "too many");
        let pool = PhasePool::new(0..50, run_part);
        let led = std::panic::AssertUnwindSafe(|| pool.with_leader(|leader| leader.run(())));
        assert!(std::panic::catch_unwind(led).is_err());
    }
}
