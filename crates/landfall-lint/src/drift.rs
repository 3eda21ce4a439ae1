//! Compares a shader with its lock: the findings of `layout-drift`, `lock-missing` and
//! `lock-orphan`.
//!
//! Uses [`landfall_layout::diff`] with the lock as the old side.

use landfall_layout::diagnostic::Severity;
use landfall_layout::diff::{BlockDiff, Class, diff_variants};
use landfall_layout::finding::{Finding, Place};
use landfall_layout::format::Paint;
use landfall_layout::format::diff::{Compared, Width};
use landfall_layout::lock::{Lock, write};
use landfall_layout::shape::AddressSpace;
use landfall_layout::{ShaderLayout, variant_name};

/// The number of changes that a finding lists after the most serious one.
const MAX_NOTES: usize = 8;

/// The width of a finding's listing, in columns.
const COLUMNS: Width = Width::Columns(96);

/// Returns the findings about a shader and its lock: `layout-drift` for every block whose layout
/// differs from the lock, or `lock-missing` if there is no lock.
///
/// A shader without blocks and loose uniforms needs no lock.
pub fn drift(shader: &ShaderLayout, lock_path: &str, lock: Option<&Lock>) -> Vec<Finding> {
    let Some(lock) = lock else {
        let has_none = |layout: &ShaderLayout| layout.blocks.is_empty();
        let variants = shader.laid_out_variants().map(|(_, layout)| layout);
        return if std::iter::once(shader).chain(variants).all(has_none) {
            Vec::new()
        } else {
            vec![missing(shader, lock_path)]
        };
    };
    let mut found = compare(shader, &lock.layout(), None);
    found.extend(lost_variants(shader, lock_path, lock));
    // The layouts agree, but not the texts.
    if found.is_empty() && lock.text_without_devices() != write(shader) {
        let message = format!("`{lock_path}` records the same layout with other names");
        found.push(
            drifted(&shader.path, Place::file(&shader.path), message)
                .with_help("renew the lock with `landfall lock`, or `landfall check --accept`"),
        );
    }
    found
}

/// Returns the findings of `layout-drift` about a shader and its layout at a revision.
pub fn since(shader: &ShaderLayout, revision: &str, old: &ShaderLayout) -> Vec<Finding> {
    compare(shader, old, Some(revision))
}

fn compare(shader: &ShaderLayout, old: &ShaderLayout, revision: Option<&str>) -> Vec<Finding> {
    let mut found = Vec::new();
    for one in diff_variants(old, shader) {
        let name = one.name();
        let compared = Compared {
            name: &shader.path,
            variant: name.as_deref(),
            old: one.old,
            new: one.new,
            blocks: &one.blocks,
            policy: None,
            rust_field: |_, _| None,
        };
        // A lock without the variant records that its macros change nothing.
        let is_new = name.is_some() && old.variants.iter().all(|v| v.macros != one.macros);
        for (block, also) in one.blocks.iter().zip(&one.also) {
            let mut finding = of_block(&compared, block, revision);
            if is_new && revision.is_none() {
                finding = finding.with_note(
                    "the lock has no such variant: it is compared with the shader without its macros",
                );
            }
            for other in also {
                finding = finding.with_note(format!("the same under `{other}`"));
            }
            found.push(finding);
        }
    }
    found
}

/// Returns the findings about variants that the lock has, but that are not configured or cannot be
/// laid out.
fn lost_variants(shader: &ShaderLayout, lock_path: &str, lock: &Lock) -> Vec<Finding> {
    let mut found = Vec::new();
    for recorded in &lock.variants {
        let name = variant_name(&recorded.macros);
        let now = shader.variants.iter().find(|variant| variant.macros == recorded.macros);
        let (message, help) = match now.map(|variant| variant.layout.as_deref()) {
            None => (
                format!("`{lock_path}` records the variant `{name}`, which is not configured"),
                "add its macros to `permutations`, or renew the lock with `landfall lock`",
            ),
            Some(Some(layout)) if layout.has_errors() => (
                format!("`{lock_path}` records the variant `{name}`, which cannot be laid out"),
                "`landfall layout` with `-D` for each macro tells why",
            ),
            Some(_) => continue,
        };
        let about = format!("{} under {name}", shader.path);
        found.push(drifted(&about, Place::file(&shader.path), message).with_help(help));
    }
    found
}

/// Returns the finding of a lock whose shader does not exist.
pub fn orphan(lock_path: &str) -> Finding {
    let message = format!("`{lock_path}` is a lock without a shader");
    Finding::at("lock-orphan", lock_path, Place::file(lock_path), message)
        .with_note("its shader was removed, renamed, or is left out of this run")
        .with_help("remove it with `landfall lock --prune`")
}

fn missing(shader: &ShaderLayout, lock_path: &str) -> Finding {
    let message = format!("`{}` has no lock: changes of its layout go unseen", shader.path);
    Finding::at("lock-missing", &shader.path, Place::file(&shader.path), message)
        .with_note(format!("its lock would be `{lock_path}`"))
        .with_help("write it with `landfall lock`, and commit it")
}

fn drifted(about: &str, place: Place, message: String) -> Finding {
    let mut found = Finding::at("layout-drift", about, place, message);
    found.severity = Severity::Error;
    found
}

fn of_block(compared: &Compared<'_>, block: &BlockDiff, revision: Option<&str>) -> Finding {
    // Changes are in the order of their seriousness.
    let worst = &block.changes[0];
    let now = block.new.map(|at| &compared.new.blocks[at]);
    let was = block.old.map(|at| &compared.old.blocks[at]);
    let mut differs = match revision {
        None => "differs from its lock".to_string(),
        Some(revision) => format!("differs from `{revision}`"),
    };
    let mut about = block.name.clone();
    if let Some(name) = compared.variant {
        differs = format!("under `{name}` {differs}");
        about = format!("{about} under {name}");
    }
    let (place, text) = match now {
        Some(new) => (Place::new(&compared.new.files, new.span), differs.as_str()),
        None => (Place::file(&compared.new.path), ""),
    };
    let loose = now.or(was).is_some_and(|block| block.space == AddressSpace::Default);
    let (whose, outdated) = match revision {
        None => ("the lock's", ", but the lock is out of date"),
        Some(_) => ("the old", ""),
    };
    let effect = match (worst.class, loose) {
        (Class::Breaking, false) => format!("buffers filled for {whose} layout are misread"),
        (Class::Breaking, true) => format!("values set for {whose} uniforms have no effect"),
        (Class::Compatible, false) => {
            format!("buffers filled for it are still read correctly{outdated}")
        }
        (Class::Compatible, true) => format!("values set for its uniforms still apply{outdated}"),
        (Class::Cosmetic, _) => format!("no byte changes{outdated}"),
    };
    let message = format!("`{}` {differs}: {}; {effect}", block.name, worst.message);
    let mut found = drifted(&about, place, message).with_text(text);
    if let Some(old) = was {
        let declaration = match revision {
            None => "locked declaration".to_string(),
            Some(revision) => format!("declaration in `{revision}`"),
        };
        found = found.with_label(Place::new(&compared.old.files, old.span), declaration);
    }
    for change in block.changes.iter().skip(1).take(MAX_NOTES) {
        found = found.with_note(format!("{}: {}", change.class.name(), change.message));
    }
    let more = block.changes.len().saturating_sub(1 + MAX_NOTES);
    if more > 0 {
        found = found.with_note(format!("and {more} more; `landfall diff` lists them all"));
    }
    let help = match (worst.class, revision) {
        (Class::Breaking, None) => {
            "undo it, or change what uploads the block and renew the lock with \
             `landfall check --accept` or `landfall lock`"
        }
        (Class::Compatible | Class::Cosmetic, None) => {
            "renew the lock with `landfall check --accept` or `landfall lock`"
        }
        (Class::Breaking, Some(_)) => "undo it, or change what uploads the block",
        (Class::Compatible | Class::Cosmetic, Some(_)) => {
            "allow it with `// landfall: allow(layout-drift)` until it is merged"
        }
    };
    let beside = compared.side_by_side(block, COLUMNS, Paint::Plain);
    found.with_listing(beside).with_help(help)
}
