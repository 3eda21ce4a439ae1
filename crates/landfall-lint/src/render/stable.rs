//! Identifiers of findings that do not change when lines move, for tools that compare two runs.
//!
//! For [`sarif`](super::sarif) and [`junit`](super::junit).

use rustc_hash::FxHashMap;

use landfall_layout::finding::Finding;

/// Numbers the findings with the same code, path and subject, from 1.
pub(super) fn numbers(findings: &[&Finding]) -> Vec<u32> {
    let mut seen: FxHashMap<(&str, &str, &str), u32> = FxHashMap::default();
    findings
        .iter()
        .map(|finding| {
            let count = seen.entry((&finding.code, &finding.place().path, &finding.about));
            let count = count.or_default();
            *count += 1;
            *count
        })
        .collect()
}

/// Returns the fingerprint of a finding: from its code, path and subject, and its number among equal ones.
pub(super) fn fingerprint(finding: &Finding, number: u32) -> String {
    let parts = [&finding.code, &finding.place().path, &finding.about];
    // No part contains a zero byte, which separates the parts.
    let bytes = parts.into_iter().flat_map(|part| part.bytes().chain([0]));
    format!("{:032x}:{number}", fnv1a(bytes))
}

/// FNV-1a with 128 bits (RFC 9923): the same on every machine and in every version.
fn fnv1a(bytes: impl Iterator<Item = u8>) -> u128 {
    const BASIS: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    bytes.fold(BASIS, |hash, byte| (hash ^ u128::from(byte)).wrapping_mul(PRIME))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vectors of RFC 9923, appendix C.
    #[test]
    fn the_hash_is_fnv_1a() {
        assert_eq!(fnv1a([].into_iter()), 0x6c62272e07bb014262b821756295c58d);
        assert_eq!(fnv1a(b"a".iter().copied()), 0xd228cb696f1a8caf78912b704e4a8964);
        assert_eq!(fnv1a(b"foobar".iter().copied()), 0x343e1662793c64bf6f0d3597ba446f18);
    }
}
