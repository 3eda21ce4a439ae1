//! Branches of a [`Graph`](super::Graph), and what is known of them over a box.

use super::super::interval::Interval;
use super::node::{GuardId, NodeId};

/// The guard without a condition.
pub(super) const ALWAYS: GuardId = 0;

/// A condition that holds within another guard.
#[derive(Clone, Debug)]
pub(super) struct Guard {
    pub parent: GuardId,
    pub cond: NodeId,
    pub truth: bool,
    /// The values outside of it that it uses and that its condition may narrow.
    pub affected: Vec<NodeId>,
}

/// A guard over a box.
#[derive(Clone, Debug, Default)]
pub(super) struct GuardContext {
    pub state: Reached,
    /// The values that are narrower than outside.
    pub narrowed: Vec<(NodeId, Interval)>,
}

/// Whether any execution reaches a guard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Reached {
    #[default]
    Unknown,
    Maybe,
    Never,
}
