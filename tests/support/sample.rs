//! How many of a large set of inputs a test tries.
//!
//! `LANDFALL_TESTS=all`, which `./tests/run all` and `./tests/run PART` set, tries every one. Otherwise a
//! test tries a sample, drawn by a seed that changes by the day, so that in time all are tried.
//! `LANDFALL_SEED` gives a seed back; a test that fails prints it.

use std::ops::Range;
use std::sync::LazyLock;
use std::time::SystemTime;

/// Whether every input is tried.
pub fn everything() -> bool {
    static EVERYTHING: LazyLock<bool> =
        LazyLock::new(|| match std::env::var("LANDFALL_TESTS").unwrap_or_default().as_str() {
            "" => false,
            "all" => true,
            other => panic!("LANDFALL_TESTS is `{other}`; it can be `all`"),
        });
    *EVERYTHING
}

/// The seed of samples: `LANDFALL_SEED`, else the days since 1970.
pub fn seed() -> u64 {
    static SEED: LazyLock<u64> = LazyLock::new(|| match std::env::var("LANDFALL_SEED") {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("LANDFALL_SEED is `{text}`, no number")),
        Err(_) => {
            let since = SystemTime::UNIX_EPOCH.elapsed().expect("the clock is past 1970");
            since.as_secs() / 86_400
        }
    });
    *SEED
}

/// The numbers that are tried: one in each `one_in` that follow each other, or all.
pub fn sample(numbers: Range<u64>, one_in: u64) -> impl Iterator<Item = u64> {
    let one_in = if everything() { 1 } else { one_in };
    if one_in > 1 {
        // Shown where the test fails.
        println!("LANDFALL_SEED={}: one in {one_in}", seed());
    }
    let Range { start, end } = numbers;
    (start..end).step_by(one_in as usize).map(move |first| {
        let among = one_in.min(end - first);
        first
            + fastrand::Rng::with_seed(seed() ^ first.wrapping_mul(0x9e37_79b9_7f4a_7c15))
                .u64(0..among)
    })
}

/// The elements that are tried, as by [`sample`].
pub fn sampled<T>(all: &[T], one_in: u64) -> impl Iterator<Item = &T> {
    sample(0..all.len() as u64, one_in).map(|number| &all[number as usize])
}
