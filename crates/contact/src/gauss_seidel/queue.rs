/// Contacts that wait to be looked at, each once, first in first out.
pub(super) struct ContactQueue {
    /// Ring buffer for one contact more than there are; its length is a power of two.
    ring: Vec<u32>,
    /// Place of the first contact, not wrapped around.
    first: usize,
    /// Place of the next to come, not wrapped around.
    next: usize,
    /// Whether a contact is in the queue.
    waits: Vec<bool>,
}

impl ContactQueue {
    /// An empty queue for contacts of numbers less than `count`.
    pub(super) fn new(count: usize) -> Self {
        let ring = vec![0; (count + 1).next_power_of_two()];
        Self { ring, first: 0, next: 0, waits: vec![false; count] }
    }

    /// Puts a contact at the end unless it waits: without a branch, as none could be foreseen.
    #[inline(always)]
    pub(super) fn push(&mut self, i: u32) {
        let last = self.ring.len() - 1;
        self.ring[self.next & last] = i;
        let waits = &mut self.waits[i as usize];
        self.next += usize::from(!*waits);
        *waits = true;
    }

    /// Takes the first contact out.
    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<usize> {
        if self.first == self.next {
            return None;
        }
        let i = self.ring[self.first & (self.ring.len() - 1)] as usize;
        self.first += 1;
        self.waits[i] = false;
        Some(i)
    }

    /// Takes all contacts out.
    pub(super) fn clear(&mut self) {
        while self.pop().is_some() {}
    }
}
