use crate::SpringError;

/// A linear spring with a damper parallel to it.
///
/// The force on its first node is `(k (l - l0) + mu dl/dt) d`, where `l` is its length and `d` the
/// unit vector to the second node; the force on the second node is the opposite. (The third text
/// prints the opposite sign, and damping that acts on the velocity of one node: errata, section 9.)
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// Indices of the two nodes that it connects.
    pub nodes: [usize; 2],
    /// Spring constant k, N/m.
    pub stiffness: f64,
    /// Rest length l0, m.
    pub rest_length: f64,
    /// Damping constant mu, N s/m.
    pub damping: f64,
    /// Elastic strain beyond which the rest length gives way for good; infinite for never.
    pub yield_strain: f64,
}

impl Spring {
    /// An elastic spring without damping.
    #[must_use]
    pub fn new(nodes: [usize; 2], stiffness: f64, rest_length: f64) -> Self {
        Self { nodes, stiffness, rest_length, damping: 0.0, yield_strain: f64::INFINITY }
    }

    pub(crate) fn check(&self, spring: usize, nodes: usize) -> Result<(), SpringError> {
        let [i, j] = self.nodes;
        if let Some(&node) = self.nodes.iter().find(|&&node| node >= nodes) {
            return Err(SpringError::MissingNode { what: "spring", index: spring, node, nodes });
        }
        if i == j {
            return Err(SpringError::Loop { spring, node: i });
        }
        let refuse =
            |what, value, allowed| Err(SpringError::Spring { spring, what, value, allowed });
        let finite = "zero or positive, and finite";
        if !(self.rest_length > 0.0 && self.rest_length.is_finite()) {
            return refuse("the rest length", self.rest_length, "positive and finite (m)");
        }
        if !(self.stiffness >= 0.0 && self.stiffness.is_finite()) {
            return refuse("the stiffness", self.stiffness, finite);
        }
        if !(self.damping >= 0.0 && self.damping.is_finite()) {
            return refuse("the damping", self.damping, finite);
        }
        if self.yield_strain.is_nan() || self.yield_strain <= 0.0 {
            return refuse("the yield strain", self.yield_strain, "positive; infinite for never");
        }
        Ok(())
    }
}

/// Springs of one system, stored parameter by parameter, and their runs.
#[derive(Debug, Clone)]
pub(crate) struct Springs {
    pub(crate) nodes: Vec<[usize; 2]>,
    pub(crate) stiffness: Vec<f64>,
    pub(crate) rest_length: Vec<f64>,
    pub(crate) damping: Vec<f64>,
    pub(crate) yield_strain: Vec<f64>,
    /// Runs of springs, in the order of their lowest node.
    pub(crate) runs: Vec<SpringRun>,
    /// Whether any spring has a damper.
    pub(crate) damped: bool,
}

/// Springs `first, first + 1, ...` that connect nodes `i, i + 1, ...` with `j, j + 1, ...`.
///
/// Ropes and nets are made of long runs, over which forces are computed in SIMD lanes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpringRun {
    pub(crate) first: usize,
    pub(crate) count: usize,
    pub(crate) i: usize,
    pub(crate) j: usize,
    /// Whether all springs of the run have the parameters of the first.
    pub(crate) uniform: bool,
    /// First node that a later run may have springs at.
    pub(crate) frontier: usize,
}

impl SpringRun {
    /// First node beyond those of the springs of the run.
    pub(crate) fn end(&self) -> usize {
        self.i.max(self.j) + self.count
    }
}

/// Longest run; longer ones are cut, so that their nodes stay in the cache until they are used
/// again.
const LONGEST_RUN: usize = 1024;

impl Springs {
    pub(crate) fn new(springs: &[Spring]) -> Self {
        let mut all = Self {
            nodes: springs.iter().map(|s| s.nodes).collect(),
            stiffness: springs.iter().map(|s| s.stiffness).collect(),
            rest_length: springs.iter().map(|s| s.rest_length).collect(),
            damping: springs.iter().map(|s| s.damping).collect(),
            yield_strain: springs.iter().map(|s| s.yield_strain).collect(),
            runs: Vec::new(),
            damped: springs.iter().any(|s| s.damping > 0.0),
        };
        all.find_runs();
        all
    }

    pub(crate) fn len(&self) -> usize {
        self.nodes.len()
    }

    pub(crate) fn get(&self, s: usize) -> Spring {
        Spring {
            nodes: self.nodes[s],
            stiffness: self.stiffness[s],
            rest_length: self.rest_length[s],
            damping: self.damping[s],
            yield_strain: self.yield_strain[s],
        }
    }

    /// Updates which runs are uniform, after parameters have changed.
    pub(crate) fn refresh(&mut self) {
        let mut runs = std::mem::take(&mut self.runs);
        for run in &mut runs {
            run.uniform = (run.first + 1..run.first + run.count).all(|s| self.alike(run.first, s));
        }
        self.runs = runs;
    }

    fn alike(&self, a: usize, b: usize) -> bool {
        self.stiffness[a] == self.stiffness[b]
            && self.rest_length[a] == self.rest_length[b]
            && self.damping[a] == self.damping[b]
    }

    fn find_runs(&mut self) {
        let mut runs: Vec<SpringRun> = Vec::new();
        for (s, &[i, j]) in self.nodes.iter().enumerate() {
            match runs.last_mut() {
                Some(run)
                    if [i, j] == [run.i + run.count, run.j + run.count]
                        && run.count < LONGEST_RUN =>
                {
                    run.count += 1;
                }
                _ => {
                    runs.push(SpringRun { first: s, count: 1, i, j, uniform: true, frontier: 0 });
                }
            }
        }
        runs.sort_by_key(|run| run.i.min(run.j));
        let mut frontier = usize::MAX;
        for run in runs.iter_mut().rev() {
            run.frontier = frontier;
            frontier = frontier.min(run.i.min(run.j));
        }
        self.runs = runs;
        self.refresh();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_net_is_made_of_long_runs() {
        let columns = 5;
        let spring = |i, j| Spring::new([i, j], 1.0, 1.0);
        let mut springs: Vec<_> = (0..3)
            .flat_map(|r| (0..4).map(move |c| spring(r * columns + c, r * columns + c + 1)))
            .collect();
        springs.extend((0..10).map(|i| spring(i, i + columns)));
        let runs = Springs::new(&springs).runs;
        // Vertical springs of all rows follow each other without a gap.
        assert_eq!(runs.iter().map(|r| r.count).collect::<Vec<_>>(), [4, 10, 4, 4]);
        assert!(runs.iter().all(|r| r.uniform));
        assert_eq!(runs.iter().map(|r| r.frontier).collect::<Vec<_>>(), [0, 5, 10, usize::MAX]);
    }
}
