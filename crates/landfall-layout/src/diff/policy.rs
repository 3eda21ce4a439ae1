//! Policies: the changes of a layout that a project does not allow.

use super::{BlockDiff, Change, Class, Kind};

/// The changes that are not allowed. Each policy forbids all that the one before it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Policy {
    /// Every change is allowed.
    #[serde(rename = "none")]
    Unrestricted,
    /// Bytes uploaded for the old layout still land: members may be appended or fill padding.
    Superset,
    /// No byte changes its meaning, and no offset, size or stride its number.
    Bytes,
    /// In addition, no block, instance, structure or member changes its name.
    Names,
    /// In addition, no declaration changes in generated code, such as one array for three members.
    Code,
}

impl Policy {
    /// All policies, the most permissive first.
    pub const ALL: [Policy; 5] =
        [Policy::Unrestricted, Policy::Superset, Policy::Bytes, Policy::Names, Policy::Code];

    /// The name: `none`, `superset`, `bytes`, `names` or `code`.
    pub fn name(self) -> &'static str {
        match self {
            Policy::Unrestricted => "none",
            Policy::Superset => "superset",
            Policy::Bytes => "bytes",
            Policy::Names => "names",
            Policy::Code => "code",
        }
    }

    /// The policy of that name.
    pub fn from_name(name: &str) -> Option<Policy> {
        Policy::ALL.into_iter().find(|policy| policy.name() == name)
    }

    /// The changes of these blocks that are not allowed.
    pub fn forbidden(self, blocks: &[BlockDiff]) -> impl Iterator<Item = (&BlockDiff, &Change)> {
        let changes = blocks.iter().flat_map(|block| block.changes.iter().map(move |c| (block, c)));
        changes.filter(move |(_, change)| self.forbids(change))
    }

    /// Whether a change is not allowed.
    pub fn forbids(self, change: &Change) -> bool {
        match least(change) {
            Some(least) => self >= least,
            None => false,
        }
    }
}

/// The most permissive policy that forbids a change; `None` if no policy does.
fn least(change: &Change) -> Option<Policy> {
    // Breaking is forbidden by every policy but `none`.
    if change.class == Class::Breaking {
        return Some(Policy::Superset);
    }
    match change.kind {
        Kind::Moved
        | Kind::Retyped
        | Kind::Appended
        | Kind::Inserted
        | Kind::PaddingUsed
        | Kind::Removed
        | Kind::Lengthened
        | Kind::Shortened
        | Kind::ArrayStride
        | Kind::MatrixStride
        | Kind::MatrixLayout
        | Kind::Grew
        | Kind::Shrank
        | Kind::Alignment => Some(Policy::Bytes),
        Kind::Renamed | Kind::Instance | Kind::StructureRenamed | Kind::BlockRenamed => {
            Some(Policy::Names)
        }
        Kind::Reshaped | Kind::Rules | Kind::AddressSpace => Some(Policy::Code),
        // A new block has no old bytes, and no code names it; the others are outside the bytes.
        Kind::RulesDeclared
        | Kind::Slot
        | Kind::Count
        | Kind::Order
        | Kind::BlockAdded
        | Kind::BlockRemoved => None,
    }
}
