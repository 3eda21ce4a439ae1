//! The policies that `check --accept` obeys, as `lock` does.

use landfall_layout::diff::{VariantDiff, diff_variants};
use landfall_layout::lock::Lock;
use landfall_layout::{Error, ShaderLayout};

use crate::approvals::Approvals;
use crate::args::CheckArgs;
use crate::config::Config;

/// The policies of a configuration, and the changes that are approved.
pub struct Policies<'a> {
    config: &'a Config,
    /// `None` if no lock is written.
    approvals: Option<Approvals>,
}

impl<'a> Policies<'a> {
    /// Reads the approvals if locks may be written.
    pub fn open(config: &'a Config, args: &CheckArgs) -> Result<Policies<'a>, Error> {
        let read = || Approvals::open(&config.locks(args.locks.as_deref()));
        let approvals = (args.accept && config.has_policy()).then(read).transpose()?;
        Ok(Policies { config, approvals })
    }

    /// Whether a policy forbids the changes of a shader against its lock.
    pub fn forbid(&self, shader: &ShaderLayout, old: &Lock) -> bool {
        let Some(approvals) = &self.approvals else { return false };
        let path = shader.files.iter().next().map_or("", |file| file.path.as_str());
        let key = self.config.root.below(path.as_ref()).unwrap_or_else(|| path.to_string());
        let Some(policy) = self.config.policy_of(&key) else { return false };
        let old = old.layout();
        let is_forbidden =
            |one: &VariantDiff<'_>| !approvals.forbidden(policy, &key, &one.blocks).is_empty();
        diff_variants(&old, shader).iter().any(is_forbidden)
    }
}
