//! Puts the items of the output into modules: one for each shader, one for what several shaders
//! have in common, and one of helpers; or all mirrors into the file itself.
//!
//! The module of helpers is named after a shader in either case, so that two files can be included
//! in one module.

use std::fmt::Write as _;

use landfall_layout::diagnostic::{Code, Diagnostic, Severity};

use super::names::{Scope, module};
use super::naming::{Names, NumberedItem, name_module, name_support};
use super::plan::Plan;
use super::print::{Printer, indented};
use super::rename::Renames;
use super::types::Module;
use super::{RustOptions, Tables, check, constants, mirror, small, table, tail};

/// The data that all modules are printed from.
#[derive(Clone, Copy)]
struct ModulesPrinter<'a> {
    plan: &'a Plan<'a>,
    options: &'a RustOptions,
    /// The name of the module of helpers, and its items.
    support: &'a str,
    helpers: &'a Names,
}

/// Prints all items; `each` shader has a module of its own, or all have the file. `scope` gets the
/// names of the modules in the file.
pub(super) fn modules(
    plan: &Plan<'_>,
    options: &RustOptions,
    renames: &Renames,
    inputs: &[String],
    each: bool,
    scope: &mut Scope,
    text: &mut String,
) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    // A shader whose blocks were all refused has no module.
    let used = |at: &usize| !plan.types_in(Module::Shader(*at)).is_empty();
    let shaders: Vec<usize> = match each {
        true => (0..inputs.len()).filter(used).collect(),
        // Without modules the plan has all shaders under 0.
        false => (0..1).filter(used).collect(),
    };
    if shaders.is_empty() {
        return found;
    }
    let names: Vec<String> =
        shaders.iter().map(|&at| shader_module(&inputs[at], renames, scope, &mut found)).collect();
    let support = scope.take(&format!("{}_support", names[0]));
    let helpers = name_support(plan);
    let file = ModulesPrinter { plan, options, support: &support, helpers: &helpers };
    if each {
        let common = scope.take(&format!("{}_common", names[0]));
        let common_names = file.names(Module::Common, &mut found);
        for (&at, name) in shaders.iter().zip(&names) {
            file.shader(at, name, &inputs[at], (&common, &common_names), &mut found, text);
        }
        file.common(&common, &common_names, text);
    } else {
        let names = file.names(Module::Shader(0), &mut found);
        // Modules that are added to the file later keep clear of its items.
        names.made.iter().chain(&names.tables).for_each(|name| drop(scope.take(name)));
        let out = file.printer(Module::Shader(0), &names, true);
        let mut body = out.text();
        file.body(&out, &mut body);
        text.push_str(&body.text);
        let public = file.public();
        let _ = write!(
            text,
            "#[allow(unused_imports, ambiguous_glob_reexports)]\n{public} use {support}::*;\n\n"
        );
    }
    file.helpers(text);
    found
}

impl<'a> ModulesPrinter<'a> {
    fn public(&self) -> &'static str {
        self.options.visibility.keyword()
    }

    fn printer<'n>(&self, module: Module, names: &'n Names, root: bool) -> Printer<'n>
    where
        'a: 'n,
    {
        Printer { plan: self.plan, names, options: self.options, module, root }
    }

    /// The names of a module of mirrors; warns of those that got a number.
    fn names(&self, here: Module, found: &mut Vec<Diagnostic>) -> Names {
        let root = matches!(here, Module::Shader(_)) && self.plan.is_flat();
        let support = match root {
            true => self.support.to_string(),
            false => format!("super::{}", self.support),
        };
        // Two files may be included in one module, where their imports by `*` clash: items in the file
        // itself spell the helpers by a path.
        let names =
            name_module(self.plan, here, self.options.tables, &support, self.helpers, !root);
        // The names of a common module are not what a program uses.
        if here != Module::Common {
            found.extend(names.numbered.iter().map(|one| self.numbered(one)));
        }
        names
    }

    fn numbered(&self, one: &super::naming::Numbered) -> Diagnostic {
        let (name, input) = match one.of {
            NumberedItem::Mirror(id) => {
                let docs = &self.plan.docs[&id];
                (docs.shader_name.as_str(), docs.input.as_str())
            }
            NumberedItem::Table(at) => {
                let block = &self.plan.blocks[at];
                (&*block.layout.name, block.input)
            }
        };
        let message = format!(
            "`{name}` of {input} is named `{}`: `{}` is another item of its module",
            one.given, one.wanted
        );
        Diagnostic::without_place(Code::NumberedName, Severity::Warning, message)
            .with_help(format!("give it a name: `--rename {input}:{name}=NAME`"))
    }

    /// Prints what a module has of its own.
    fn body(&self, out: &Printer<'_>, text: &mut super::print::Text) {
        constants::constants(out, text);
        mirror::mirrors(out, text);
        if self.options.tables == Tables::Beside {
            table::tables(out, text);
        }
        small::small_types(out, text);
        check::checks(out, text);
        if !text.text.is_empty() && !text.text.ends_with("\n\n") {
            text.push_str("\n");
        }
    }

    /// Prints the module of a shader.
    fn shader(
        &self,
        at: usize,
        name: &str,
        input: &str,
        (common, common_names): (&str, &Names),
        found: &mut Vec<Diagnostic>,
        text: &mut String,
    ) {
        let here = Module::Shader(at);
        let names = self.names(here, found);
        let out = self.printer(here, &names, false);
        let mut body = out.text();
        self.import_helpers(&mut body.text);
        let mut import = |of: &str, name: &str| {
            let renamed = if of == name { String::new() } else { format!(" as {name}") };
            let public = self.public();
            let _ = write!(
                body,
                "#[allow(unused_imports)]\n{public} use super::{common}::{of}{renamed};\n\n"
            );
        };
        // What is shared is imported by the name that this module alone would have given it, so
        // that a program need not change when another shader comes to share it.
        let shared = self.plan.types_in(here).into_iter();
        for id in shared.filter(|id| self.plan.module_of(*id) == Module::Common) {
            import(&common_names.made[id.0], &names.made[id.0]);
            for (of, own) in
                [(&common_names.inits, &names.inits), (&common_names.elements, &names.elements)]
            {
                if let (Some(of), Some(own)) = (of.get(&id), own.get(&id)) {
                    import(of, own);
                }
            }
        }
        for (of, own) in common_names.tables.iter().zip(&names.tables) {
            if !of.is_empty() && !own.is_empty() {
                import(of, own);
            }
        }
        self.body(&out, &mut body);
        self.wrapped(&format!("The blocks of `{input}`."), self.public(), name, &body, text);
    }

    /// Prints the module of what several shaders have in common.
    fn common(&self, name: &str, names: &Names, text: &mut String) {
        let out = self.printer(Module::Common, names, false);
        let mut body = out.text();
        self.body(&out, &mut body);
        // Imports alone make no module.
        if body.text.is_empty() {
            return;
        }
        let mut with_imports = out.text();
        self.import_helpers(&mut with_imports.text);
        with_imports.push_str(&body.text);
        let about = "What several shaders have in common.";
        self.wrapped(about, self.public(), name, &with_imports, text);
    }

    fn import_helpers(&self, text: &mut String) {
        let (public, support) = (self.public(), self.support);
        let _ = write!(
            text,
            "#[allow(unused_imports, ambiguous_glob_reexports)]\n\
             {public} use super::{support}::*;\n\n"
        );
    }

    /// Prints the module of helpers.
    fn helpers(&self, text: &mut String) {
        let out = self.printer(Module::Support, self.helpers, false);
        let mut body = out.text();
        small::small_types(&out, &mut body);
        let all = || self.plan.made.iter();
        if all().any(|made| made.has_tail()) {
            tail::too_short(&out, &mut body);
        }
        if self.options.tables == Tables::Beside && !self.plan.blocks.is_empty() {
            table::shared(&out, &mut body);
        }
        check::mismatch(&mut body);
        check::checks(&out, &mut body);
        let about = "Types and functions that the mirrors have in common.";
        self.wrapped(about, self.public(), self.support, &body, text);
        // One line ends the file.
        text.truncate(text.trim_end().len());
        text.push('\n');
    }

    fn wrapped(
        &self,
        about: &str,
        public: &str,
        name: &str,
        body: &super::print::Text,
        text: &mut String,
    ) {
        let inside = indented(body.text.trim_end(), 1);
        let _ = write!(text, "/// {about}\n{public} mod {name} {{\n{inside}}}\n\n");
    }
}

/// The name of a shader's module: its file's. Directories are put before it if another has it.
fn shader_module(
    input: &str,
    renames: &Renames,
    scope: &mut Scope,
    found: &mut Vec<Diagnostic>,
) -> String {
    if let Some(name) = renames.of_shader(input) {
        return scope.take(name);
    }
    let words = |part: &str| -> String {
        part.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect()
    };
    let parts: Vec<&str> =
        input.split('/').filter(|part| !matches!(*part, "" | "." | "..")).collect();
    let usual = module(&words(parts.last().unwrap_or(&"")));
    // The file's name, then with one more directory before it each time, until it is free.
    let longer =
        (1..=parts.len()).map(|count| module(&words(&parts[parts.len() - count..].join("_"))));
    let free = longer.into_iter().find(|name| scope.is_free(name));
    let given = scope.take(&free.unwrap_or_else(|| usual.clone()));
    if given != usual {
        let message = format!("the module of {input} is named `{given}`: another is `{usual}`");
        found.push(
            Diagnostic::without_place(Code::NumberedName, Severity::Warning, message)
                .with_help(format!("give it a name: `--rename {input}=NAME`")),
        );
    }
    given
}
