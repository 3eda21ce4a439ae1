//! A cheap scan of a shader's tokens that tells whether a hazard lint can find anything in it.
//!
//! Following a shader's values costs as much as lowering it, several times its layout, so that
//! hazard lints run only where the tokens they depend on occur. The scan may err in one direction
//! only: it may pass a shader that has no hazard.

use landfall_ir::analysis::identifier::identifier_words;
use landfall_ir::analysis::occurrence::Kind;
use landfall_ir::analysis::roles::LightBinding;
use landfall_layout::ShaderLayout;
use landfall_layout::source::Language;
use landfall_layout::syntax::{joined_lines, tokens};

/// Returns those of the kinds that the tokens of a shader and its includes may contain.
pub(super) fn possible(
    shader: &ShaderLayout,
    kinds: &[Kind],
    lights: &[LightBinding<'_>],
) -> Vec<Kind> {
    let language = shader.language;
    let texts: Vec<_> =
        shader.files.iter().map(|file| joined_lines(&file.text, language)).collect();
    let tokens = texts.iter().flat_map(|text| tokens(text, language)).collect();
    let scan = TokenScan { tokens, language };
    kinds.iter().copied().filter(|kind| scan.may_have(*kind, lights)).collect()
}

/// The tokens of a shader and its includes, before macros are expanded.
struct TokenScan<'a> {
    tokens: Vec<&'a str>,
    language: Language,
}

impl TokenScan<'_> {
    /// Returns whether the tokens may contain a hazard of that kind.
    fn may_have(&self, kind: Kind, lights: &[LightBinding<'_>]) -> bool {
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
            Kind::LoopPastCount => lights.iter().take(MAX_NAMES).any(|light| {
                let count = light.count.as_ref().filter(|_| light.slots().is_some());
                count.is_some_and(|count| !self.bounds(&count.member.name))
            }),
            Kind::KahanWithoutPrecise => {
                // `(t - s) - y` is a statement with two subtractions.
                let mut statements = self.tokens.split(|t| matches!(*t, ";" | "{" | "}"));
                statements.any(|statement| {
                    statement.iter().any(|token| token.contains('='))
                        && statement.iter().filter(|token| **token == "-").count() >= 2
                })
            }
            // No token rules these out.
            Kind::UnguardedNormalize
            | Kind::AttenuationDivision
            | Kind::ConeDivision
            | Kind::CosineCone
            | Kind::PowOfZero
            | Kind::UngatedSpecular
            | Kind::UnclampedCount
            | Kind::AmbientPerLight
            | Kind::UnguardedOperation
            | Kind::MediumpPosition => true,
        }
    }

    /// Returns whether a name contains a text: `pow` is in a macro's `POW_pow`, too.
    fn has(&self, part: &str) -> bool {
        self.tokens.iter().any(|token| token.contains(part))
    }

    /// Returns the token at a distance from an index; empty outside the text.
    fn at(&self, index: usize, distance: isize) -> &str {
        index.checked_add_signed(distance).and_then(|i| self.tokens.get(i)).copied().unwrap_or("")
    }

    /// Returns the indices of a token.
    fn uses(&self, token: &str) -> impl Iterator<Item = usize> {
        self.tokens
            .iter()
            .enumerate()
            .filter(move |(_, own)| **own == token)
            .map(|(index, _)| index)
    }

    /// Returns whether a `dot` is not the first argument of `max(…)`, `clamp(…)` or `saturate(…)`.
    fn has_bare_dot(&self) -> bool {
        self.uses("dot").any(|index| {
            let bounded = ["max", "clamp", "saturate"].contains(&self.at(index, -2));
            !(self.at(index, -1) == "(" && bounded)
        })
    }

    /// Returns whether something is compared with a number above 1 that has a decimal point.
    fn compares_past_one(&self) -> bool {
        let past_one = |token: &str| {
            let digits = token.trim_end_matches(|c: char| c.is_ascii_alphabetic());
            digits.contains('.') && digits.parse().is_ok_and(|number: f64| number > 1.0)
        };
        let compares = |token: &str| matches!(token, "<" | ">" | "<=" | ">=");
        (0..self.tokens.len()).filter(|index| compares(self.tokens[*index])).any(|index| {
            // WGSL's `<=` is two tokens; a sign may stand before the number.
            let after = (1..4).map(|d| self.at(index, d)).find(|t| !matches!(*t, "=" | "-"));
            past_one(self.at(index, -1)) || after.is_some_and(past_one)
        })
    }

    /// Returns whether a function declares a float or vector without an initialiser, or an output
    /// is added to.
    fn declares_without_value(&self) -> bool {
        // The braces that are open inside of functions, and all that are open; the start of the
        // statement.
        let (mut functions, mut depth, mut start, mut outputs) = (0u32, 0u32, 0, 0);
        for (index, token) in self.tokens.iter().enumerate() {
            match *token {
                "{" => {
                    // The body of a function opens behind its parameters, and contains further
                    // braces.
                    if functions > 0 || self.at(index, -1) == ")" {
                        functions += 1;
                    }
                    depth += 1;
                }
                "}" => {
                    functions = functions.saturating_sub(1);
                    depth = depth.saturating_sub(1);
                }
                ";" => {
                    let statement = &self.tokens[start..index];
                    if functions > 0 && declares(statement) {
                        return true;
                    }
                    // A global or an output lacks a value only where something adds to it.
                    if depth == 0 && (declares(statement) || statement.contains(&"out")) {
                        outputs += 1;
                        let added = |name: &&str| self.added_to(name);
                        if outputs > MAX_NAMES || declared(statement).iter().any(added) {
                            return true;
                        }
                    }
                }
                _ => continue,
            }
            start = index + 1;
        }
        self.added_to("gl_FragColor")
    }

    /// Returns whether `name += …`, `name.rgb += …`, `name[0] += …` or `name = name + …` occurs.
    fn added_to(&self, name: &str) -> bool {
        self.uses(name).any(|index| {
            let after = &self.tokens[index + 1..];
            let statement = after.split(|token| *token == ";").next().unwrap_or(after);
            let Some(assigned) = statement.iter().position(|token| *token == "=") else {
                return false;
            };
            statement[..assigned].last() == Some(&"+") || statement[assigned..].contains(&"+")
        })
    }

    /// Returns whether an input normal is used in another way than alone in a call:
    /// `normalize(normal)`.
    fn uses_bare_normal(&self) -> bool {
        let mut seen: Vec<&str> = Vec::new();
        self.tokens.iter().any(|name| {
            // A cheap test, before names are split into words.
            let may = ["orm", "ORM", "nrm"].iter().any(|part| name.contains(part));
            if !may || *name == "normalize" || seen.contains(name) {
                return false;
            }
            seen.push(name);
            let normal = ["normal", "normals", "norm", "nrm"];
            seen.len() > MAX_NAMES
                || (identifier_words(name).iter().any(|w| normal.contains(&w.as_str()))
                    && self.is_input(name))
        })
    }

    fn is_input(&self, name: &str) -> bool {
        let mut declared = false;
        let mut bare = false;
        for index in self.uses(name) {
            let before = &self.tokens[..index];
            let declaration = before.rsplit(|token| matches!(*token, ";" | "{" | "}")).next();
            // `in vec3 n;`, `varying vec3 n;`, `@location(0) n: vec3f`.
            let comes_in = declaration.is_some_and(|tokens| {
                tokens.iter().any(|token| ["in", "varying", "location"].contains(token))
            });
            if comes_in && [";", ":"].contains(&self.at(index, 1)) {
                declared = true;
            } else {
                // The token before the name or, for a member, before the variable.
                let opens = if self.at(index, -1) == "." { -3 } else { -1 };
                bare |= !(self.at(index, opens) == "(" && self.at(index, 1) == ")");
            }
        }
        // A name declared elsewhere, as in a block or a macro, may be an input too.
        (declared || self.language == Language::Wgsl) && bare
    }

    /// Returns whether a loop seems to be bounded by a count.
    fn bounds(&self, count: &str) -> bool {
        self.uses(count).any(|mut index| {
            // Back from a member to its variable.
            while self.at(index, -1) == "." && index >= 2 {
                index -= 2;
            }
            match self.at(index, -1) {
                "<" | "<=" | ">=" | "!=" => true,
                // Two tokens in WGSL.
                "=" => ["<", ">", "!"].contains(&self.at(index, -2)),
                "(" => ["min", "clamp"].contains(&self.at(index, -2)),
                _ => false,
            }
        })
    }
}

/// The number of names that are searched for one by one; a text with more passes the scan.
const MAX_NAMES: usize = 64;

/// Returns whether a statement declares a float or vector without an initialiser: `vec3 total`,
/// `float a, b = 1.0`.
fn declares(statement: &[&str]) -> bool {
    let precision = ["highp", "mediump", "lowp", "precise"];
    let statement = match statement {
        [first, rest @ ..] if precision.contains(first) => rest,
        _ => statement,
    };
    let types = ["float", "vec2", "vec3", "vec4", "double", "half"];
    match statement {
        [ty, declarators @ ..] if types.contains(ty) => has_bare_name(declarators),
        _ => false,
    }
}

/// Returns the names of a declaration: `a` and `b` of `layout(location = 0) out vec4 a[2], b`.
fn declared<'a>(statement: &[&'a str]) -> Vec<&'a str> {
    // A name is the last word before its `=`, its `,` or the end; brackets are skipped.
    let (mut depth, mut initialised, mut names) = (0, false, vec![""]);
    for token in statement {
        match *token {
            "(" | "[" => depth += 1,
            ")" | "]" => depth -= 1,
            _ if depth > 0 => {}
            "=" => initialised = true,
            "," => {
                initialised = false;
                names.push("");
            }
            token if !initialised => *names.last_mut().expect("one at least") = token,
            _ => {}
        }
    }
    names
}

/// Returns whether one of several names declared together has no `=`.
fn has_bare_name(declarators: &[&str]) -> bool {
    let (mut depth, mut initialised) = (0, declarators.is_empty());
    for token in declarators {
        match *token {
            "(" | "[" => depth += 1,
            ")" | "]" => depth -= 1,
            "=" => initialised = true,
            "," if depth == 0 && !initialised => return true,
            "," if depth == 0 => initialised = false,
            _ => {}
        }
    }
    !initialised
}
