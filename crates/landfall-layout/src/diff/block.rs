//! Changes of a block besides its members' bytes: size, rules, binding, names.

use std::cell::OnceCell;

use rustc_hash::FxHashMap;

use super::{Change, Class, Kind, SidedBlock, shown_name};
use crate::layout::measure::fixed_elements;
use crate::layout::{BlockLayout, MemberLayout};
use crate::shape::Type;
use crate::source::Language;
use crate::text::counts::{bytes, number};

/// The change of a block that only the old side has.
pub(super) fn removed(block: &BlockLayout) -> Change {
    let name = shown_name(block);
    change(
        (Kind::BlockRemoved, Class::Breaking),
        (Some(name.clone()), None),
        format!("block `{name}` was removed"),
    )
}

/// The change of a block that only the new side has.
pub(super) fn added(block: &BlockLayout) -> Change {
    let name = shown_name(block);
    let size = match block.size {
        Some(size) => format!(", {}", bytes(size)),
        None => String::new(),
    };
    let message = format!("block `{name}` is new{size}");
    change((Kind::BlockAdded, Class::Compatible), (None, Some(name)), message)
}

/// The change of a block's address space.
pub(super) fn space(old: &BlockLayout, new: &BlockLayout) -> Change {
    let (was, is) = (old.space.name(), new.space.name());
    let message = format!("is in the address space `{is}`, was in `{was}`");
    change((Kind::AddressSpace, Class::Breaking), (Some(was.into()), Some(is.into())), message)
}

/// A change of the block itself.
fn change(
    (kind, class): (Kind, Class),
    (old, new): (Option<String>, Option<String>),
    message: String,
) -> Change {
    Change { kind, class, path: String::new(), old, new, message }
}

/// Adds the changes of a block whose leaves have been compared.
pub(super) fn changes(old: SidedBlock<'_>, new: SidedBlock<'_>, changes: &mut Vec<Change>) {
    let (a, b) = (old.layout, new.layout);
    let leaves_changed = changes.iter().any(|change| change.class > Class::Cosmetic);
    let text = |n: u64| Some(n.to_string());
    if let (Some(was), Some(is)) = (a.size, b.size) {
        // A buffer that is too large is valid, one that is too small is not: the host may have to
        // change, but what it uploads is read as before.
        let compatible = Class::Compatible;
        if is > was {
            let size = bytes(is);
            let message = format!("grew from {} to {size}: make its buffer {size}", number(was));
            changes.push(change((Kind::Grew, compatible), (text(was), text(is)), message));
        } else if is < was {
            let message = format!("shrank from {} to {}", number(was), bytes(is));
            changes.push(change((Kind::Shrank, compatible), (text(was), text(is)), message));
        }
    }
    if a.rules != b.rules {
        let (was, is) = (a.rules.name(), b.rules.name());
        let rest = if leaves_changed { "" } else { ", and no member moves" };
        let message = format!("rules changed from {was} to {is}{rest}");
        let values = (Some(was.to_string()), Some(is.to_string()));
        changes.push(change((Kind::Rules, Class::Cosmetic), values, message));
    }
    if a.rules_declared != b.rules_declared {
        let (class, message) = match b.rules_declared {
            true => {
                (Class::Compatible, "its rules are now declared; before, the driver chose them")
            }
            false => (
                Class::Breaking,
                "its rules are no longer declared: the driver chooses the offsets",
            ),
        };
        let values = (Some(a.rules_declared.to_string()), Some(b.rules_declared.to_string()));
        changes.push(change((Kind::RulesDeclared, class), values, message.to_string()));
    }
    if a.space != b.space {
        changes.push(space(a, b));
    }
    slot("set", set(old, new), set(new, old), changes);
    slot("binding", a.binding, b.binding, changes);
    count(a, b, changes);
    names(a, b, changes);
    let mut found = Vec::new();
    below(&a.members, &b.members, "", changes, &mut found);
    changes.extend(found);
    let order =
        |block: &BlockLayout| block.members.iter().map(|m| m.name.clone()).collect::<Vec<_>>();
    // Only if nothing else changed: a change of offsets already says more than the order.
    if changes.is_empty() && order(a) != order(b) {
        let message = "lists its members in another order, each at its old offset".to_string();
        changes.push(change((Kind::Order, Class::Cosmetic), (None, None), message));
    }
    if changes.is_empty() && a.align != b.align {
        let number = |n: Option<u64>| n.map_or("none".to_string(), |n| n.to_string());
        let (was, is) = (number(a.align), number(b.align));
        let message = format!("alignment changed from {was} to {is}");
        changes.push(change((Kind::Alignment, Class::Cosmetic), (Some(was), Some(is)), message));
    }
}

/// The descriptor set of a block beside another: 0 where a text states none and a compiler did
/// (GL_KHR_vulkan_glsl, layout qualifiers).
fn set(block: SidedBlock<'_>, other: SidedBlock<'_>) -> Option<u32> {
    let is_compiled = other.side.language == Language::SpirV && other.layout.group.is_some();
    block.layout.group.or(is_compiled.then_some(0))
}

fn slot(what: &str, old: Option<u32>, new: Option<u32>, changes: &mut Vec<Change>) {
    let text = |n: Option<u32>| n.map(|n| n.to_string());
    let (class, message) = match (old, new) {
        (Some(was), Some(is)) if was != is => (
            Class::Breaking,
            format!("{what} changed from {was} to {is}: it now reads the buffer bound there"),
        ),
        (Some(was), None) => (
            Class::Breaking,
            format!("{what} {was} is no longer declared: the host must choose it"),
        ),
        (None, Some(is)) => {
            (Class::Compatible, format!("{what} {is} is now declared; before, the host chose it"))
        }
        (Some(_), Some(_)) | (None, None) => return,
    };
    changes.push(change((Kind::Slot, class), (text(old), text(new)), message));
}

fn count(old: &BlockLayout, new: &BlockLayout, changes: &mut Vec<Change>) {
    // A length without a number is any number of buffers, which is more than each.
    let (was, is) = (fixed_elements(&old.count), fixed_elements(&new.count));
    if was == is {
        return;
    }
    let fewer = match (was, is) {
        (Some(was), Some(is)) => is < was,
        (None, Some(_)) => true,
        (Some(_) | None, None) => false,
    };
    let class = if fewer { Class::Breaking } else { Class::Compatible };
    let text = |n: Option<u64>| n.map_or("any number of".to_string(), |n| n.to_string());
    let (was, is) = (text(was), text(is));
    let message = format!("is an array of {is} buffers, was of {was}");
    changes.push(change((Kind::Count, class), (Some(was), Some(is)), message));
}

fn names(old: &BlockLayout, new: &BlockLayout, changes: &mut Vec<Change>) {
    if old.name != new.name {
        let (was, is) = (shown_name(old), shown_name(new));
        let message = format!("block `{was}` was renamed to `{is}`");
        let values = (Some(was), Some(is));
        changes.push(change((Kind::BlockRenamed, Class::Cosmetic), values, message));
    }
    if old.instance != new.instance {
        let shown =
            |name: Option<&str>| name.map_or("no instance".into(), |name| format!("`{name}`"));
        let (was, is) = (old.instance.as_deref(), new.instance.as_deref());
        let message = format!("instance is {}, was {}", shown(is), shown(was));
        let values = (was.map(String::from), is.map(String::from));
        changes.push(change((Kind::Instance, Class::Cosmetic), values, message));
    }
}

/// Adds changes of members that move no byte: structure names, alignments, sizes set by `@size`.
fn below(
    old: &[MemberLayout],
    new: &[MemberLayout],
    parent: &str,
    changes: &[Change],
    found: &mut Vec<Change>,
) {
    // Made only if members changed places, which a search for each would make quadratic.
    let by_name: OnceCell<FxHashMap<&str, &MemberLayout>> = OnceCell::new();
    for (i, a) in old.iter().enumerate() {
        // Most members keep their index.
        let same = new.get(i).filter(|b| b.name == a.name);
        let other = || {
            let names = by_name.get_or_init(|| new.iter().map(|b| (&*b.name, b)).collect());
            names.get(&*a.name).copied()
        };
        let Some(b) = same.or_else(other) else { continue };
        let path =
            if parent.is_empty() { a.name.to_string() } else { format!("{parent}.{}", a.name) };
        if let (Type::Struct(x), Type::Struct(y)) = (a.ty.innermost(), b.ty.innermost()) {
            // A structure is reported once, by the first member that has it.
            let reported = x.name == y.name
                || found.iter().any(|change| {
                    change.kind == Kind::StructureRenamed
                        && (change.old.as_deref(), change.new.as_deref())
                            == (Some(&*x.name), Some(&*y.name))
                });
            if !reported {
                let message =
                    format!("structure `{}` of `{path}` was renamed to `{}`", x.name, y.name);
                found.push(Change {
                    path: path.clone(),
                    ..change(
                        (Kind::StructureRenamed, Class::Cosmetic),
                        (Some(x.name.to_string()), Some(y.name.to_string())),
                        message,
                    )
                });
            }
        }
        // Without another change only: then these numbers are the only trace of what was edited.
        if changes.is_empty() && (a.align, a.size) != (b.align, b.size) {
            let number = |n: Option<u64>| n.map_or("any number of".to_string(), |n| n.to_string());
            let (what, was, is) = match a.align == b.align {
                true => ("takes", number(a.size), number(b.size)),
                false => ("is aligned to", number(a.align), number(b.align)),
            };
            let message = format!("`{path}` {what} {is} bytes, before {was}, and no member moves");
            found.push(Change {
                path: path.clone(),
                ..change((Kind::Alignment, Class::Cosmetic), (Some(was), Some(is)), message)
            });
        }
        below(&a.members, &b.members, &path, changes, found);
    }
}
