//! The policies that `lock`, `check --accept` and `diff --accept` obey.

use landfall_layout::diagnostic::Code;
use landfall_layout::diff::{Policy, VariantDiff, diff_variants};
use landfall_layout::lock::Lock;
use landfall_layout::{Diagnostic, Error, ShaderLayout};

use crate::config::Config;

/// Whether the policy for a shader forbids its changes since a lock.
pub fn forbids(config: &Config, shader: &ShaderLayout, old: &Lock) -> bool {
    let path = shader.files.iter().next().map_or("", |file| file.path.as_str());
    let key = config.root.below(path.as_ref()).unwrap_or_else(|| path.to_string());
    let Some(policy) = config.policy_of(&key) else { return false };
    let old = old.layout();
    let is_forbidden = |one: &VariantDiff<'_>| policy.forbidden(&one.blocks).next().is_some();
    diff_variants(&old, shader).iter().any(is_forbidden)
}

/// The errors about changes of a shader that a policy forbids.
pub fn forbidden(shader: &str, policy: Policy, diff: &VariantDiff<'_>) -> Vec<Diagnostic> {
    let under = diff.name().map_or(String::new(), |name| format!(" under `{name}`"));
    let changes = policy.forbidden(&diff.blocks).map(|(block, change)| {
        let message = format!(
            "has a change of block `{}`{under} that policy `{}` forbids: {}",
            block.name,
            policy.name(),
            change.message
        );
        let help = "undo it, or write the lock with `landfall lock --policy none`";
        let found = Error::new(shader, message).with_help(help);
        Diagnostic { code: Code::PolicyForbids, ..found.into() }
    });
    changes.collect()
}
