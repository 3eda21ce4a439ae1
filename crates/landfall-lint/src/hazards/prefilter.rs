//! A cheap scan of a text that tells whether a hazard lint can find anything in it.
//!
//! Following a shader's values costs as much as lowering it, several times its layout, so that
//! hazard lints run only where the tokens they depend on occur. The scan may err in one direction
//! only: it may pass a shader that has no hazard.

use landfall_ir::analysis::hazards::Kind;
use landfall_ir::analysis::identifier::words;
use landfall_ir::analysis::roles::LightBinding;
use landfall_layout::ShaderLayout;
use landfall_layout::source::Language;

/// The text of a shader and its includes, without comments.
pub(super) struct TextScan {
    text: String,
    language: Language,
}

impl TextScan {
    pub fn new(shader: &ShaderLayout) -> TextScan {
        let mut text = String::new();
        for file in shader.files.iter() {
            uncommented(&file.text, &mut text);
        }
        TextScan { text, language: shader.language }
    }

    /// Returns whether the text may contain a hazard of that kind.
    pub fn may_have(&self, kind: Kind, lights: &[LightBinding<'_>]) -> bool {
        match kind {
            // `dot` inside `max` or `clamp` is not negative.
            Kind::PowOfNegative => self.has("pow") && self.has_bare_dot(),
            Kind::DegreesForCosine => {
                let cone =
                    |light: &LightBinding<'_>| light.roles.parts.iter().any(|p| p.role.is_cone());
                self.has("dot")
                    && (lights.iter().any(cone) || self.has("cos") || self.compares_past_one())
            }
            Kind::UninitialisedAccumulator => {
                self.language == Language::Glsl && self.declares_without_value()
            }
            Kind::UnnormalisedNormal => {
                (self.has("reflect") || self.has("pow")) && self.uses_bare_normal()
            }
            Kind::Vec4Normalise => self.has("transpose") && self.has("normalize"),
            Kind::LoopPastCount => lights.iter().take(MOST_NAMES).any(|light| {
                let count = light.count.as_ref().filter(|_| light.slots().is_some());
                count.is_some_and(|count| !self.bounds(&count.member.name))
            }),
            Kind::KahanWithoutPrecise => self
                .text
                .split([';', '{', '}'])
                .any(|statement| statement.contains('=') && statement.matches('-').count() >= 2),
            Kind::UnguardedNormalize
            | Kind::AttenuationDivision
            | Kind::ConeDivision
            | Kind::CosineCone
            | Kind::PowOfZero
            | Kind::UngatedSpecular
            | Kind::UnclampedCount
            | Kind::AmbientPerLight
            | Kind::MediumpPosition => true,
        }
    }

    fn has(&self, word: &str) -> bool {
        self.text.contains(word)
    }

    /// Finds a whole word, and returns the text before and after each occurrence.
    fn uses<'t>(&'t self, word: &'t str) -> impl Iterator<Item = (&'t str, &'t str)> {
        let letter = |c: char| c.is_alphanumeric() || c == '_';
        self.text.match_indices(word).filter_map(move |(at, _)| {
            let (before, after) = (&self.text[..at], &self.text[at + word.len()..]);
            let whole = !before.ends_with(letter) && !after.starts_with(letter);
            whole.then(|| (before.trim_end(), after.trim_start()))
        })
    }

    /// Returns whether a `dot` is not the first argument of `max(…)`, `clamp(…)` or `saturate(…)`.
    fn has_bare_dot(&self) -> bool {
        self.uses("dot").any(|(before, _)| {
            let call = before.strip_suffix('(').map(str::trim_end);
            !["max", "clamp", "saturate"].iter().any(|f| call.is_some_and(|c| c.ends_with(f)))
        })
    }

    /// Returns whether something is compared with a number above 1 that has a decimal point.
    fn compares_past_one(&self) -> bool {
        self.text.match_indices(['<', '>']).any(|(at, _)| {
            let after = self.text[at + 1..].trim_start_matches(['=', ' ', '-']);
            let end = after.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(after.len());
            let number = &after[..end];
            number.contains('.') && number.parse().is_ok_and(|number: f64| number > 1.0)
        }) || self.text.match_indices(['<', '>']).any(|(at, _)| {
            // `12.5 < theta`
            let before = self.text[..at].trim_end();
            let start =
                before.rfind(|c: char| !c.is_ascii_digit() && c != '.').map_or(0, |i| i + 1);
            // A letter may be longer than a byte.
            let number = before.get(start..).unwrap_or("");
            number.contains('.') && number.parse().is_ok_and(|number: f64| number > 1.0)
        })
    }

    /// Returns whether a function declares a float or vector without an initialiser, or an output
    /// is added to.
    fn declares_without_value(&self) -> bool {
        let mut functions: u32 = 0;
        let mut depth: u32 = 0;
        let mut start = 0;
        let mut outputs = 0;
        for (at, c) in self.text.char_indices() {
            match c {
                '{' => {
                    let opens = self.text[..at].trim_end().ends_with(')');
                    if functions > 0 || opens {
                        functions += 1;
                    }
                    depth += 1;
                    start = at + 1;
                }
                '}' => {
                    functions = functions.saturating_sub(1);
                    depth = depth.saturating_sub(1);
                    start = at + 1;
                }
                ';' => {
                    let statement = without_directives(&self.text[start..at]);
                    start = at + 1;
                    if functions > 0 && declares(statement) {
                        return true;
                    }
                    if depth == 0 && is_output(statement) {
                        outputs += 1;
                        if outputs > MOST_NAMES || self.is_added_to(statement) {
                            return true;
                        }
                    }
                }
                _ => {}
            }
        }
        self.uses("gl_FragColor").any(|(_, after)| is_added(after))
    }

    fn is_added_to(&self, statement: &str) -> bool {
        let Some(name) = statement.split_whitespace().last() else { return false };
        self.uses(name).any(|(_, after)| is_added(after))
    }

    /// Returns whether an input normal is used in another way than alone in a call:
    /// `normalize(normal)`.
    fn uses_bare_normal(&self) -> bool {
        let letter = |c: char| c.is_alphanumeric() || c == '_';
        let mut seen: Vec<&str> = Vec::new();
        self.text.split(|c| !letter(c)).any(|name| {
            let may = ["orm", "ORM", "nrm"].iter().any(|part| name.contains(part));
            if !may || name == "normalize" || seen.contains(&name) {
                return false;
            }
            seen.push(name);
            let normal = ["normal", "normals", "norm", "nrm"];
            seen.len() > MOST_NAMES
                || (words(name).iter().any(|w| normal.contains(&w.as_str())) && self.is_input(name))
        })
    }

    fn is_input(&self, name: &str) -> bool {
        let mut declared = false;
        let mut bare = false;
        for (before, after) in self.uses(name) {
            let line = before.rsplit([';', '{', '}']).next().unwrap_or("");
            let comes_in = line
                .split(|c: char| !c.is_alphanumeric())
                .any(|word| ["in", "varying", "location"].contains(&word));
            if comes_in && (after.starts_with(';') || after.starts_with(':')) {
                declared = true;
            } else {
                let of = before.strip_suffix('.').map_or(before, |before| {
                    before.trim_end_matches(|c: char| c.is_alphanumeric() || c == '_')
                });
                bare |= !(of.ends_with('(') && after.starts_with(')'));
            }
        }
        // A name declared elsewhere, as in a block or a macro, may be an input too.
        (declared || self.language == Language::Wgsl) && bare
    }

    /// Returns whether a loop seems to be bounded by a count.
    fn bounds(&self, count: &str) -> bool {
        self.uses(count).any(|(before, _)| {
            let of = before.trim_end_matches(|c: char| c.is_alphanumeric() || c == '_' || c == '.');
            let of = of.trim_end();
            ["<", "<=", ">=", "min(", "clamp(", "!="].iter().any(|sign| of.ends_with(sign))
        })
    }
}

/// The number of names that are searched for one by one; a text with more passes the scan.
const MOST_NAMES: usize = 64;

/// Returns a statement without the preprocessor directives before it.
fn without_directives(mut statement: &str) -> &str {
    loop {
        statement = statement.trim();
        if !statement.starts_with('#') {
            return statement;
        }
        statement = statement.find('\n').map_or("", |end| &statement[end..]);
    }
}

/// Returns whether a declaration outside functions is that of an output, or of a variable without
/// an initialiser.
fn is_output(statement: &str) -> bool {
    declares(statement) || statement.split_whitespace().any(|word| word == "out")
}

/// `vec3 total`, `float a, b`: without `=`, qualifiers or a call.
fn declares(statement: &str) -> bool {
    let mut parts = statement.split_whitespace();
    let ty = match parts.next() {
        Some("highp" | "mediump" | "lowp" | "precise") => parts.next(),
        other => other,
    };
    let typed =
        ty.is_some_and(|ty| ["float", "vec2", "vec3", "vec4", "double", "half"].contains(&ty));
    typed && parts.next().is_some() && has_bare_name(statement)
}

/// Returns whether one of several names declared together has no `=`.
fn has_bare_name(statement: &str) -> bool {
    let (mut depth, mut given) = (0, false);
    for c in statement.chars() {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            '=' => given = true,
            ',' if depth == 0 && !given => return true,
            ',' if depth == 0 => given = false,
            _ => {}
        }
    }
    !given
}

fn is_added(after: &str) -> bool {
    // `x += …`, `x.rgb += …`, `x = x + …`
    let after = after.trim_start_matches(|c: char| c == '.' || c.is_alphanumeric()).trim_start();
    after.starts_with("+=")
        || (after.starts_with('=') && after.split(';').next().is_some_and(|s| s.contains('+')))
}

/// Appends a text without its comments.
fn uncommented(text: &str, into: &mut String) {
    let mut rest = text;
    while let Some(at) = rest.find('/') {
        into.push_str(&rest[..at]);
        let comment = &rest[at..];
        rest = if comment.starts_with("//") {
            comment.find('\n').map_or("", |end| &comment[end..])
        } else if let Some(inner) = comment.strip_prefix("/*") {
            inner.find("*/").map_or("", |end| &inner[end + 2..])
        } else {
            into.push('/');
            &comment[1..]
        };
    }
    into.push_str(rest);
    into.push('\n');
}
