//! What both drivers check before a job runs, and the messages of jobs that cannot be run.

use super::devices::Limits;
use crate::backend::{Failure, Grid, Job, Resource, ResourceKind};
use landfall_layout::source::Stage;

/// Fails if a resource is larger than the device supports, or a texture not as large as it says.
pub(super) fn check_resource(resource: &Resource, limits: &Limits) -> Result<(), Failure> {
    let name = &resource.name;
    let block = |what: &str, bytes: &[u8], limit| {
        exceeds(&format!("the {what} `{name}`"), bytes.len(), "bytes", limit)
    };
    match &resource.kind {
        ResourceKind::Uniform(bytes) => block("uniform block", bytes, limits.uniform_block_size),
        ResourceKind::Storage { bytes, .. } => {
            block("storage block", bytes, limits.storage_block_size)
        }
        ResourceKind::PushConstant(bytes) => {
            block("push constant block", bytes, limits.push_constant_size)
        }
        ResourceKind::Texture { width, height, texels } => {
            let side = (*width).max(*height) as usize;
            let what = format!("the texture `{name}`");
            exceeds(&what, side, "texels per side", limits.image_side)?;
            if texels.len() as u64 == u64::from(*width) * u64::from(*height) {
                return Ok(());
            }
            let given = texels.len();
            let message = format!("{what} is {width} by {height} texels, but {given} were given");
            Err(Failure::refused(message, ""))
        }
        ResourceKind::Sampler | ResourceKind::Loose(_) => Ok(()),
    }
}

/// Fails if a grid is larger than the device supports.
pub(super) fn check_grid(grid: Grid, limits: &Limits) -> Result<(), Failure> {
    let image =
        |what: &str, side: u32| exceeds(what, side as usize, "pixels per side", limits.image_side);
    match grid {
        Grid::Groups(groups) => groups.into_iter().try_for_each(|groups| {
            let unit = "workgroups in one dimension";
            exceeds("the dispatch", groups as usize, unit, limits.workgroups)
        }),
        Grid::Image { width, height, .. } => image("the image", width.max(height)),
        Grid::Points { count, .. } => image("the row of points", count),
    }
}

/// Fails if the job lacks a stage that its grid needs.
pub(super) fn check_stages(job: &Job) -> Result<(), Failure> {
    let needed: &[Stage] = match job.grid {
        Grid::Groups(_) => &[Stage::Compute],
        Grid::Image { .. } => &[Stage::Fragment],
        Grid::Points { .. } => &[Stage::Vertex, Stage::Fragment],
    };
    let lacks = |stage: &&Stage| job.stages.iter().all(|code| code.stage != **stage);
    match needed.iter().find(lacks) {
        Some(stage) => Err(Failure::refused(format!("the job has no {} stage", stage.name()), "")),
        None => Ok(()),
    }
}

/// Fails if a size exceeds the device's limit, and names both.
fn exceeds(what: &str, size: usize, unit: &str, limit: Option<u64>) -> Result<(), Failure> {
    match limit {
        Some(limit) if size as u64 > limit => {
            let message = format!("{what} has {size} {unit}, but this device supports {limit}");
            Err(Failure::refused(message, ""))
        }
        Some(_) | None => Ok(()),
    }
}

/// Returns the failure of a job that binds two resources in one place.
pub(super) fn twice(place: &str) -> Failure {
    Failure::refused(format!("{place} is bound twice in one job"), "")
}

/// Returns the failure of a job without a resource that the shader reads.
#[cfg(feature = "gl")]
pub(super) fn unbound(what: &str, name: &str) -> Failure {
    let message = format!("the shader reads the {what} `{name}`, but nothing is bound to it");
    Failure::refused(message, "")
}
