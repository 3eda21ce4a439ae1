//! Lint settings of the configuration: levels, permutations, mirror groups, tables, Rust mirrors.

use landfall_layout::diagnostic::Code;
use landfall_layout::finding::Level;
use landfall_layout::text::glob::Glob;
use landfall_layout::{Diagnostic, Span};
use landfall_lint::Settings;
use landfall_lint::settings::{
    CompiledShader, Figure, MirrorCopy, MirrorGroup, PathLevels, Proof, Row, RustMirror, Table,
    VariantSets,
};

use super::root::Root;
use super::toml::{self, Keys, Text};
use super::{define, figure, is_code, missing, unknown_code};
use crate::walk::slashes;

pub fn read(keys: &Keys<'_>, root: &Root) -> Settings {
    Settings {
        rust_files: Vec::new(),
        levels: levels(keys),
        path_levels: keys.tables("path-levels", "[[path-levels]]", |keys| path_levels(keys, root)),
        flag_levels: Vec::new(),
        targets: Vec::new(),
        permutations: sets(keys, "permutations"),
        variants: keys.tables("variants", "[[variants]]", |keys| variant_sets(keys, root)),
        mirror_groups: keys
            .tables("mirror-group", "[[mirror-group]]", |keys| mirror_group(keys, root)),
        tables: keys.tables("table", "[[table]]", |keys| table(keys, root)),
        rust_mirrors: keys.tables("rust-mirror", "[[rust-mirror]]", |keys| rust_mirror(keys, root)),
        compiled: keys.tables("compiled", "[[compiled]]", |keys| compiled(keys, root)),
        proofs: keys.tables("prove", "[[prove]]", |keys| proof(keys, root)),
    }
}

/// The levels: `all`, then `warnings`, then single codes. TOML tables have no order, so specific
/// codes override general ones.
fn levels(keys: &Keys<'_>) -> Vec<(String, Level)> {
    let mut levels = Vec::new();
    for (code, value) in keys.rows("levels", "{ layout-drift = \"deny\" }") {
        if !is_code(&code.value) {
            keys.add(unknown_code(&code.value).with_label(code.span, ""));
            continue;
        }
        let Some(name) = value.text() else {
            let message =
                format!("the level of `{}` is {}, not a string", code.value, value.kind());
            let found = Diagnostic::error(Code::WrongType, value.span(), message);
            keys.add(found.with_help("write `\"allow\"`, `\"warn\"` or `\"deny\"`"));
            continue;
        };
        match Level::from_name(&name.value) {
            Some(level) => match missing(&code.value, level) {
                Some(found) => keys.add(found.with_label(code.span, "")),
                None => levels.push((code.value, level)),
            },
            None => keys.unknown(Code::WrongValue, "level", &name, &Level::ALL.map(Level::name)),
        }
    }
    // They are applied in this order, so that the most specific comes last.
    let rank = |code: &str| match code {
        "all" => 0,
        "warnings" => 1,
        _ => 2,
    };
    levels.sort_by_key(|(code, _)| rank(code));
    levels
}

fn path_levels(keys: &Keys<'_>, root: &Root) -> Option<PathLevels> {
    let file = keys.needed("file");
    // Read again for its errors, and relative to the root.
    let glob = glob(keys, "file", root);
    let levels = levels(keys);
    if keys.row("levels").is_none() {
        let found =
            Diagnostic::error(Code::MissingKey, keys.span(), "`[[path-levels]]` has no `levels`");
        keys.add(found.with_help("add `levels = { warnings = \"allow\" }`"));
    }
    file?;
    Some(PathLevels { file: glob, levels })
}

fn variant_sets(keys: &Keys<'_>, root: &Root) -> Option<VariantSets> {
    let file = keys.needed("file");
    let sets = sets(keys, "sets");
    if sets.is_empty() {
        let message = "`[[variants]]` has no `sets`";
        let found = Diagnostic::error(Code::MissingKey, keys.span(), message);
        keys.add(found.with_help("add `sets = [[\"SHADOWS=1\"], [\"SHADOWS=2\"]]`"));
    }
    // Read again for its errors, and relative to the root.
    let glob = glob(keys, "file", root);
    let base = keys.bool("base").unwrap_or(false);
    file.map(|_| VariantSets { file: glob, sets, base })
}

/// Sets of macros.
fn sets(keys: &Keys<'_>, key: &'static str) -> Vec<Vec<(String, String)>> {
    let lists = keys.text_lists(key);
    let set = |list: &Vec<Text>| -> Vec<(String, String)> {
        list.iter().filter_map(|text| keys.parsed(Code::WrongValue, text, define)).collect()
    };
    lists.iter().map(set).collect()
}

fn mirror_group(keys: &Keys<'_>, root: &Root) -> Option<MirrorGroup> {
    let name = keys.needed("name");
    let copies = keys.tables("copies", "copies", |keys| mirror_copy(keys, root));
    if keys.row("copies").is_none_or(|row| row.len().is_some_and(|copies| copies < 2)) {
        let message = "a mirror group with fewer than two copies compares nothing".to_string();
        let found = Diagnostic::error(Code::MissingKey, keys.span(), message);
        keys.add(found.with_help("add the other copies to `copies`"));
    }
    Some(MirrorGroup { name: name?.value, copies, place: keys.place() })
}

fn mirror_copy(keys: &Keys<'_>, root: &Root) -> Option<MirrorCopy> {
    let (file, block) = (glob(keys, "file", root), keys.needed("block"));
    let prefix = keys.text("prefix").map(|text| text.value).unwrap_or_default();
    let aliases = aliases(keys, "{ position = \"pos\" }");
    Some(MirrorCopy { file, block: block?.value, prefix, aliases, place: keys.place() })
}

fn table(keys: &Keys<'_>, root: &Root) -> Option<Table> {
    let (file, block) = (glob(keys, "file", root), keys.needed("block"));
    let size = keys.row("size").and_then(|row| figure(keys, "size", row));
    let rows = keys.rows("offsets", "{ \"data[0].pos\" = 0 }");
    let offsets: Vec<Row> = rows
        .into_iter()
        .filter_map(|(path, row)| {
            let offset = figure(keys, &path.value, row)?;
            Some(Row { path: path.value, offset })
        })
        .collect();
    if keys.row("size").is_none() && keys.row("offsets").is_none() {
        let message = "a table without `size` and `offsets` checks nothing".to_string();
        let found = Diagnostic::error(Code::MissingKey, keys.span(), message);
        keys.add(found.with_help("add `size = …`, or a row to `offsets`"));
    }
    Some(Table { block: block?.value, file, size, offsets, place: keys.place() })
}

fn rust_mirror(keys: &Keys<'_>, root: &Root) -> Option<RustMirror> {
    let (file, structure) = (keys.needed("file"), keys.needed("structure"));
    let (block, shader) = (keys.needed("block"), glob(keys, "shader", root));
    let aliases = aliases(keys, "{ position = \"pos\" }");
    Some(RustMirror {
        file: slashes(&root.path(&file?.value)),
        structure: structure?.value,
        block: block?.value,
        shader,
        aliases,
        place: keys.place(),
    })
}

fn compiled(keys: &Keys<'_>, root: &Root) -> Option<CompiledShader> {
    let [source, spirv] = ["source", "spirv"].map(|key| keys.needed(key));
    let path = |text: Text| slashes(&root.path(&text.value));
    Some(CompiledShader { source: path(source?), spirv: path(spirv?), place: keys.place() })
}

fn proof(keys: &Keys<'_>, root: &Root) -> Option<Proof> {
    if !cfg!(feature = "exec") {
        let message = "`[[prove]]` needs the feature `exec`, which this build lacks";
        let found = Diagnostic::error(Code::UnknownLint, keys.span(), message);
        keys.add(found.with_help("cargo install landfall --features exec"));
    }
    // Read nevertheless, so that they are not reported as unknown.
    let (file, function) = (keys.needed("file"), keys.needed("function"));
    // Read again for its errors, and relative to the root.
    let glob = glob(keys, "file", root);
    let [no_nan, no_inf] = ["no-nan", "no-inf"].map(|key| keys.bool(key).unwrap_or(false));
    let [max_ulp, max_step, time] = ["max-ulp", "max-step", "time"].map(|key| keys.number(key));
    let domain = keys.json_table("domain", "{ d = [0, 100] }");
    file?;
    Some(Proof {
        file: glob,
        function: function?.value,
        no_nan,
        no_inf,
        max_ulp,
        max_step,
        domain,
        time,
        place: keys.place(),
    })
}

/// A number of bytes: an integer, or an expression in a string.
fn figure(keys: &Keys<'_>, name: &str, row: toml::Row<'_>) -> Option<Figure> {
    let span = row.span();
    let place = keys.place_of(span);
    if let Some((digits, radix)) = row.integer() {
        let bytes = u64::from_str_radix(digits, radix).ok();
        if bytes.is_none() {
            let message = format!("`{name}` is {digits}, which is not a number of bytes");
            let found = Diagnostic::error(Code::WrongValue, span, message);
            keys.add(found.with_help("write a number from 0 to 2^63 - 1"));
        }
        return Some(Figure { bytes: bytes?, written: keys.written(span).to_string(), place });
    }
    let Some(text) = row.text() else {
        let message = format!("`{name}` is {}, not a number of bytes", row.kind());
        let found = Diagnostic::error(Code::WrongType, span, message);
        keys.add(found.with_help("write a number, or arithmetic such as `\"48 * 128 + 4\"`"));
        return None;
    };
    match figure::value(&text.value) {
        Ok(bytes) => Some(Figure { bytes, written: text.value, place }),
        Err((range, message)) => {
            // Without escapes, offsets in the value are offsets in the file.
            let as_it_is = keys.written(span).get(1..1 + text.value.len()) == Some(&*text.value);
            let at = |at: usize| span.start + 1 + at as u32;
            let span = match as_it_is {
                true => Span { start: at(range.start), end: at(range.end), ..span },
                false => span,
            };
            let message = format!("`{name}` is not a number of bytes: {message}");
            let found = Diagnostic::error(Code::WrongValue, span, message);
            keys.add(
                found.with_help("write arithmetic such as `48 * 128 + 4`, `+ - * ( )` and hex"),
            );
            None
        }
    }
}

fn aliases(keys: &Keys<'_>, example: &str) -> Vec<(String, String)> {
    let rows = keys.rows("aliases", example);
    rows.into_iter()
        .filter_map(|(name, row)| match row.text() {
            Some(text) => Some((name.value, text.value)),
            None => {
                let message = format!("the other name of `{}` is {}", name.value, row.kind());
                let found = Diagnostic::error(Code::WrongType, row.span(), message);
                keys.add(found.with_help(format!("write `{} = \"…\"`", name.value)));
                None
            }
        })
        .collect()
}

pub fn glob(keys: &Keys<'_>, key: &'static str, root: &Root) -> String {
    let Some(text) = keys.text(key) else { return String::new() };
    if let Err(cause) = Glob::new(&text.value) {
        keys.bad_glob(&text, &cause.to_string());
    }
    root.glob(&text.value)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::config::toml::Document;

    fn settings(text: &str) -> Settings {
        let root = Root::new(Path::new("..")).unwrap();
        let document = Document::new("landfall.toml", text.to_string());
        document.read(|keys| read(keys, &root)).unwrap_or_else(|(found, _)| panic!("{found:#?}"))
    }

    #[test]
    fn levels_come_from_the_general_to_the_special() {
        let text = "[levels]\nmat3-padding = \"warn\"\nwarnings = \"deny\"\nall = \"warn\"\n";
        let levels: Vec<String> = settings(text).levels.into_iter().map(|(code, _)| code).collect();
        assert_eq!(levels, ["all", "warnings", "mat3-padding"]);
    }

    #[cfg(not(feature = "analysis"))]
    #[test]
    fn a_level_enables_no_lint_that_this_build_lacks() {
        let root = Root::new(Path::new("..")).unwrap();
        let read = |text: &str| {
            let document = Document::new("landfall.toml", text.to_string());
            let settings = document.read(|keys| super::read(keys, &root));
            settings.map(|settings| settings.levels.len()).map_err(|(found, _)| found)
        };
        assert_eq!(read("[levels]\npow-of-zero = \"allow\"\nwarnings = \"deny\"\n"), Ok(2));
        for code in ["pow-of-zero", "unused-member", "naga-disagrees"] {
            let refused = read(&format!("[levels]\n{code} = \"warn\"\n")).unwrap_err();
            assert_eq!(refused.len(), 1, "{refused:?}");
            assert!(refused[0].message.contains("it needs the feature `analysis`"), "{refused:?}");
            assert_eq!(
                refused[0].help.as_deref(),
                Some("cargo install landfall --features analysis")
            );
        }
    }

    #[cfg(not(feature = "exec"))]
    #[test]
    fn proofs_need_the_feature_that_runs_shaders() {
        let root = Root::new(Path::new("..")).unwrap();
        let text = "[[prove]]\nfile = \"a.frag\"\nfunction = \"f\"\n";
        let document = Document::new("landfall.toml", text.to_string());
        let (refused, _) = document.read(|keys| super::read(keys, &root)).unwrap_err();
        assert_eq!(refused.len(), 1, "{refused:?}");
        assert_eq!(
            refused[0].message,
            "`[[prove]]` needs the feature `exec`, which this build lacks"
        );
        assert_eq!(refused[0].help.as_deref(), Some("cargo install landfall --features exec"));
    }

    #[test]
    fn tables_hold_figures_as_they_are_written_with_their_places() {
        let text = "[[table]]\nblock = \"Lights\"\nfile = \"s/*.frag\"\nsize = \"48 * 128 + 4\"\n\
                    [table.offsets]\n\"data[1].pos\" = 0x30\n\"data[0].pos\" = 0\n";
        let table = settings(text).tables.remove(0);
        assert_eq!((table.block.as_str(), table.file.as_str()), ("Lights", "../s/*.frag"));
        assert_eq!((table.place.line, table.place.column), (1, 1));
        let size = table.size.unwrap();
        assert_eq!((size.bytes, size.written.as_str()), (6148, "48 * 128 + 4"));
        assert_eq!((size.place.line, size.place.column), (4, 8));
        let rows: Vec<(&str, u64, &str)> = table
            .offsets
            .iter()
            .map(|row| (row.path.as_str(), row.offset.bytes, row.offset.written.as_str()))
            .collect();
        assert_eq!(rows, [("data[1].pos", 48, "0x30"), ("data[0].pos", 0, "0")]);
        assert_eq!(table.offsets[0].offset.place.line, 6);
    }

    #[test]
    fn copies_and_rust_mirrors_are_found_from_the_configuration() {
        let text = "permutations = [[\"SHADOWS=1\", \"FOG\"], []]\n[[mirror-group]]\nname = \"light\"\n\
                    copies = [{ block = \"A\" }, { file = \"b/*\", block = \"b.lights[]\", \
                    prefix = \"u_\", aliases = { position = \"pos\" } }]\n\
                    [[rust-mirror]]\nfile = \"src/light.rs\"\nstructure = \"L\"\nblock = \"A\"\n";
        let settings = settings(text);
        let set = [("SHADOWS".to_string(), "1".to_string()), ("FOG".to_string(), "1".to_string())];
        assert_eq!(settings.permutations, [set.to_vec(), Vec::new()]);
        let group = &settings.mirror_groups[0];
        let (first, second) = (&group.copies[0], &group.copies[1]);
        assert_eq!((group.name.as_str(), first.file.as_str(), first.place.line), ("light", "", 4));
        assert_eq!((second.file.as_str(), second.prefix.as_str()), ("../b/*", "u_"));
        assert_eq!(second.aliases, [("position".to_string(), "pos".to_string())]);
        let mirror = &settings.rust_mirrors[0];
        assert_eq!((mirror.file.as_str(), mirror.structure.as_str()), ("../src/light.rs", "L"));
    }
}
