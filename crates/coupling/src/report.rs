use crate::{ContactReport, ContactTimes};

/// What a step of many fibres cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepReport {
    /// Number of fibres.
    pub fibers: usize,
    /// Newton iterations, summed over the fibres.
    pub iterations: usize,
    /// Iterations of the fibre that needed most.
    pub worst_iterations: usize,
    /// How often a step was halved because Newton's method failed.
    pub halvings: usize,
    /// How often a step was longer than its tolerance allows although it was the smallest.
    pub missed: usize,
    /// What the contacts were and cost, if there are any.
    pub contact: ContactReport,
    /// Time that the phases of contacts took.
    pub contact_times: ContactTimes,
}

impl StepReport {
    /// The report of a single fibre.
    #[must_use]
    pub fn of_one(iterations: usize, halvings: usize, missed: usize) -> Self {
        Self {
            fibers: 1,
            iterations,
            worst_iterations: iterations,
            halvings,
            missed,
            ..Self::default()
        }
    }

    /// Counts the fibres of another report too.
    pub fn add(&mut self, other: &Self) {
        self.fibers += other.fibers;
        self.iterations += other.iterations;
        self.worst_iterations = self.worst_iterations.max(other.worst_iterations);
        self.halvings += other.halvings;
        self.missed += other.missed;
        self.contact.add(&other.contact);
        self.contact_times += other.contact_times;
    }
}
