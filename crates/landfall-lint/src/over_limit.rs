//! `over-limit`: blocks larger or more numerous than a target guarantees.

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use super::settings::Target;
use super::show::{bytes, counted, listing, numbered, place};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::layout::BlockLayout;
pub use landfall_layout::layout::measure::{elements, fixed};
use landfall_layout::shape::{AddressSpace, Type};
use landfall_layout::source::{Language, Stage};

pub(super) const LINT: Lint = Lint {
    code: "over-limit",
    level: Level::Deny,
    what: "a block's size, or a stage's number of blocks or loose uniforms, above what a \
           configured target guarantees",
    why: "The shader links on the machine it was written on and fails on another: the \
          specifications guarantee 16 KiB per uniform block in OpenGL 3.3, OpenGL ES 3.0, WebGL 2 \
          and Vulkan, 64 KiB in WebGPU, 128 MiB per storage buffer in Vulkan and WebGPU, and 12 \
          uniform blocks per stage. Nothing is reported without `targets` in the configuration or \
          `--target`, because no limit holds everywhere. Sizes are those of the layout, a \
          runtime-sized array at the end counted with one element. Blocks of a WGSL module are \
          counted only if it has one entry point, and in Vulkan and WebGPU only those whose names \
          the shader uses: what an entry point does not use takes no binding there.",
    example: "#version 330 core\n\
              // Checked with `--target gl33`.\n\
              layout(std140) uniform Bones { mat4 pose[257]; } u_bones;\n\
              void main() { gl_Position = u_bones.pose[0][0]; }\n",
    fix: "Shorten the array, split the block, or move it to a storage buffer or texture; if every \
          machine you ship to has a higher limit, remove the target from `targets`.",
    check: Check::Shader(check),
};

/// The most blocks of a stage that are counted; each is searched for in the text.
const MAX_COUNTED: usize = 256;

/// The guarantees of a target: the minima in its tables of implementation-dependent values.
struct TargetLimits {
    /// The size in bytes of a uniform block, and of a storage block if supported.
    uniform: u64,
    storage: Option<u64>,
    /// The number of blocks in one stage.
    uniform_blocks: u64,
    storage_blocks: Option<u64>,
    /// The section of the specification, and the names of the limits in it.
    cite: &'static str,
    names: Names,
}

struct Names {
    uniform: &'static str,
    storage: &'static str,
    uniform_blocks: &'static str,
    storage_blocks: &'static str,
}

const GL_NAMES: Names = Names {
    uniform: "MAX_UNIFORM_BLOCK_SIZE",
    storage: "",
    uniform_blocks: "MAX_*_UNIFORM_BLOCKS",
    storage_blocks: "",
};

// The combined limits need no check of their own: 36 blocks a program in OpenGL 3.3 are three
// stages of 12, 24 in OpenGL ES 3.0 two of 12, and the combined uniform components are defined as
// what the stages and their blocks may have together.
fn limits(target: Target) -> TargetLimits {
    match target {
        // OpenGL 3.3 core, tables 6.43 to 6.48: implementation-dependent values.
        Target::Gl33 => TargetLimits {
            uniform: 16 << 10,
            storage: None,
            uniform_blocks: 12,
            storage_blocks: None,
            cite: "OpenGL 3.3 §6.2",
            names: GL_NAMES,
        },
        // OpenGL ES 3.0, tables 6.31 to 6.35; WebGL 2 promises what OpenGL ES 3.0 does.
        Target::Gles30 | Target::WebGl2 => TargetLimits {
            uniform: 16 << 10,
            storage: None,
            uniform_blocks: 12,
            storage_blocks: None,
            cite: "OpenGL ES 3.0 §6.2",
            names: GL_NAMES,
        },
        // WebGPU §3.6.2: default limits, which every adapter meets.
        Target::WebGpu => TargetLimits {
            uniform: 64 << 10,
            storage: Some(128 << 20),
            uniform_blocks: 12,
            storage_blocks: Some(8),
            cite: "WebGPU §3.6.2",
            names: Names {
                uniform: "maxUniformBufferBindingSize",
                storage: "maxStorageBufferBindingSize",
                uniform_blocks: "maxUniformBuffersPerShaderStage",
                storage_blocks: "maxStorageBuffersPerShaderStage",
            },
        },
        // Vulkan 1.0, Required Limits.
        Target::Vulkan => TargetLimits {
            uniform: 16 << 10,
            storage: Some(128 << 20),
            uniform_blocks: 12,
            storage_blocks: Some(4),
            cite: "Vulkan 1.0, Required Limits",
            names: Names {
                uniform: "maxUniformBufferRange",
                storage: "maxStorageBufferRange",
                uniform_blocks: "maxPerStageDescriptorUniformBuffers",
                storage_blocks: "maxPerStageDescriptorStorageBuffers",
            },
        },
    }
}

/// Returns the number of components that loose uniforms of a stage may have; `None` in Vulkan and
/// WebGPU, which have no loose uniforms.
fn loose_components(target: Target, stage: Stage) -> Option<u64> {
    let stages: &[(Stage, u64)] = match target {
        // OpenGL 3.3: MAX_VERTEX_, MAX_GEOMETRY_ and MAX_FRAGMENT_UNIFORM_COMPONENTS.
        Target::Gl33 => &[(Stage::Vertex, 1024), (Stage::Geometry, 1024), (Stage::Fragment, 1024)],
        // OpenGL ES 3.0: 256 vectors and 224 vectors.
        Target::Gles30 | Target::WebGl2 => &[(Stage::Vertex, 1024), (Stage::Fragment, 896)],
        Target::WebGpu | Target::Vulkan => &[],
    };
    stages.iter().find(|row| row.0 == stage).map(|row| row.1)
}

fn title(target: Target) -> &'static str {
    match target {
        Target::Gl33 => "OpenGL 3.3",
        Target::Gles30 => "OpenGL ES 3.0",
        Target::WebGl2 => "WebGL 2",
        Target::WebGpu => "WebGPU",
        Target::Vulkan => "Vulkan",
    }
}

fn check(subject: &Subject<'_>, settings: &Settings) -> Vec<Finding> {
    let mut found = Vec::new();
    for block in &subject.shader.blocks {
        if !block.gathered {
            found.extend(too_large(subject, block, settings));
        }
    }
    for &target in &settings.targets {
        found.extend(too_many(subject, AddressSpace::Uniform, target));
        found.extend(too_many(subject, AddressSpace::Storage, target));
        found.extend(too_loose(subject, target));
    }
    found
}

/// Returns one finding per block: about the smallest limit it exceeds, with the other targets in a
/// note.
fn too_large(subject: &Subject<'_>, block: &BlockLayout, settings: &Settings) -> Option<Finding> {
    let size = block.size?;
    let over = settings.targets.iter().filter_map(|&target| {
        let limits = limits(target);
        let (limit, name) = match block.space {
            AddressSpace::Uniform => (limits.uniform, limits.names.uniform),
            AddressSpace::Storage => (limits.storage?, limits.names.storage),
            _ => return None,
        };
        (size > limit).then_some((limit, target, name, limits.cite))
    });
    let mut over: Vec<_> = over.collect();
    over.sort_by_key(|row| row.0);
    let &(limit, target, _, _) = over.first()?;
    let message = format!(
        "block `{}` is {}, but {} guarantees only {} per {} block",
        block.name,
        bytes(size),
        title(target),
        bytes(limit),
        block.space.name(),
    );
    let at = place(subject, block.span);
    let mut finding = Finding::at(LINT.code, block.name.as_ref(), at, message)
        .with_text(format!("{} more than guaranteed", bytes(size - limit)))
        .with_help(shorter(block, limit));
    for (limit, target, name, cite) in over {
        finding =
            finding.with_note(format!("{}: {name} is at least {limit} ({cite})", title(target)));
    }
    finding.listing = listing(subject.shader, block);
    Some(finding)
}

/// Returns the help: the array to shorten, if shortening one is enough.
fn shorter(block: &BlockLayout, limit: u64) -> String {
    let excess = block.size.unwrap_or(0).saturating_sub(limit);
    // The array that takes up the most bytes, of those that are long enough.
    let arrays = block.members.iter().filter_map(|member| {
        let len = fixed(member.dims.first()?)?;
        let stride = *member.strides.first()?;
        let fewer = excess.div_ceil(stride.max(1));
        (fewer < len).then_some((stride * len, len - fewer, member))
    });
    match arrays.max_by_key(|(size, ..)| *size) {
        Some((_, most, member)) => format!(
            "make `{}` an array of at most {}, or split the block",
            member.name,
            numbered(most, "element")
        ),
        None => "split the block, or move part of it to a storage buffer or texture".to_string(),
    }
}

fn too_many(subject: &Subject<'_>, space: AddressSpace, target: Target) -> Option<Finding> {
    let limits = limits(target);
    let (limit, name) = match space {
        AddressSpace::Uniform => (limits.uniform_blocks, limits.names.uniform_blocks),
        AddressSpace::Storage => (limits.storage_blocks?, limits.names.storage_blocks),
        _ => return None,
    };
    let stage = one_stage(subject)?;
    let mut count = 0u64;
    let mut first_over = None;
    let is_meant = |block: &&BlockLayout| block.space == space && !block.gathered;
    let declared: Vec<&BlockLayout> =
        subject.shader.blocks.iter().filter(is_meant).take(MAX_COUNTED).collect();
    // Names are searched for only where all declared blocks together exceed the limit.
    let all = declared.iter().fold(0u64, |sum, b| sum.saturating_add(elements(&b.count)));
    if all <= limit {
        return None;
    }
    for block in declared {
        if !takes_binding(subject, block, target) {
            continue;
        }
        count = count.saturating_add(elements(&block.count));
        if count > limit && first_over.is_none() {
            first_over = Some(block);
        }
    }
    let block = first_over?;
    let message = format!(
        "{stage} has {}, but {} guarantees only {limit}",
        counted(count as usize, &format!("{} block", space.name())),
        title(target),
    );
    let about = format!("{} blocks", space.name());
    Some(
        Finding::at(LINT.code, about, place(subject, block.span), message)
            .with_text("the first one past the limit")
            .with_note(format!("{}: {name} is at least {limit} ({})", title(target), limits.cite))
            .with_help(format!("join blocks that are uploaded together, down to {limit}")),
    )
}

/// Returns the stage in messages, if all blocks of the shader belong to one.
fn one_stage(subject: &Subject<'_>) -> Option<String> {
    match subject.shader.language {
        Language::Glsl | Language::SpirV => {
            Some(subject.shader.stage.map_or("the stage".to_string(), |stage| {
                format!("the {} stage", stage.name().replace('_', " "))
            }))
        }
        Language::Wgsl => {
            // The words may be in comments, too: then the blocks are not counted.
            let attributes = ["@vertex", "@fragment", "@compute"];
            let text = &subject.source.text;
            let entries: usize = attributes.iter().map(|word| text.matches(word).count()).sum();
            (entries == 1).then(|| "the entry point".to_string())
        }
    }
}

/// Returns whether a block counts: in OpenGL every declared std140 or shared block is active
/// (OpenGL 3.3 §2.11.4); elsewhere only blocks that an entry point uses take a binding.
fn takes_binding(subject: &Subject<'_>, block: &BlockLayout, target: Target) -> bool {
    match target {
        Target::Gl33 | Target::Gles30 | Target::WebGl2 => true,
        Target::WebGpu | Target::Vulkan => {
            // The first occurrence is the declaration.
            let again = |name: &str| {
                subject
                    .shader
                    .files
                    .iter()
                    .flat_map(|file| words(&file.text, name))
                    .nth(1)
                    .is_some()
            };
            // Members of a block without an instance are called by their own names.
            match &block.instance {
                Some(instance) => again(instance),
                None => block.members.iter().any(|member| again(&member.name)),
            }
        }
    }
}

/// Returns the positions of a name as a whole word.
fn words<'a>(text: &'a str, name: &'a str) -> impl Iterator<Item = usize> + 'a {
    let part = |sign: Option<char>| sign.is_some_and(|c| c.is_alphanumeric() || c == '_');
    text.match_indices(name).map(|(at, _)| at).filter(move |&at| {
        !part(text[..at].chars().next_back()) && !part(text[at + name.len()..].chars().next())
    })
}

fn too_loose(subject: &Subject<'_>, target: Target) -> Option<Finding> {
    let shader = subject.shader;
    let stage = shader.stage?;
    let limit = loose_components(target, stage)?;
    let block = shader.blocks.iter().find(|block| block.gathered)?;
    let mut sum = 0u64;
    let mut first_over = None;
    for leaf in &block.leaves {
        // Components have 32 bits; a double counts as two.
        let one = match &leaf.ty {
            Type::Scalar(s) | Type::Atomic(s) => u64::from(s.width.div_ceil(4)),
            Type::Vector { scalar, rows } => u64::from(scalar.width.div_ceil(4)) * u64::from(*rows),
            Type::Matrix { scalar, columns, rows } => {
                u64::from(scalar.width.div_ceil(4)) * u64::from(*columns) * u64::from(*rows)
            }
            Type::Address(_) | Type::Struct(_) | Type::Array { .. } => 0,
        };
        sum = sum.saturating_add(one.saturating_mul(elements(&leaf.dims)));
        if sum > limit && first_over.is_none() {
            first_over = Some(leaf);
        }
    }
    let leaf = first_over?;
    let message = format!(
        "the {} stage has loose uniforms of {sum} components, but {} guarantees only {limit}",
        stage.name(),
        title(target),
    );
    let cite = limits(target).cite;
    Some(
        Finding::at(LINT.code, "loose uniforms", place(subject, leaf.span), message)
            .with_text("the first one past the limit")
            .with_note(format!(
                "{}: MAX_{}_UNIFORM_COMPONENTS is at least {limit} ({cite})",
                title(target),
                stage.name().to_uppercase(),
            ))
            .with_note("uniforms the linker finds unused are not counted by the driver")
            .with_help("move the largest arrays into a uniform block"),
    )
}
