//! `push-constant-limit`: push constants past the bytes that Vulkan guarantees.

use super::definition::{Check, Lint, Subject};
use super::settings::{Settings, Target};
use super::show::{bytes, listing, place};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::shape::AddressSpace;
use landfall_layout::source::Language;

pub(super) const LINT: Lint = Lint {
    code: "push-constant-limit",
    level: Level::Deny,
    what: "push constants that end past byte 128, or WGSL's immediate data past byte 64",
    why: "Vulkan guarantees 128 bytes of push constants (maxPushConstantsSize, Required Limits) \
          for all stages of a pipeline together; many desktop drivers have 256, so that the \
          pipeline layout is valid there and invalid elsewhere. A later start of a stage's range \
          does not help: the range has to end by byte 128. Vulkan 1.4 guarantees 256; programs \
          that require it can allow this lint. WebGPU guarantees 64 bytes of `var<immediate>` \
          (maxImmediateSize); that limit holds for WGSL unless `vulkan` is a target and `webgpu` \
          is not.",
    example: "#version 450\n\
              layout(push_constant) uniform Push { mat4 model; mat4 view; vec4 tint; } pc;\n\
              layout(location = 0) out vec4 color;\n\
              void main() { color = pc.tint; }\n",
    fix: "Move data that changes less often than every draw into a uniform block, or multiply \
          matrices before pushing them.",
    check: Check::Shader(check),
};

/// The guarantee of an API.
struct Guarantee {
    bytes: u64,
    api: &'static str,
    what: &'static str,
    note: &'static str,
}

/// Vulkan 1.0 to 1.3, Required Limits: maxPushConstantsSize.
const VULKAN: Guarantee = Guarantee {
    bytes: 128,
    api: "Vulkan",
    what: "push constants",
    note: "Vulkan 1.0 to 1.3: maxPushConstantsSize is at least 128; 256 in 1.4",
};

/// WebGPU §3.6.2, default limits: maxImmediateSize.
const WEBGPU: Guarantee = Guarantee {
    bytes: 64,
    api: "WebGPU",
    what: "immediate data",
    note: "WebGPU: maxImmediateSize is at least 64",
};

fn check(subject: &Subject<'_>, settings: &Settings) -> Vec<Finding> {
    let has = |target| settings.targets.contains(&target);
    let limit = match subject.shader.language {
        Language::Wgsl if has(Target::WebGpu) || !has(Target::Vulkan) => WEBGPU,
        Language::Wgsl | Language::Glsl | Language::SpirV => VULKAN,
    };
    let blocks = subject.shader.blocks.iter();
    let pushed = blocks.filter(|block| block.space == AddressSpace::PushConstant);
    let over = pushed.filter_map(|block| {
        // The range a pipeline declares need not cover the padding behind the last member.
        let end = block.data_size.filter(|&end| end > limit.bytes)?;
        let message = format!(
            "{} `{}` end at byte {end}, but {} guarantees only {}",
            limit.what,
            block.name,
            limit.api,
            bytes(limit.bytes)
        );
        let at = place(subject, block.span);
        let mut finding = Finding::at(LINT.code, block.name.as_ref(), at, message)
            .with_text(format!("{} too many", bytes(end - limit.bytes)))
            .with_note(limit.note);
        let past = block.members.iter().find(|member| {
            let end = member
                .offset
                .map(|offset| offset + landfall_layout::layout::measure::reach(member));
            end > Some(limit.bytes)
        });
        if let Some(member) = past {
            let end = member.offset.unwrap_or(0) + landfall_layout::layout::measure::reach(member);
            let text = format!("the first member past it: it ends at byte {end}");
            finding = finding.with_label(place(subject, member.span), text).with_help(format!(
                "move `{}` and what follows it into a uniform block",
                member.name
            ));
        }
        finding.listing = listing(subject.shader, block);
        Some(finding)
    });
    over.collect()
}
