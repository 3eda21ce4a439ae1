//! Approved changes of layouts: `approvals.json` beside the locks.
//!
//! An entry is one change of one block of one shader, with the reason for it. `landfall lock
//! --approve REASON` adds entries; `lock` and `diff` do not count the changes that have one.

use std::path::{Path, PathBuf};

use landfall_layout::diagnostic::Code;
use landfall_layout::diff::{BlockDiff, Change, Policy};
use landfall_layout::file::FileWriter;
use landfall_layout::format::diff::Verdict;
use landfall_layout::{Diagnostic, Error};
use serde::{Deserialize, Serialize};

use crate::read;

/// The name of the file in the directory of locks.
const NAME: &str = "approvals.json";

const VERSION: u32 = 1;

/// One approved change.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Approval {
    /// The shader's path from the configuration's directory.
    shader: String,
    block: String,
    kind: String,
    path: String,
    old: Option<String>,
    new: Option<String>,
    reason: String,
}

impl Approval {
    pub fn of(shader: &str, block: &BlockDiff, change: &Change, reason: &str) -> Approval {
        Approval {
            shader: shader.to_string(),
            block: block.name.clone(),
            kind: change.kind.name().to_string(),
            path: change.path.clone(),
            old: change.old.clone(),
            new: change.new.clone(),
            reason: reason.to_string(),
        }
    }

    /// Whether it is the same change; reasons are not compared.
    fn is_same(&self, other: &Approval) -> bool {
        Approval { reason: String::new(), ..self.clone() }
            == Approval { reason: String::new(), ..other.clone() }
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ApprovalsDocument {
    schema_version: u32,
    approvals: Vec<Approval>,
}

/// The approvals of a project.
pub struct Approvals {
    file: PathBuf,
    entries: Vec<Approval>,
}

impl Approvals {
    /// Reads the approvals beside the locks; there may be none.
    ///
    /// # Errors
    ///
    /// The file is not one of approvals, or is one of a newer landfall.
    pub fn open(locks: &Path) -> Result<Approvals, Error> {
        let file = locks.join(NAME);
        if file.symlink_metadata().is_err() {
            return Ok(Approvals { file, entries: Vec::new() });
        }
        let shown = read::display_path(&file);
        let text = read::text(&file)?;
        let refuse = |what: String| {
            Error::new(&*shown, format!("is not a file of approvals: {what}"))
                .with_help("move it away; `landfall lock --approve REASON` writes a new one")
        };
        let document: ApprovalsDocument =
            serde_json::from_str(&text).map_err(|e| refuse(e.to_string()))?;
        if document.schema_version != VERSION {
            return Err(refuse(format!("its schema version is {}", document.schema_version)));
        }
        Ok(Approvals { file, entries: document.approvals })
    }

    /// Returns the verdict of a policy on each change of a shader's blocks.
    pub fn judge(&self, policy: Policy, shader: &str, blocks: &[BlockDiff]) -> Vec<Vec<Verdict>> {
        let one = |block: &BlockDiff, change: &Change| {
            if !policy.forbids(change) {
                return Verdict::Allowed;
            }
            let wanted = Approval::of(shader, block, change, "");
            match self.entries.iter().find(|entry| entry.is_same(&wanted)) {
                Some(entry) => Verdict::Approved(entry.reason.clone()),
                None => Verdict::Forbidden,
            }
        };
        let block = |block: &BlockDiff| block.changes.iter().map(|c| one(block, c)).collect();
        blocks.iter().map(block).collect()
    }

    /// The changes that a policy forbids and that are not approved.
    pub fn forbidden<'b>(
        &self,
        policy: Policy,
        shader: &str,
        blocks: &'b [BlockDiff],
    ) -> Vec<(&'b BlockDiff, &'b Change)> {
        let verdicts = self.judge(policy, shader, blocks).into_iter().flatten();
        let changes = blocks.iter().flat_map(|block| block.changes.iter().map(move |c| (block, c)));
        let judged = changes.zip(verdicts);
        judged.filter(|(_, verdict)| *verdict == Verdict::Forbidden).map(|(c, _)| c).collect()
    }

    /// Adds approvals and writes the file.
    pub fn add(mut self, new: Vec<Approval>, writer: &FileWriter) -> Result<(), Error> {
        self.entries.retain(|entry| !new.iter().any(|other| other.is_same(entry)));
        self.entries.extend(new);
        self.entries.sort();
        self.entries.dedup();
        let document = ApprovalsDocument { schema_version: VERSION, approvals: self.entries };
        let text = serde_json::to_string_pretty(&document).expect("approvals are strings");
        writer.write(&self.file, text + "\n").map(|_| ())
    }
}

/// The error about a change that a policy forbids.
pub fn forbids(
    shader: &str,
    policy: Policy,
    (block, variant): (&BlockDiff, Option<String>),
    change: &Change,
) -> Diagnostic {
    let (block, policy) = (&block.name, policy.name());
    let under = variant.map_or(String::new(), |name| format!(" under `{name}`"));
    let message = format!(
        "has a change of block `{block}`{under} that policy `{policy}` forbids: {}",
        change.message
    );
    let found = Error::new(shader, message)
        .with_help("undo it, or approve it with `landfall lock --approve REASON`");
    Diagnostic { code: Code::PolicyForbids, ..found.into() }
}
