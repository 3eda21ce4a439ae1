//! A bench as CSV, for programs.

use std::fmt::Write as _;

use landfall_accuracy::bench::{Bench, BenchRow, Permitted, Spread};
use landfall_layout::format::csv::quoted;
use landfall_layout::layout::targets;

/// The header line of [`csv`].
pub const HEADER: &str = "variant,backend,device,clock,\
ns_per_light,ns_per_light_lower,ns_per_light_upper,ns_per_light_min,\
ns_per_fragment,ns_per_fragment_lower,ns_per_fragment_upper,ns_per_fragment_min,rounds,\
err_max_steps,err_p999_steps,err_median_steps,err_max_ulp,err_p999_ulp,err_median_ulp,\
ends_max_steps,ends_max_ulp,ends_non_finite,\
permitted_max_steps,permitted_p999_steps,permitted_unsure,permitted_samples,\
flips,channels,err_max_code,differing,non_finite,undefined,\
evaluations,evaluations_error,slots,powers,operations,bytes,dominated_by,assumed_target\n";

/// Returns a bench as CSV: a line for each variant, numbers in full.
pub fn csv(bench: &Bench) -> String {
    let mut text = HEADER.to_string();
    for row in &bench.rows {
        let BenchRow { variant, runner, light, fragment, .. } = row;
        let BenchRow { errors, ends, permitted, work, dominated_by, .. } = row;
        let four = |spread: Option<&Spread>| -> [String; 4] {
            spread.map_or_else(Default::default, |s| {
                [s.median, s.lower, s.upper, s.min].map(|number| number.to_string())
            })
        };
        let optional = |number: Option<f64>| number.map_or(String::new(), |n| n.to_string());
        let whole = |number: Option<u64>| number.map_or(String::new(), |n| n.to_string());
        // An unbounded error is written so that every CSV parser reads it as a number.
        let steps = |of: fn(&Permitted) -> Option<f64>| {
            optional(permitted.map(|permitted| of(&permitted).unwrap_or(f64::INFINITY)))
        };
        let mut cells = vec![
            variant.clone(),
            runner.backend.clone(),
            runner.device.clone(),
            runner.clock.name().to_string(),
        ];
        cells.extend(four(light.as_ref()));
        cells.extend(four(Some(fragment)));
        cells.extend([
            fragment.rounds.to_string(),
            optional(errors.max_steps),
            optional(errors.p999_steps),
            optional(errors.median_steps),
            optional(errors.max_ulp),
            optional(errors.p999_ulp),
            optional(errors.median_ulp),
            optional(ends.and_then(|ends| ends.max_steps)),
            optional(ends.and_then(|ends| ends.max_ulp)),
            whole(ends.map(|ends| ends.non_finite)),
            steps(|permitted| permitted.max_steps),
            steps(|permitted| permitted.p999_steps),
            whole(permitted.map(|permitted| permitted.unsure)),
            whole(permitted.map(|permitted| permitted.samples)),
            whole(errors.flips),
            errors.channels.to_string(),
            whole(errors.max_code.map(u64::from)),
            whole(errors.differing),
            errors.non_finite.to_string(),
            errors.undefined.to_string(),
            optional(work.evaluations),
            optional(work.evaluations_error),
            optional(work.slots),
            optional(work.powers),
            optional(work.operations),
            whole(work.bytes),
            dominated_by.join(" "),
            row.assumed_target.map(targets::key).unwrap_or_default().to_string(),
        ]);
        let cells: Vec<String> = cells.into_iter().map(quoted).collect();
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}
