//! Stamps of files: metadata of the file system by which a check tells, without reading it, that a
//! file is unchanged.
//!
//! A stamp holds only if both times of the file lie well before the check that read it, as git
//! requires of its index: a change within the granularity of the clock could leave them as they
//! are. The time of the last change of the inode is part of it, since programs set the time of
//! modification at will. Systems without that time have no stamps, so their files are hashed.

use std::fs::{self, Metadata};
use std::path::Path;
use std::time::{Duration, SystemTime};

use serde::{Deserialize, Serialize};

/// The coarsest granularity of file times that is in use: that of FAT.
const GRANULARITY: Duration = Duration::from_secs(2);

/// Size, device, inode, and the times of modification and of change in seconds and nanoseconds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Stamp([i64; 7]);

impl Stamp {
    /// The stamp of a regular file; `None` if there is none, or none on this system.
    pub fn from_path(path: impl AsRef<Path>) -> Option<Stamp> {
        Stamp::from_metadata(&fs::metadata(path).ok()?)
    }

    fn from_metadata(found: &Metadata) -> Option<Stamp> {
        if found.is_file() { fields(found).map(Stamp) } else { None }
    }

    /// The device and inode number.
    pub fn node(&self) -> (u64, u64) {
        (self.0[1].cast_unsigned(), self.0[2].cast_unsigned())
    }

    /// The stamp of a file, no link, whose content was the same from before `began` until now.
    pub fn settled(path: impl AsRef<Path>, began: SystemTime) -> Option<Stamp> {
        let limit = began.checked_sub(GRANULARITY)?.duration_since(SystemTime::UNIX_EPOCH).ok()?;
        let limit = (i64::try_from(limit.as_secs()).ok()?, i64::from(limit.subsec_nanos()));
        Stamp::from_metadata(&fs::symlink_metadata(path).ok()?).filter(|stamp| {
            let [.., modified, modified_nanos, changed, changed_nanos] = stamp.0;
            (modified, modified_nanos) < limit && (changed, changed_nanos) < limit
        })
    }
}

#[cfg(unix)]
fn fields(found: &Metadata) -> Option<[i64; 7]> {
    use std::os::unix::fs::MetadataExt;
    Some([
        i64::try_from(found.size()).ok()?,
        // Bit patterns, which are only compared.
        found.dev().cast_signed(),
        found.ino().cast_signed(),
        found.mtime(),
        found.mtime_nsec(),
        found.ctime(),
        found.ctime_nsec(),
    ])
}

#[cfg(not(unix))]
fn fields(_: &Metadata) -> Option<[i64; 7]> {
    None
}
