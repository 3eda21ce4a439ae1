//! The file that declares a type which the shader lacks: one that it imports from, or one beside it,
//! whose text the program puts before, which a prelude tells.

use std::path::{Path, PathBuf};

use super::outline::{self, Class};
use super::report::Reports;
use crate::diagnostic::{Code, Diagnostic};
use crate::source::{Language, ReadOptions, Source, has_language, read_bytes};
use crate::syntax::listed;

/// The limit on files that are looked into.
const MAX_FILES: usize = 256;

/// The limit on the bytes of each.
const MAX_BYTES: u64 = 1 << 20;

/// Names, for each type that is unknown, the file that declares it.
// The folder is read at the first unknown type only.
pub(super) fn name_preludes(found: &mut [Diagnostic], source: &Source, options: &ReadOptions) {
    let unknown = found.iter_mut().filter(|found| found.code == Code::UnknownType);
    let mut files: Option<Vec<(PathBuf, String)>> = None;
    for found in unknown {
        let name =
            found.message.strip_prefix("unknown type `").and_then(|rest| rest.strip_suffix('`'));
        let Some(name) = name else { continue };
        // The first two are the text of all and the shader itself.
        let modules = source.linked.iter().flat_map(|linked| linked.files.iter().skip(2));
        if let Some(file) = modules.into_iter().find(|file| declares(&file.text, name)) {
            found.help = Some(format!("`{}` declares it: import it from there", file.path));
            continue;
        }
        let files = files.get_or_insert_with(|| beside(Path::new(&source.path), options));
        let Some((path, _)) = files.iter().find(|(_, text)| declares(text, name)) else { continue };
        let help = format!(
            "`{path}` declares it: pass `--prelude {path}`, or write `prelude = [\"{path}\"]` in \
             landfall.toml",
            path = path.display()
        );
        found.help = Some(help);
    }
}

// The search for the bytes is quick; a text that has them is read for the declaration.
fn declares(text: &str, name: &str) -> bool {
    if memchr::memmem::find(text.as_bytes(), name.as_bytes()).is_none() {
        return false;
    }
    let outline = outline::read(text, &mut Reports::default());
    let index = outline.names.get(name);
    index.is_some_and(|&index| matches!(outline.items[index].class, Class::Struct | Class::Alias))
}

/// The WGSL files in the folder of a shader, without itself.
fn beside(path: &Path, options: &ReadOptions) -> Vec<(PathBuf, String)> {
    let is_other = |other: &Path| other != path && has_language(other, Language::Wgsl);
    let folder = path.parent().unwrap_or(Path::new(""));
    if let Some(files) = &options.files {
        let files = files.iter().map(|(path, text)| (PathBuf::from(path), text.clone()));
        return files.filter(|(path, _)| path.parent() == Some(folder) && is_other(path)).collect();
    }
    let paths = listed(folder).into_iter().filter(|path| is_other(path)).take(MAX_FILES);
    let text = |path: PathBuf| {
        let bytes = read_bytes(&path, Some(MAX_BYTES)).ok()?;
        Some((path, String::from_utf8(bytes).ok()?))
    };
    paths.filter_map(text).collect()
}
