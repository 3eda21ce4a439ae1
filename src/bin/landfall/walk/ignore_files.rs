//! The rules of ignore files, read as git reads them.
//!
//! A `.ignore` precedes every `.gitignore`, and this `.git/info/exclude` and the user's own ignore
//! file; in each kind the file nearest to the entry precedes. The last three count in a repository
//! only, from its root on.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use landfall_lint::glob::Glob;

use super::slashes;

/// The ignore files that apply to the entries of a directory.
#[derive(Default)]
pub struct IgnoreFiles {
    /// Of the directories above the root of a walk, then of those from the root to the entries.
    folders: Vec<Folder>,
    above: usize,
    user: Option<Rules>,
}

/// The ignore files of a directory.
struct Folder {
    base: Base,
    ignore: Rules,
    gitignore: Rules,
    exclude: Rules,
    is_repository: bool,
}

/// Where a directory is.
enum Base {
    /// Above the root of the walk, which has this path from it, with a `/` at its end.
    Above(String),
    /// Below the root; its path from there, with a `/`, has this length.
    Below(usize),
}

impl IgnoreFiles {
    /// Reads the ignore files of the directories above the root of a walk.
    ///
    /// # Errors
    ///
    /// The ignore file that is not a regular file.
    pub fn above(root: &Path) -> Result<IgnoreFiles, PathBuf> {
        let root = fs::canonicalize(root).unwrap_or_else(|_| root.to_path_buf());
        let mut files = IgnoreFiles::default();
        let mut above: Vec<&Path> = root.ancestors().skip(1).collect();
        above.reverse();
        for folder in above {
            let path = root.strip_prefix(folder).map(slashes).unwrap_or_default();
            files.read(folder, Base::Above(path + "/"))?;
        }
        files.above = files.folders.len();
        Ok(files)
    }

    /// Leaves the directories that do not contain an entry; the root of the walk has depth zero.
    pub fn leave(&mut self, depth: usize) {
        self.folders.truncate(self.above + depth);
    }

    /// Reads the ignore files of a directory with this path from the root, before the entries in it.
    ///
    /// # Errors
    ///
    /// The ignore file that is not a regular file.
    pub fn enter(&mut self, path: &Path, relative: &str) -> Result<(), PathBuf> {
        let length = if relative.is_empty() { 0 } else { relative.len() + 1 };
        self.read(path, Base::Below(length))
    }

    fn read(&mut self, path: &Path, base: Base) -> Result<(), PathBuf> {
        let git = path.join(".git");
        let is_repository = git.exists() || path.join(".jj").is_dir();
        let in_repository = is_repository || self.folders.iter().any(|f| f.is_repository);
        let mut folder = Folder {
            base,
            ignore: Rules::read(&path.join(".ignore"))?,
            gitignore: Rules::default(),
            exclude: Rules::default(),
            is_repository,
        };
        if in_repository {
            folder.gitignore = Rules::read(&path.join(".gitignore"))?;
        }
        if is_repository {
            folder.exclude = Rules::read(&common_directory(git).join("info/exclude"))?;
            if self.user.is_none() {
                self.user = Some(Rules::of_user()?);
            }
        }
        self.folders.push(folder);
        Ok(())
    }

    /// Whether there is any rule for the entries of the directory entered last.
    pub fn has_rules(&self) -> bool {
        let has_rules = |f: &Folder| {
            !(f.ignore.0.is_empty() && f.gitignore.0.is_empty() && f.exclude.0.is_empty())
        };
        self.user.as_ref().is_some_and(|user| !user.0.is_empty())
            || self.folders.iter().any(has_rules)
    }

    /// Whether an entry of the directory entered last is ignored; `None` if no rule matches it.
    pub fn ignored(&self, relative: &str, is_folder: bool) -> Option<bool> {
        let mut found = [None; 4];
        let mut in_repository = true;
        for folder in self.folders.iter().rev() {
            let whole;
            let path = match &folder.base {
                Base::Above(root) => {
                    whole = format!("{root}{relative}");
                    &whole
                }
                Base::Below(length) => &relative[*length..],
            };
            let mut look = |kind: usize, rules: &Rules| {
                found[kind] = found[kind].or_else(|| rules.ignored(path, is_folder));
            };
            look(0, &folder.ignore);
            if in_repository {
                look(1, &folder.gitignore);
                look(2, &folder.exclude);
            }
            if in_repository && folder.is_repository {
                self.user.iter().for_each(|user| look(3, user));
                in_repository = false;
            }
        }
        found.into_iter().flatten().next()
    }
}

/// The directory that holds `info/exclude`; `.git` is a file in submodules and linked worktrees.
fn common_directory(git: PathBuf) -> PathBuf {
    let Some(text) = git.is_file().then(|| fs::read_to_string(&git).ok()).flatten() else {
        return git;
    };
    let folder = git.parent().unwrap_or(Path::new(""));
    let own = folder.join(text.trim().strip_prefix("gitdir:").unwrap_or_default().trim());
    let common = own.join("commondir");
    match common.is_file().then(|| fs::read_to_string(common).ok()).flatten() {
        Some(text) => own.join(text.trim()),
        None => own,
    }
}

/// The lines of an ignore file.
#[derive(Default)]
struct Rules(Vec<Rule>);

impl Rules {
    /// Reads a file; one that is missing, unreadable or a directory has no rules.
    ///
    /// # Errors
    ///
    /// The file is a pipe or a device, so that reading it may never end.
    fn read(path: &Path) -> Result<Rules, PathBuf> {
        let Ok(found) = fs::metadata(path) else { return Ok(Rules::default()) };
        if !found.is_file() && !found.is_dir() {
            return Err(path.to_path_buf());
        }
        let bytes = fs::read(path).unwrap_or_default();
        Ok(Rules::of(&String::from_utf8_lossy(&bytes)))
    }

    fn of(text: &str) -> Rules {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        Rules(text.lines().filter_map(Rule::of).collect())
    }

    /// The rules of the file that `core.excludesFile` names, or of git's default.
    fn of_user() -> Result<Rules, PathBuf> {
        let variable = |name| env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
        let home = env::home_dir();
        let in_home = |name: &str| home.as_ref().map(|home| home.join(name));
        let settings = variable("XDG_CONFIG_HOME").or_else(|| in_home(".config"));
        let settings = |name: &str| settings.as_ref().map(|settings| settings.join(name));
        let global = match variable("GIT_CONFIG_GLOBAL") {
            Some(path) => vec![path],
            None => in_home(".gitconfig").into_iter().chain(settings("git/config")).collect(),
        };
        let system = variable("GIT_CONFIG_SYSTEM").unwrap_or_else(|| "/etc/gitconfig".into());
        let configured = global.iter().chain([&system]).find_map(|path| {
            let is_file = path.metadata().is_ok_and(|data| data.is_file());
            excludes_file(&fs::read_to_string(path).ok().filter(|_| is_file)?)
        });
        let file = match configured {
            Some(path) => match (path.strip_prefix("~/"), &home) {
                (Some(rest), Some(home)) => Some(home.join(rest)),
                _ => Some(PathBuf::from(path)),
            },
            None => settings("git/ignore"),
        };
        file.map_or_else(|| Ok(Rules::default()), |file| Rules::read(&file))
    }

    fn ignored(&self, path: &str, is_folder: bool) -> Option<bool> {
        let mut rules = self.0.iter().rev();
        rules.find(|rule| rule.matches(path, is_folder)).map(|rule| !rule.negated)
    }
}

/// The value of `excludesFile` in the section `[core]` of git's configuration.
fn excludes_file(text: &str) -> Option<String> {
    let mut is_core = false;
    let mut value = None;
    for line in text.lines().map(str::trim) {
        if line.starts_with('[') {
            is_core = line.eq_ignore_ascii_case("[core]");
        } else if let Some((key, path)) = line.split_once('=').filter(|_| is_core) {
            if key.trim().eq_ignore_ascii_case("excludesfile") {
                value = Some(path.trim().trim_matches('"').to_string());
            }
        }
    }
    value
}

/// A line of an ignore file.
#[derive(Debug)]
struct Rule {
    pattern: Pattern,
    /// Whether it is matched with the name alone.
    is_name: bool,
    only_folders: bool,
    negated: bool,
}

#[derive(Debug)]
enum Pattern {
    Literal(String),
    Glob(Glob),
}

impl Rule {
    /// Parses a line; `None` for one that matches nothing.
    fn of(line: &str) -> Option<Rule> {
        let line = without_spaces(line);
        if line.starts_with('#') {
            return None;
        }
        let (line, negated) = line.strip_prefix('!').map_or((line, false), |rest| (rest, true));
        let (line, only_folders) =
            line.strip_suffix('/').map_or((line, false), |rest| (rest, true));
        let is_name = !line.contains('/');
        let line = line.strip_prefix('/').unwrap_or(line);
        if line.is_empty() {
            return None;
        }
        let pattern = if line.contains(['*', '?', '[', '\\']) {
            Pattern::Glob(Glob::escaped(&glob(line)).ok()?)
        } else {
            Pattern::Literal(line.to_string())
        };
        Some(Rule { pattern, is_name, only_folders, negated })
    }

    fn matches(&self, path: &str, is_folder: bool) -> bool {
        if self.only_folders && !is_folder {
            return false;
        }
        let part = if self.is_name { path.rsplit('/').next().unwrap_or(path) } else { path };
        match &self.pattern {
            Pattern::Literal(text) => text == part,
            Pattern::Glob(glob) => glob.matches(part),
        }
    }
}

/// A line without the spaces at its end that no `\` escapes.
fn without_spaces(mut line: &str) -> &str {
    while let Some(rest) = line.strip_suffix(' ') {
        if rest.bytes().rev().take_while(|b| *b == b'\\').count() % 2 == 1 {
            break;
        }
        line = rest;
    }
    line
}

/// The named classes of characters within brackets, as ranges. None starts with the `!` of negation.
const CLASSES: [(&str, &str); 12] = [
    ("[:alnum:]", "0-9A-Za-z"),
    ("[:alpha:]", "A-Za-z"),
    ("[:blank:]", " \t"),
    ("[:cntrl:]", "\u{0}-\u{1f}\u{7f}"),
    ("[:digit:]", "0-9"),
    ("[:graph:]", "\"-~!"),
    ("[:lower:]", "a-z"),
    ("[:print:]", " -~"),
    ("[:punct:]", "\"-/:-@\\[-`{-~!"),
    ("[:space:]", " \t-\r"),
    ("[:upper:]", "A-Z"),
    ("[:xdigit:]", "0-9A-Fa-f"),
];

/// The pattern of a line as a glob: braces mean nothing in it, and stars within a name are one.
fn glob(line: &str) -> String {
    let mut out = String::with_capacity(line.len() + 8);
    let mut rest = line;
    let mut in_class = false;
    while let Some(sign) = rest.chars().next() {
        let class = CLASSES.iter().find(|(name, _)| in_class && rest.starts_with(name));
        if let Some((name, ranges)) = class {
            out.push_str(ranges);
            rest = &rest[name.len()..];
            continue;
        }
        let mut length = sign.len_utf8();
        match sign {
            '\\' => {
                length += rest[length..].chars().next().map_or(0, char::len_utf8);
                out.push_str(&rest[..length]);
            }
            '[' if !in_class => {
                in_class = true;
                // A `]` at the start of a class is a member of it.
                length +=
                    rest[length..].len() - rest[length..].trim_start_matches(['!', '^']).len();
                length += usize::from(rest[length..].starts_with(']'));
                out.push_str(&rest[..length]);
            }
            ']' => {
                in_class = false;
                out.push(sign);
            }
            '{' | '}' if !in_class => out.extend(['\\', sign]),
            '*' if !in_class => {
                length = rest.len() - rest.trim_start_matches('*').len();
                let is_component = (out.is_empty() || out.ends_with('/'))
                    && (rest.len() == length || rest[length..].starts_with('/'));
                out.push_str(if length > 1 && is_component { "**" } else { "*" });
            }
            sign => out.push(sign),
        }
        rest = &rest[length..];
    }
    out
}
