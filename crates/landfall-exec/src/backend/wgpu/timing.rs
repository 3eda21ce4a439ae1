//! Device time of a pass by two timestamps.
//!
//! Used by [`run`](super::run) for benches; the pass alone is timed, without upload and read-back.

use std::time::Duration;

use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, CommandEncoder, ComputePassTimestampWrites, Features,
    MapMode, QuerySet, QuerySetDescriptor, QueryType, RenderPassTimestampWrites,
};

use super::device::OpenDevice;

/// Size of two timestamps of eight bytes each.
const SIZE: u64 = 16;

/// The timestamps of one job.
pub(super) struct Timestamps {
    set: QuerySet,
    resolved: Buffer,
    back: Buffer,
    /// Nanoseconds per tick.
    period: f64,
}

impl Timestamps {
    /// Creates the query set; `None` if the device has no timestamps.
    pub(super) fn new(open: &OpenDevice) -> Option<Timestamps> {
        if !open.device.features().contains(Features::TIMESTAMP_QUERY) {
            return None;
        }
        let room = |usage| {
            let descriptor =
                BufferDescriptor { label: None, size: SIZE, usage, mapped_at_creation: false };
            open.device.create_buffer(&descriptor)
        };
        let descriptor = QuerySetDescriptor { label: None, ty: QueryType::Timestamp, count: 2 };
        Some(Timestamps {
            set: open.device.create_query_set(&descriptor),
            resolved: room(BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            back: room(BufferUsages::COPY_DST | BufferUsages::MAP_READ),
            period: f64::from(open.queue.get_timestamp_period()),
        })
    }

    pub(super) fn render(&self) -> RenderPassTimestampWrites<'_> {
        RenderPassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    pub(super) fn compute(&self) -> ComputePassTimestampWrites<'_> {
        ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    /// Records the copy of the timestamps for read-back.
    pub(super) fn record(&self, encoder: &mut CommandEncoder) {
        encoder.resolve_query_set(&self.set, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.back, 0, SIZE);
    }

    /// Maps the buffer; it is readable when the job is done.
    pub(super) fn map(&self) {
        // An error shows when the range is read.
        self.back.map_async(MapMode::Read, .., |_| {});
    }

    /// Returns the duration of the pass; `None` if the device counts backwards or returns nothing.
    pub(super) fn elapsed(&self) -> Option<Duration> {
        let bytes = self.back.get_mapped_range(..).ok()?;
        let count = |at: usize| {
            bytes.get(at..at + 8).and_then(|b| b.try_into().ok()).map(u64::from_le_bytes)
        };
        let counts = count(8)?.checked_sub(count(0)?)?;
        Some(Duration::from_nanos((counts as f64 * self.period) as u64))
    }
}
