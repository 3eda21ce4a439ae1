//! `rust-mirror` and `rust-mirror-unknown`: hand-written `#[repr(C)]` structures compared with the
//! blocks they mirror.
//!
//! [`file`] parses the Rust text, `types` lays it out as rustc does, `compare` and `fit` compare it
//! with [`layout`](mod@landfall_layout::layout)'s result.

mod compare;
mod file;
mod fit;
mod items;
mod known;
mod library;
mod mirrored;
mod plan;
mod reach;
mod rust_type;
mod suggest;
mod syntax;
mod target;
mod types;

use std::rc::Rc;

use rustc_hash::FxHashSet;

use super::definition::Subject;
use super::settings::Settings;
use super::settings::{RustFile, RustMirror};
use super::show::{bytes, full_listing};
use compare::{Difference, ShaderSide, compare};
use file::{Declarations, Structure};
use landfall_layout::error::Error;
use landfall_layout::finding::{Finding, Place};
use landfall_layout::text::edit_distance::nearest;
use library::MirrorWriter;
pub use mirrored::{MirroredField, MirroredStructure, mirrored};
use plan::MirrorEnd;
use rust_type::{Shape, StructureLayout, UnknownLayout};
use target::{Target, targets};
use types::Types;

/// The codes of the lints, whose texts are in `mirror_lints`.
const MIRROR: &str = "rust-mirror";
const UNKNOWN: &str = "rust-mirror-unknown";

/// Checks that a Rust file can be parsed for mirrors.
///
/// # Errors
/// The text is not valid Rust, with line and column.
pub fn readable(file: &RustFile) -> Result<(), Error> {
    file::read(file).map(|_| ())
}

/// Returns the shaders, as globs, and the blocks that comments in Rust files name.
pub(super) fn named(settings: &Settings) -> Vec<(String, String)> {
    let files = settings.rust_files.iter();
    let comments = files.filter_map(|file| file::read(file).ok()).flat_map(|read| read.comments);
    comments.flat_map(|comment| comment.blocks).collect()
}

/// The layout of a Rust structure by rustc's rules.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RustLayout {
    /// The size in bytes.
    pub size: u64,
    /// The alignment in bytes.
    pub align: u64,
    /// The fields with their offsets, in the order of the text.
    pub fields: Vec<(String, u64)>,
}

/// Returns the layout of a `#[repr(C)]` structure in a Rust file.
///
/// # Errors
/// The file is not valid Rust, has no such structure, or contains a type of unknown layout.
pub fn laid_out(file: &RustFile, structure: &str) -> Result<RustLayout, Error> {
    let declarations = file::read(file)?;
    let refused = |cause: String| Error::new(&file.path, cause);
    let index = declarations.structures.iter().position(|s| s.name == structure);
    let index = index.ok_or_else(|| refused(format!("has no structure `{structure}`")))?;
    let ty = Types::new(&declarations, MirrorWriter::Memory).structure(index);
    let ty = ty.map_err(|UnknownLayout(cause)| refused(format!("has no known layout: {cause}")))?;
    let fields = match &ty.shape {
        Shape::Struct(laid) => laid.fields.iter().map(|f| (f.name.clone(), f.offset)).collect(),
        Shape::Scalar { .. } | Shape::Array { .. } => Vec::new(),
    };
    Ok(RustLayout { size: ty.size, align: ty.align, fields })
}

/// The findings of the lint of that code.
pub(super) fn of_code(subjects: &[Subject<'_>], settings: &Settings, code: &str) -> Vec<Finding> {
    let mut findings: Vec<Finding> = Vec::new();
    let mut said = FxHashSet::default();
    for file in &settings.rust_files {
        let mine =
            settings.rust_mirrors.iter().filter(|mirror| same_file(&mirror.file, &file.path));
        let mine: Vec<&RustMirror> = mine.collect();
        // Most files name no mirror, and are not parsed.
        if mine.is_empty() && !file.text.contains("landfall: mirror") {
            continue;
        }
        let found = match file::read(file) {
            Ok(declarations) => of_file(subjects, &declarations, &mine),
            Err(error) => vec![Finding::at(
                UNKNOWN,
                file.path.as_str(),
                Place::file(&file.path),
                format!("`{}` {}", error.path, error.message),
            )],
        };
        // Several shaders with the same block give the same finding.
        let mut new = |finding: &Finding| {
            finding.code == code && said.insert((finding.place().clone(), finding.message.clone()))
        };
        findings.extend(found.into_iter().filter(|finding| new(finding)));
    }
    findings
}

/// `src/light.rs` and `./src/light.rs` are the same file.
fn same_file(named: &str, path: &str) -> bool {
    let plain = |path: &str| path.trim_start_matches("./").replace('\\', "/");
    let (named, path) = (plain(named), plain(path));
    path == named || path.strip_suffix(&named).is_some_and(|rest| rest.ends_with('/'))
}

/// The mirrors of one file, those of the configuration first.
fn of_file(
    subjects: &[Subject<'_>],
    declarations: &Declarations,
    configured: &[&RustMirror],
) -> Vec<Finding> {
    let mut findings = Vec::new();
    for mirror in configured {
        findings.extend(of_mirror(subjects, declarations, mirror));
    }
    for comment in &declarations.comments {
        let Some(structure) = &comment.structure else {
            let message = "mirror comment without a structure below it".to_string();
            let finding = Finding::at(UNKNOWN, "mirror", comment.place.clone(), message);
            findings.push(finding.with_help("put it right above the structure's attributes"));
            continue;
        };
        for (shader, block) in &comment.blocks {
            let mirror = RustMirror {
                structure: structure.clone(),
                shader: shader.clone(),
                block: block.clone(),
                place: comment.place.clone(),
                ..RustMirror::default()
            };
            findings.extend(of_mirror(subjects, declarations, &mirror));
        }
    }
    findings
}

fn of_mirror(
    subjects: &[Subject<'_>],
    declarations: &Declarations,
    mirror: &RustMirror,
) -> Vec<Finding> {
    let structures = &declarations.structures;
    let Some(index) = structures.iter().position(|s| s.name == mirror.structure) else {
        let message =
            format!("there is no structure `{}` to mirror `{}`", mirror.structure, mirror.block);
        let finding = Finding::at(MIRROR, &*mirror.structure, mirror.place.clone(), message);
        let near = nearest(&mirror.structure, structures.iter().map(|s| s.name.as_str()));
        return vec![match near {
            Some(near) => finding.with_help(format!("there is a structure `{near}`")),
            None => finding,
        }];
    };
    let own = &structures[index];
    let (targets, shaders) = targets(subjects, mirror);
    if targets.is_empty() {
        // The named shader may not be among the checked ones.
        if shaders == 0 && !mirror.shader.is_empty() {
            return Vec::new();
        }
        let message = format!(
            "`{}` mirrors `{}`, but none of the {shaders} shaders checked has such a block",
            own.name, mirror.block,
        );
        let finding = Finding::at(UNKNOWN, &*own.name, mirror.place.clone(), message);
        return vec![finding.with_help("name the block, its variable or a structure in it")];
    }
    let mut findings: Vec<Finding> = Vec::new();
    for target in &targets {
        // Which library writes the structure depends on the block.
        let writer = MirrorWriter::new(own, target.block);
        if let Some(finding) = unordered(declarations, index, writer) {
            findings.push(finding);
        }
        let laid = match Types::new(declarations, writer).structure(index) {
            Ok(ty) => ty,
            Err(UnknownLayout(cause)) => {
                let message =
                    format!("`{}` cannot be compared with `{}`: {cause}", own.name, mirror.block);
                let finding = Finding::at(UNKNOWN, &*own.name, own.place.clone(), message);
                findings.push(finding.with_help(unknown_help(writer)));
                return findings;
            }
        };
        let Shape::Struct(fields) = &laid.shape else { return findings };
        findings.extend(compared(declarations, target, mirror, fields, laid.size));
    }
    findings
}

fn unknown_help(writer: MirrorWriter) -> &'static str {
    match writer {
        MirrorWriter::Memory => {
            "write the type as numbers and arrays, or declare it in the same file"
        }
        MirrorWriter::Encase => {
            "use `f32`, `i32`, `u32`, vectors and matrices of them, arrays, and structures of the \
             same file that derive `ShaderType`"
        }
        MirrorWriter::Std140 | MirrorWriter::Std430 => {
            "use numbers, vectors and matrices, and structures of the same file that derive the \
             same trait"
        }
    }
}

/// Returns the findings of a structure against one block or structure.
fn compared(
    declarations: &Declarations,
    target: &Target<'_, '_>,
    mirror: &RustMirror,
    fields: &Rc<StructureLayout>,
    laid_size: u64,
) -> Vec<Finding> {
    // Elements are as large as their stride; what is uploaded to a block may be longer.
    let end = match (target.stride, target.size) {
        (Some(stride), _) => MirrorEnd::Exactly(stride),
        (None, Some(size)) => MirrorEnd::AtLeast(size),
        (None, None) => MirrorEnd::Free,
    };
    let against = ShaderSide {
        members: target.members,
        rules: target.block.rules,
        space: target.block.space,
        language: target.subject.shader.language,
        aliases: &mirror.aliases,
        end,
    };
    let held = compare(fields, &against);
    let complete = held.differences.is_empty();
    let mut findings: Vec<Finding> = Vec::new();
    for one in held.differences {
        let first = findings.is_empty();
        findings.push(reported(declarations, target, fields.writer, one, first));
    }
    for nested in nested_structures(fields) {
        findings.extend(unordered(declarations, nested, fields.writer));
    }
    // If every field is in place, only the size can be wrong.
    if complete {
        findings.extend(size(declarations, target, fields, laid_size, held.tail));
    }
    findings
}

/// Returns the finding of a structure without `repr(C)`, whose field order rustc chooses.
fn unordered(declarations: &Declarations, index: usize, writer: MirrorWriter) -> Option<Finding> {
    let structure: &Structure = &declarations.structures[index];
    let repr = structure.repr;
    // A library writes field by field, whatever their order in memory.
    if writer.library().is_some() {
        return None;
    }
    // `repr(transparent)` has the layout of its only field.
    if repr.c || (repr.transparent && structure.fields.len() == 1) {
        return None;
    }
    let message = format!("`{}` is a mirror without `#[repr(C)]`", structure.name);
    Some(
        Finding::at(MIRROR, &*structure.name, structure.place.clone(), message)
            .with_note("without it rustc may put the fields in any order")
            .with_help("put `#[repr(C)]` before it"),
    )
}

/// The structures of the file that a structure is made of.
fn nested_structures(laid: &StructureLayout) -> Vec<usize> {
    let mut found = Vec::new();
    for field in &laid.fields {
        let mut ty = &field.ty;
        while let Shape::Array { element, .. } = &ty.shape {
            ty = element;
        }
        if let Shape::Struct(inner) = &ty.shape {
            found.push(inner.index);
            found.extend(nested_structures(inner));
        }
        // Shared structures occur repeatedly; duplicates of findings are dropped anyway.
        if found.len() > 1_000 {
            break;
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// `first` shows the layout, once for all findings of a structure.
fn reported(
    declarations: &Declarations,
    target: &Target<'_, '_>,
    writer: MirrorWriter,
    one: Difference,
    first: bool,
) -> Finding {
    let structure = &declarations.structures[one.structure];
    let field = one.field.and_then(|field| structure.fields.get(field));
    let place = field.map_or(&structure.place, |field| &field.place).clone();
    let about = match field {
        Some(field) => format!("{}.{}", structure.name, field.name),
        None => structure.name.clone(),
    };
    let mut finding = Finding::at(MIRROR, about, place, one.message);
    if let Some(field) = field {
        finding = finding.with_text(format!("`{}`", field.written));
    }
    if let Some(span) = one.member {
        let place = Place::new(&target.subject.shader.files, span);
        finding = finding.with_label(place, one.member_text);
    }
    finding.notes = one.notes;
    if first {
        finding.listing = full_listing(target.subject.shader, target.block);
    }
    Finding { help: one.help, ..finding.with_note(compared_with(target, writer)) }
}

fn compared_with(target: &Target<'_, '_>, writer: MirrorWriter) -> String {
    let with = format!("compared with `{}` of `{}`", target.name, target.subject.shader.path);
    match writer.library() {
        Some(library) => format!("{with}, as {library} writes it"),
        None => with,
    }
}

/// Returns the finding of a structure with every field in place that is shorter than the bytes
/// read, or whose size is not the array stride.
fn size(
    declarations: &Declarations,
    target: &Target<'_, '_>,
    laid: &Rc<StructureLayout>,
    size: u64,
    tail: Option<String>,
) -> Option<Finding> {
    let name = &laid.name;
    let (message, needed) = match (target.stride, target.size) {
        (Some(stride), _) if size != stride => (
            format!("`{name}` is {}, elements in the shader are {stride} apart", bytes(size)),
            stride,
        ),
        (None, Some(needed)) if size < needed => {
            (format!("`{name}` is {}, `{}` is {needed}", bytes(size), target.name), needed)
        }
        (_, _) => return None,
    };
    let structure = &declarations.structures[laid.index];
    let place = Place::new(&target.subject.shader.files, target.span);
    let help = tail.unwrap_or_else(|| match size.checked_sub(needed) {
        Some(less) => format!("make it {} shorter", bytes(less)),
        None => format!("make it {} longer", bytes(needed - size)),
    });
    let note = compared_with(target, laid.writer);
    let finding = Finding::at(MIRROR, name.as_str(), structure.place.clone(), message)
        .with_text(bytes(size))
        .with_label(place, bytes(needed))
        .with_note(note)
        .with_help(help);
    Some(Finding { listing: full_listing(target.subject.shader, target.block), ..finding })
}
