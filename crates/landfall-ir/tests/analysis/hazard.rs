//! The catalogue of hazards.

use std::collections::HashSet;

use landfall_ir::analysis::hazard::Hazard;

#[test]
fn all_lists_every_hazard_in_order_and_names_are_unique() {
    assert!(Hazard::ALL.is_sorted());
    let mut seen = HashSet::new();
    for hazard in Hazard::ALL {
        for name in [hazard.code()].into_iter().chain(hazard.rejection()) {
            assert!(seen.insert(name), "{name} names two hazards");
            assert_eq!(Hazard::named(name), Some(hazard), "{name}");
        }
    }
    assert_eq!(Hazard::named("narow-cone"), None);
    // The last variant's number is the length of a list without gaps.
    assert_eq!(Hazard::DriverApart as usize + 1, Hazard::ALL.len());
}

#[test]
fn codes_are_kebab_case_and_no_text_is_empty() {
    for hazard in Hazard::ALL {
        let info = hazard.info();
        let kebab = |c: char| c == '-' || c.is_ascii_lowercase() || c.is_ascii_digit();
        assert!(info.code.chars().all(kebab), "{}", info.code);
        for text in [info.name, info.what, info.why, info.robust, info.citation] {
            assert!(!text.is_empty(), "{hazard:?}");
        }
    }
}

/// A guard written in a robust form is the hazard's threshold, or the square of it.
#[test]
fn robust_forms_guard_with_the_threshold() {
    let mut guards = 0;
    for hazard in Hazard::ALL {
        let info = hazard.info();
        for (at, _) in info.robust.match_indices("1.0e-") {
            let digits = &info.robust[at..];
            let end = digits[5..].find(|c: char| !c.is_ascii_digit()).unwrap_or(2) + 5;
            let guard: f64 = digits[..end].parse().expect("a number");
            let value = info.threshold.expect("a guard has a threshold").value;
            let near = |x: f64| (guard - x).abs() <= 1e-9 * guard;
            assert!(near(value) || near(value * value), "{hazard:?}: {guard}, not {value}");
            guards += 1;
        }
    }
    assert!(guards >= 8, "{guards}");
}
