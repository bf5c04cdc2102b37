/// Contacts that wait, each once: who comes first is first.
pub(super) struct Queue {
    /// Room for one more than all, a power of two.
    ring: Vec<u32>,
    /// Where the first and the next to come are, counted on.
    first: usize,
    next: usize,
    waits: Vec<bool>,
}

impl Queue {
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

    pub(super) fn clear(&mut self) {
        while self.pop().is_some() {}
    }
}
