//! A shader held against its lock: the findings of `layout-drift`, `lock-missing` and
//! `lock-orphan`.
//!
//! Compares by [`landfall_layout::diff`], the lock being the old side; the lints of those codes say what
//! they are about.

use landfall_layout::ShaderLayout;
use landfall_layout::diff::{BlockDiff, Class, Side, diff};
use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::format::Paint;
use landfall_layout::format::diff::{Compared, Width};
use landfall_layout::lock::{Lock, write};
use landfall_layout::shape::AddressSpace;

/// Changes that a finding spells out beside the most serious one.
const MOST_NOTES: usize = 8;

/// Columns of the listing that a finding carries.
const COLUMNS: Width = Width::Columns(96);

/// What there is to say about a shader and its lock: `layout-drift` for every block that is not
/// what the lock says, or `lock-missing` when there is none.
///
/// A shader without blocks and loose uniforms needs no lock.
pub fn drift(shader: &ShaderLayout, lock_path: &str, lock: Option<&Lock>) -> Vec<Finding> {
    let Some(lock) = lock else {
        return if shader.blocks.is_empty() {
            Vec::new()
        } else {
            vec![missing(shader, lock_path)]
        };
    };
    let old = lock.layout();
    let changed = diff(Side::of(&old), Side::of(shader));
    let compared = Compared { name: &shader.path, old: &old, new: shader, blocks: &changed };
    let mut found: Vec<Finding> = changed.iter().map(|block| of_block(&compared, block)).collect();
    if found.is_empty() && lock.bare() != write(shader) {
        let message = format!("`{lock_path}` records the same bytes in other words");
        found.push(
            drifted(&shader.path, Place::file(&shader.path), message)
                .with_help("renew the lock with `landfall lock`, or `landfall check --accept`"),
        );
    }
    found
}

/// A lock whose shader is gone.
pub fn orphan(lock_path: &str) -> Finding {
    let message = format!("`{lock_path}` is the lock of no shader");
    let mut found = Finding::new("lock-orphan", lock_path, Place::file(lock_path), message)
        .with_note("its shader was removed, renamed, or is left out of this run")
        .with_help("remove it with `landfall lock --prune`");
    found.level = Level::Warn;
    found
}

fn missing(shader: &ShaderLayout, lock_path: &str) -> Finding {
    let message = format!("`{}` has no lock: changes of its layout go unseen", shader.path);
    let mut found = Finding::new("lock-missing", &shader.path, Place::file(&shader.path), message)
        .with_note(format!("it would be `{lock_path}`"))
        .with_help("write it with `landfall lock`, and commit it");
    found.level = Level::Warn;
    found
}

fn drifted(about: &str, place: Place, message: String) -> Finding {
    let mut found = Finding::new("layout-drift", about, place, message);
    found.level = Level::Deny;
    found
}

fn of_block(compared: &Compared<'_>, block: &BlockDiff) -> Finding {
    let worst = &block.changes[0];
    let now = block.new.map(|at| &compared.new.blocks[at]);
    let was = block.old.map(|at| &compared.old.blocks[at]);
    let (place, text) = match now {
        Some(new) => (Place::of(&compared.new.files, new.span), "not what its lock says"),
        None => (Place::file(&compared.new.path), ""),
    };
    let loose = now.or(was).is_some_and(|block| block.space == AddressSpace::Default);
    let effect = match (worst.class, loose) {
        (Class::Breaking, false) => "uploads made for the lock's layout are misread",
        (Class::Breaking, true) => "values set for the lock's uniforms do not arrive",
        (Class::Compatible, false) => "old uploads still land, but the lock is out of date",
        (Class::Compatible, true) => "old values still arrive, but the lock is out of date",
        (Class::Cosmetic, _) => "no byte changes, but the lock is out of date",
    };
    let message =
        format!("`{}` is not what its lock says: {}; {effect}", block.name, worst.message);
    let mut found = drifted(&block.name, place, message).with_text(text);
    if let Some(old) = was {
        found = found.with_related(Place::of(&compared.old.files, old.span), "what is locked");
    }
    for change in block.changes.iter().skip(1).take(MOST_NOTES) {
        found = found.with_note(format!("{}: {}", change.class.name(), change.message));
    }
    let more = block.changes.len().saturating_sub(1 + MOST_NOTES);
    if more > 0 {
        found = found.with_note(format!("and {more} more; `landfall diff` lists them all"));
    }
    let help = match worst.class {
        Class::Breaking => {
            "undo it, or change what uploads the block and renew the lock with \
             `landfall check --accept` or `landfall lock`"
        }
        Class::Compatible | Class::Cosmetic => {
            "renew the lock with `landfall check --accept` or `landfall lock`"
        }
    };
    let beside = compared.beside(block, COLUMNS, Paint::Plain);
    found.with_listing(beside).with_help(help)
}
