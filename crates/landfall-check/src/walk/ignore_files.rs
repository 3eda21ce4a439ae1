//! The rules of ignore files, read as git reads them.
//!
//! In order of precedence: `.ignore`, `.gitignore`, `.git/info/exclude`, and the file that git's
//! `core.excludesFile` names. In each kind the file nearest to the entry precedes. The last three
//! count in a repository only, from its root on.
//!
//! Of git's settings, `[include]` and `core.ignoreCase` are not followed.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use landfall_layout::file::{MAX_BYTES, read_whole};
use landfall_layout::text::glob::Glob;

use super::slashes;

/// The ignore files that apply to the entries of a directory.
#[derive(Default)]
pub struct IgnoreFiles {
    /// Of the directories above the root of a walk, then of those from the root to the entries.
    folders: Vec<Folder>,
    above: usize,
}

/// The ignore files of a directory.
struct Folder {
    base: DirectoryBase,
    /// One of each kind, in order of precedence.
    kinds: [IgnoreFile; 4],
    is_repository: bool,
}

/// Where a directory is.
enum DirectoryBase {
    /// Above the root of the walk. The path from it to the root, and a `/`.
    Above(String),
    /// In the walk. The length of the path from the root to it, and a `/`.
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
            files.read(folder, DirectoryBase::Above(path + "/"))?;
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
        self.read(path, DirectoryBase::Below(length))
    }

    fn read(&mut self, path: &Path, base: DirectoryBase) -> Result<(), PathBuf> {
        let git = path.join(".git");
        let is_repository = git.exists() || path.join(".jj").is_dir();
        let in_repository = is_repository || self.folders.iter().any(|f| f.is_repository);
        let mut kinds = [const { IgnoreFile(Vec::new()) }; 4];
        kinds[0] = IgnoreFile::read(&path.join(".ignore"))?;
        let file = path.join(".gitignore");
        // git does not follow a link of this name.
        if in_repository && !file.is_symlink() {
            kinds[1] = IgnoreFile::read(&file)?;
        }
        if is_repository {
            let common = common_directory(git);
            kinds[2] = IgnoreFile::read(&common.join("info/exclude"))?;
            let of_user = excludes_file(&common.join("config")).map(|file| path.join(file));
            // Often `/dev/null`.
            kinds[3] = of_user.and_then(|file| IgnoreFile::read(&file).ok()).unwrap_or_default();
        }
        self.folders.push(Folder { base, kinds, is_repository });
        Ok(())
    }

    /// Whether there is any rule for the entries of the directory entered last.
    pub fn has_rules(&self) -> bool {
        self.folders.iter().any(Folder::has_rules)
    }

    /// Whether an entry of the directory entered last is ignored; `None` if no rule matches it.
    pub fn ignored(&self, relative: &str, is_folder: bool) -> Option<bool> {
        let mut found = [None; 4];
        let mut in_repository = true;
        // From the nearest directory outwards: beyond the root of the repository only `.ignore`
        // counts.
        for folder in self.folders.iter().rev() {
            if folder.has_rules() {
                let whole;
                let path = match &folder.base {
                    DirectoryBase::Above(root) => {
                        whole = format!("{root}{relative}");
                        &whole
                    }
                    DirectoryBase::Below(length) => &relative[*length..],
                };
                let counted = if in_repository { found.len() } else { 1 };
                for (found, rules) in found.iter_mut().zip(&folder.kinds).take(counted) {
                    *found = found.or_else(|| rules.ignored(path, is_folder));
                }
            }
            in_repository &= !folder.is_repository;
        }
        found.into_iter().flatten().next()
    }
}

impl Folder {
    fn has_rules(&self) -> bool {
        self.kinds.iter().any(|rules| !rules.0.is_empty())
    }
}

/// The directory that holds `info/exclude`; `.git` is a file in submodules and linked worktrees.
fn common_directory(git: PathBuf) -> PathBuf {
    let read = |path: &Path| String::from_utf8(read_whole(path, MAX_BYTES).ok()?).ok();
    let text = if git.is_file() { read(&git) } else { None };
    let Some(own) = text.as_deref().and_then(|text| text.strip_prefix("gitdir:")) else {
        return git;
    };
    // A linked work tree has a directory of its own, which names the common one.
    let own = git.parent().unwrap_or(Path::new("")).join(own.trim());
    match read(&own.join("commondir")) {
        Some(common) => own.join(common.trim()),
        None => own,
    }
}

/// The user's ignore file: the value of `core.excludesFile`, or git's default.
///
/// `local` is the configuration of the repository, which precedes those of the user and the system.
fn excludes_file(local: &Path) -> Option<PathBuf> {
    let variable = |name| env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let home = env::home_dir();
    let in_home = |name: &str| home.as_ref().map(|home| home.join(name));
    let settings = variable("XDG_CONFIG_HOME").or_else(|| in_home(".config"));
    let settings = |name: &str| settings.as_ref().map(|settings| settings.join(name));
    let global = match variable("GIT_CONFIG_GLOBAL") {
        Some(path) => [Some(path), None],
        None => [in_home(".gitconfig"), settings("git/config")],
    };
    let system = variable("GIT_CONFIG_SYSTEM").unwrap_or_else(|| "/etc/gitconfig".into());
    // The first file that sets it counts: git's own order of precedence.
    let files = [Some(local.to_path_buf())].into_iter().chain(global).chain([Some(system)]);
    let configured = files.flatten().find_map(|path| {
        excludes_setting(&String::from_utf8_lossy(&read_whole(&path, MAX_BYTES).ok()?))
    });
    match configured {
        Some(path) => match (path.strip_prefix("~/"), &home) {
            (Some(rest), Some(home)) => Some(home.join(rest)),
            _ => Some(PathBuf::from(path)),
        },
        None => settings("git/ignore"),
    }
}

/// The value of `excludesFile` in the section `[core]` of a configuration of git.
fn excludes_setting(text: &str) -> Option<String> {
    let mut is_core = false;
    let mut value = None;
    for line in text.lines() {
        let mut line = line.trim();
        if let Some((section, rest)) = line.strip_prefix('[').and_then(|line| line.split_once(']'))
        {
            is_core = section.trim().eq_ignore_ascii_case("core");
            line = rest;
        }
        let Some((key, set)) = line.split_once('=').filter(|_| is_core) else { continue };
        if key.trim().eq_ignore_ascii_case("excludesfile") {
            value = Some(setting(set.trim()));
        }
    }
    value
}

/// A value of git's configuration, without quotation marks and the comment behind it.
fn setting(text: &str) -> String {
    let mut out = String::new();
    let mut signs = text.chars();
    let mut is_quoted = false;
    while let Some(sign) = signs.next() {
        match sign {
            '"' => is_quoted = !is_quoted,
            '#' | ';' if !is_quoted => break,
            '\\' => out.extend(signs.next()),
            sign => out.push(sign),
        }
    }
    // Trailing spaces count inside of quotation marks.
    out.truncate(if text.ends_with('"') { out.len() } else { out.trim_end().len() });
    out
}

#[derive(Default)]
struct IgnoreFile(Vec<IgnoreRule>);

impl IgnoreFile {
    /// Reads a file; one that is missing, unreadable, too large or a directory has no rules.
    ///
    /// # Errors
    ///
    /// The file is a pipe or a device, so that reading it may never end.
    fn read(path: &Path) -> Result<IgnoreFile, PathBuf> {
        let Ok(found) = fs::metadata(path) else { return Ok(IgnoreFile::default()) };
        if !found.is_file() && !found.is_dir() {
            return Err(path.to_path_buf());
        }
        let bytes = read_whole(path, MAX_BYTES).unwrap_or_default();
        let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(&bytes);
        let lines = bytes.split(|byte| *byte == b'\n');
        let lines = lines.filter_map(|line| str::from_utf8(line).ok());
        Ok(IgnoreFile(lines.filter_map(IgnoreRule::from_line).collect()))
    }

    fn ignored(&self, path: &str, is_folder: bool) -> Option<bool> {
        let name = path.rsplit('/').next().unwrap_or(path);
        // The last line that matches decides: gitignore(5).
        let mut rules = self.0.iter().rev();
        rules.find(|rule| rule.matches(path, name, is_folder)).map(|rule| !rule.negated)
    }
}

#[derive(Debug)]
struct IgnoreRule {
    pattern: IgnorePattern,
    /// Whether it is matched with the name alone.
    is_name: bool,
    only_folders: bool,
    negated: bool,
}

#[derive(Debug)]
enum IgnorePattern {
    Literal(String),
    Glob(Glob),
}

impl IgnoreRule {
    /// Parses a line; `None` for one that matches nothing.
    fn from_line(line: &str) -> Option<IgnoreRule> {
        let line = without_spaces(line.strip_suffix('\r').unwrap_or(line));
        if line.starts_with('#') {
            return None;
        }
        // `!` negates, a `/` at the end means directories only, and one elsewhere anchors the
        // pattern: gitignore(5).
        let (line, negated) = line.strip_prefix('!').map_or((line, false), |rest| (rest, true));
        let (line, only_folders) =
            line.strip_suffix('/').map_or((line, false), |rest| (rest, true));
        let is_name = !line.contains('/');
        let line = line.strip_prefix('/').unwrap_or(line);
        if line.is_empty() {
            return None;
        }
        let pattern = if line.contains(['*', '?', '[', '\\']) {
            IgnorePattern::Glob(Glob::escaped(&glob(line)).ok()?)
        } else {
            IgnorePattern::Literal(line.to_string())
        };
        Some(IgnoreRule { pattern, is_name, only_folders, negated })
    }

    fn matches(&self, path: &str, name: &str, is_folder: bool) -> bool {
        if self.only_folders && !is_folder {
            return false;
        }
        let part = if self.is_name { name } else { path };
        match &self.pattern {
            IgnorePattern::Literal(text) => text == part,
            IgnorePattern::Glob(glob) => glob.matches(part),
        }
    }
}

/// A line without the spaces at its end that no `\` escapes.
fn without_spaces(mut line: &str) -> &str {
    while let Some(rest) = line.strip_suffix(' ') {
        // An odd number of `\` escapes the space.
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
            // A class starts no range.
            if rest.starts_with('-') {
                out.push('\\');
            }
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
                length += usize::from(rest[length..].starts_with(['!', '^']));
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
                // Two stars mean directories only where they are a whole component.
                out.push_str(if length > 1 && is_component { "**" } else { "*" });
            }
            sign => out.push(sign),
        }
        rest = &rest[length..];
    }
    out
}
