//! Applies the edits of findings to texts.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::finding::{Edit, Finding};

/// A file with its edits applied.
#[derive(Clone, Debug)]
pub struct Fixed {
    /// Its path as findings spell it.
    pub path: String,
    /// Its text before.
    pub old: Arc<str>,
    /// Its text after.
    pub new: String,
    /// Edits applied.
    pub edits: usize,
}

/// Applies every edit that does not touch another; findings whose edits overlap wait for the next
/// round.
pub fn apply(findings: &[Finding], text: &dyn Fn(&str) -> Option<Arc<str>>) -> Vec<Fixed> {
    let mut taken: BTreeMap<&str, Vec<&Edit>> = BTreeMap::new();
    for finding in findings {
        let clash = finding.fix.iter().any(|edit| {
            let others = taken.get(edit.place.path.as_str());
            others.into_iter().flatten().any(|other| {
                edit.place.start <= other.place.end && other.place.start <= edit.place.end
            })
        });
        if !clash {
            for edit in &finding.fix {
                taken.entry(&edit.place.path).or_default().push(edit);
            }
        }
    }
    let mut fixed = Vec::new();
    for (path, mut edits) in taken {
        let Some(old) = text(path) else { continue };
        edits.sort_by_key(|edit| edit.place.start);
        let mut new = old.to_string();
        for edit in edits.iter().rev() {
            let range = edit.place.start as usize..edit.place.end as usize;
            if new.get(range.clone()).is_some() {
                new.replace_range(range, &edit.new);
            }
        }
        fixed.push(Fixed { path: path.to_string(), old, new, edits: edits.len() });
    }
    fixed
}
