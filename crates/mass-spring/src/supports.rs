use crate::NodeVectors;
use nalgebra::SVector;
use std::collections::BTreeSet;
use std::ops::Range;

/// Kind of motion of one component of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Guide {
    /// Moved by the forces on the node.
    Free,
    /// Moved at a prescribed velocity, whatever forces act.
    Driven,
    /// Moved by the forces on all nodes of a tie, given by its index.
    Tied(usize),
}

/// Nodes that move together along an axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NodeTie {
    pub(crate) axis: usize,
    pub(crate) nodes: BTreeSet<usize>,
}

/// The supports of a system: components of nodes that do not move freely.
#[derive(Debug, Clone, Default)]
pub(crate) struct Supports<const D: usize> {
    /// Pairs of node and axis with a prescribed velocity.
    driven: BTreeSet<(usize, usize)>,
    pub(crate) ties: Vec<NodeTie>,
    /// All nodes with a component that is not free, in order.
    pub(crate) guided: Vec<(usize, [Guide; D])>,
    /// Ranges of nodes without supports, between the guided ones.
    pub(crate) free: Vec<Range<usize>>,
    nodes: usize,
}

impl<const D: usize> Supports<D> {
    pub(crate) fn none(nodes: usize) -> Self {
        Self { nodes, free: std::iter::once(0..nodes).collect(), ..Self::default() }
    }

    pub(crate) fn drive(&mut self, node: usize, axes: Range<usize>) {
        self.driven.extend(axes.map(|axis| (node, axis)));
        self.refresh();
    }

    /// Frees all components of a node, but keeps its ties.
    pub(crate) fn release(&mut self, node: usize) {
        self.driven.retain(|&(n, _)| n != node);
        self.refresh();
    }

    /// Ties that share a node along the same axis become one.
    pub(crate) fn tie(&mut self, axis: usize, nodes: BTreeSet<usize>) {
        let mut tie = NodeTie { axis, nodes };
        self.ties.retain(|other| {
            let apart = other.axis != axis || other.nodes.is_disjoint(&tie.nodes);
            if !apart {
                tie.nodes.extend(&other.nodes);
            }
            apart
        });
        self.ties.push(tie);
        self.refresh();
    }

    /// All nodes that move as `node` does along `axis`, itself among them.
    pub(crate) fn partners(&self, node: usize, axis: usize) -> Vec<usize> {
        let tie = self.ties.iter().find(|tie| tie.axis == axis && tie.nodes.contains(&node));
        tie.map_or(vec![node], |tie| tie.nodes.iter().copied().collect())
    }

    /// Kind of motion of component `axis` of `node`.
    pub(crate) fn guide(&self, node: usize, axis: usize) -> Guide {
        let found = self.guided.binary_search_by_key(&node, |(node, _)| *node);
        found.map_or(Guide::Free, |k| self.guided[k].1[axis])
    }

    /// Projects onto the motions that the supports allow: zero where a component is driven, the
    /// mean over the nodes of a tie.
    pub(crate) fn project(&self, columns: &mut NodeVectors<D>) {
        self.project_weighted(columns, |_| 1.0);
    }

    /// Projects as [`Self::project`] does, for components that have been multiplied by a weight for
    /// every node.
    pub(crate) fn project_weighted(
        &self,
        columns: &mut NodeVectors<D>,
        weight: impl Fn(usize) -> f64,
    ) {
        for (node, guides) in &self.guided {
            for axis in 0..D {
                if guides[axis] == Guide::Driven {
                    columns.0[axis][*node] = 0.0;
                }
            }
        }
        for tie in &self.ties {
            let column = &mut columns.0[tie.axis];
            let sum: f64 = tie.nodes.iter().map(|&node| weight(node) * column[node]).sum();
            let total: f64 = tie.nodes.iter().map(|&node| weight(node).powi(2)).sum();
            tie.nodes.iter().for_each(|&node| column[node] = weight(node) * sum / total);
        }
    }

    /// Adds `change` to a node, and to the nodes that move with it.
    pub(crate) fn add(&self, columns: &mut NodeVectors<D>, node: usize, change: &SVector<f64, D>) {
        for axis in 0..D {
            for partner in self.partners(node, axis) {
                columns.0[axis][partner] += change[axis];
            }
        }
    }

    /// Whether the velocity of a component is prescribed.
    pub(crate) fn driven(&self, node: usize, axis: usize) -> bool {
        self.driven.contains(&(node, axis))
    }

    fn refresh(&mut self) {
        let mut nodes: BTreeSet<usize> = self.driven.iter().map(|(node, _)| *node).collect();
        nodes.extend(self.ties.iter().flat_map(|tie| &tie.nodes));
        self.guided = nodes
            .iter()
            .map(|&node| (node, std::array::from_fn(|axis| self.find(node, axis))))
            .collect();
        self.free.clear();
        let mut start = 0;
        for &node in nodes.iter().chain([&self.nodes]) {
            if node > start {
                self.free.push(start..node);
            }
            start = node + 1;
        }
    }

    fn find(&self, node: usize, axis: usize) -> Guide {
        let tied = self.ties.iter().position(|t| t.axis == axis && t.nodes.contains(&node));
        // A tie with one driven node is driven as a whole.
        match tied {
            Some(tie) if !self.ties[tie].nodes.iter().any(|&n| self.driven(n, axis)) => {
                Guide::Tied(tie)
            }
            None if !self.driven(node, axis) => Guide::Free,
            _ => Guide::Driven,
        }
    }
}
