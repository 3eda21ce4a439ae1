//! Proves what `[[prove]]` demands of functions; what is not proved is a finding.

use std::sync::Arc;
use std::time::Duration;

use landfall_accuracy::demand::{Demand, DemandVerdict, ProveReport, ProveRequest, prove};
use landfall_accuracy::prove::Class;
use landfall_accuracy::stress::{OperationVerdict, count_lines};
use landfall_exec::harness::call::pure::PureRequest;
use landfall_layout::finding::{Finding, Level, Place};
use landfall_lint::settings::Proof;
use landfall_lint::{levels, not_proved};

use crate::pass::{CheckRun, Pass};

/// The findings for the shaders of this check; none if it is interrupted.
pub fn findings(pass: &Pass, check: &CheckRun<'_>) -> Vec<Finding> {
    let (basis, mut found) = (check.basis, Vec::new());
    if levels::level(not_proved::LINT.code, &basis.settings) == Level::Allow {
        return found;
    }
    for proof in &basis.settings.proofs {
        let read =
            pass.checked.iter().filter(|checked| !checked.failed && proof.takes(&checked.path));
        for checked in read {
            found.extend(of_shader(proof, &checked.path, check));
            // What an interrupted proof left open is not known.
            if check.stop.is_set() {
                return Vec::new();
            }
        }
    }
    found
}

fn of_shader(proof: &Proof, path: &str, check: &CheckRun<'_>) -> Vec<Finding> {
    let function = &proof.function;
    let Some(source) = check.source(path) else { return Vec::new() };
    let (threads, stop) = (check.jobs.map_or(0, usize::from), Arc::clone(&check.stop.0));
    let request = ProveRequest { threads, stop, ..request(proof) };
    match prove(&source, &check.options(), &request) {
        Ok(report) => of_report(proof, &report),
        Err(refusal) => {
            let causes: Vec<&str> = refusal.found.iter().map(|found| &*found.message).collect();
            let causes = causes.join("; ");
            let message = format!("`{function}` of `{path}` cannot be proved: {causes}");
            let finding = not_proved::finding(function, None, &proof.place, message);
            let help = refusal.found.into_iter().find_map(|found| found.help);
            vec![help.into_iter().fold(finding, Finding::with_help)]
        }
    }
}

fn request(proof: &Proof) -> ProveRequest {
    let flags = [(proof.no_nan, Demand::NoNan), (proof.no_inf, Demand::NoInfinity)];
    let flags = flags.into_iter().filter(|(is, _)| *is).map(|(_, demand)| demand);
    let limits = [proof.max_ulp.map(Demand::MaxUlp), proof.max_step.map(Demand::MaxStep)];
    let mut demands: Vec<Demand> = flags.chain(limits.into_iter().flatten()).collect();
    if demands.is_empty() {
        // Without any, errors would be bounded, too.
        demands.push(Demand::NoFault);
    }
    let usual = ProveRequest::default();
    ProveRequest {
        pure: PureRequest { function: proof.function.clone(), ..PureRequest::default() },
        domain: proof.domain.clone(),
        demands,
        time: proof.time.map_or(usual.time, Duration::from_secs_f64),
        ..usual
    }
}

/// A finding for each demand that is not shown.
fn of_report(proof: &Proof, report: &ProveReport) -> Vec<Finding> {
    let not_shown =
        report.demands.iter().filter(|(_, shown)| !matches!(shown, DemandVerdict::Shown));
    let findings = not_shown.map(|(demand, shown)| {
        let function = &report.function;
        let message = match shown {
            DemandVerdict::Broken(case) => {
                format!("{} with {}", broken(function, *demand), case.shown())
            }
            DemandVerdict::Open | DemandVerdict::Shown => {
                format!("it is not proved that `{function}` {}", demand_text(*demand))
            }
        };
        let finding =
            not_proved::finding(&proof.function, cause(report, *demand), &proof.place, message);
        let finding = count_lines(&report.operations).into_iter().fold(finding, Finding::with_note);
        finding.with_help(format!("`{}` lists them", command(proof, &report.path)))
    });
    findings.collect()
}

fn broken(function: &str, demand: Demand) -> String {
    match demand {
        Demand::NoFault => format!("`{function}` has an undefined result"),
        Demand::NoNan => format!("`{function}` is NaN"),
        Demand::NoInfinity => format!("`{function}` is infinite"),
        Demand::MaxUlp(most) => format!("the error of `{function}` is above {most} ULP"),
        Demand::MaxStep(most) => format!("the error of `{function}` is above {most} steps"),
    }
}

fn demand_text(demand: Demand) -> String {
    match demand {
        Demand::NoFault => "has no undefined result".to_string(),
        Demand::NoNan => "is never NaN".to_string(),
        Demand::NoInfinity => "is never infinite".to_string(),
        Demand::MaxUlp(most) => format!("is off by at most {most} ULP"),
        Demand::MaxStep(most) => format!("is off by at most {most} steps of 1/255"),
    }
}

/// The command that prints the whole proof.
fn command(proof: &Proof, path: &str) -> String {
    let mut command = format!("landfall prove {path} --fn '{}'", proof.function);
    for demand in request(proof).demands {
        command.push_str(&format!(" --{}", demand.name()));
        if let Demand::MaxUlp(most) | Demand::MaxStep(most) = demand {
            command.push_str(&format!(" {most}"));
        }
    }
    if let Some(domain) = &proof.domain {
        command.push_str(&format!(" --domain '{domain}'"));
    }
    command
}

/// The place of the first operation that keeps a demand from being shown.
fn cause(report: &ProveReport, demand: Demand) -> Option<Place> {
    let matters = |class: Class| match demand {
        Demand::NoFault => class == Class::Undefined,
        Demand::NoNan | Demand::NoInfinity => class != Class::Accuracy,
        Demand::MaxUlp(_) | Demand::MaxStep(_) => true,
    };
    let mut left = report.operations.iter().filter(|operation| {
        matters(operation.class()) && !matches!(operation.known, OperationVerdict::Absent)
    });
    // An operation that fails for some input tells more than one that is open.
    let found =
        left.clone().find(|operation| matches!(operation.known, OperationVerdict::Found(_)));
    let operation = found.or_else(|| left.next())?;
    Some(Place::new(&report.files, operation.place.span))
}
