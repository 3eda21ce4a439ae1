//! One lint asked of shaders that can be laid out.

use landfall_layout::finding::{Finding, Level};
use landfall_layout::{Options, ShaderLayout, Source, layout};
use landfall_lint::{Check, Settings, Subject, lint, run};

/// What a lint finds in those files, paths and texts, that are checked together.
pub fn asked<T: AsRef<str>>(
    code: &str,
    files: &[(T, T)],
    options: &Options,
    settings: &Settings,
) -> Vec<Finding> {
    let files = files.iter().map(|(path, text)| (path.as_ref(), text.as_ref()));
    let sources: Vec<Source> = files.map(|(path, text)| Source::new(path, text)).collect();
    let shaders: Vec<ShaderLayout> = sources.iter().map(|source| layout(source, options)).collect();
    for shader in &shaders {
        assert!(!shader.has_errors(), "{}: {:#?}", shader.path, shader.diagnostics);
    }
    let pairs = sources.iter().zip(&shaders);
    let subjects: Vec<Subject<'_>> =
        pairs.map(|(source, shader)| Subject { source, options, shader }).collect();
    match lint(code).expect("there is such a lint").check {
        Check::Shader(check) | Check::Naga(check) => {
            subjects.iter().flat_map(|subject| check(subject, settings)).collect()
        }
        Check::Tree(check) => check(&subjects, settings),
        // Lints of functions share one reading, those of hazards one analysis.
        Check::Functions | Check::Hazard(..) => {
            let levels = vec![("all".into(), Level::Allow), (code.into(), Level::Warn)];
            let settings = Settings { levels, ..settings.clone() };
            subjects.iter().flat_map(|subject| run::shader(subject, &settings)).collect()
        }
        Check::Elsewhere => panic!("`{code}` is not asked by itself"),
    }
}

/// `line:column message`.
pub fn said(finding: &Finding) -> String {
    format!("{}:{} {}", finding.place().line, finding.place().column, finding.message)
}

pub fn help(finding: &Finding) -> &str {
    finding.help.as_deref().unwrap_or("")
}
