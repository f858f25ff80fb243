//! Where a machine or a dialect is looked for by name: the user's own directories first, then what comes with the program.
//!
//! Crosses the border: directories, handed in once by `cli` (which alone reads the environment), and a name in; a file or the built-in
//! text out. Never knows what such a file means.

use super::data::{DataError, MOST_BYTES};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Directories of the user's own files, the first one wins.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Directories {
    /// Of machines.
    pub machines: Vec<PathBuf>,
    /// Of dialects.
    pub posts: Vec<PathBuf>,
}

static HANDED_IN: OnceLock<Directories> = OnceLock::new();

/// Hands in the user's directories, once and before anything is looked for; a second call changes nothing. Without it only what is
/// built in is found by name.
pub fn hand_in(directories: Directories) {
    let _ = HANDED_IN.set(directories);
}

/// The user's directories for `folder` ("machines" or "posts").
pub fn directories(folder: &str) -> &'static [PathBuf] {
    match (HANDED_IN.get(), folder) {
        (Some(d), "machines") => &d.machines,
        (Some(d), "posts") => &d.posts,
        _ => &[],
    }
}

/// Where a machine or a dialect comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// It came with the program.
    BuiltIn,
    /// A file that was named by its path.
    Named(PathBuf),
    /// A file of that name in one of the user's directories.
    Own {
        /// The file.
        path: PathBuf,
        /// True when it stands before a built-in one of the same name.
        shadows: bool,
    },
}

/// True for what names a file, not one of a list: anything with a `/` or `\`, or ending in `.toml`.
pub fn is_path(name_or_path: &str) -> bool {
    name_or_path.contains(['/', '\\']) || name_or_path.ends_with(".toml")
}

/// Where `name_or_path` would be taken from; `None` when it is no path and nowhere to be found. A file that is there but cannot be read
/// is taken all the same, so that nobody gets another machine than the one asked for.
pub fn locate(
    directories: &[PathBuf],
    built_in: &[(&str, &str)],
    name_or_path: &str,
) -> Option<Origin> {
    if is_path(name_or_path) {
        return Some(Origin::Named(PathBuf::from(name_or_path)));
    }
    let shadows = built_in.iter().any(|(n, _)| *n == name_or_path);
    // A colon would leave the directory on Windows ("C:mine").
    let nameable = !name_or_path.is_empty() && !name_or_path.contains(':');
    let own = directories
        .iter()
        .filter(|_| nameable)
        .map(|d| d.join(format!("{name_or_path}.toml")))
        .find(|p| is_there(p));
    match own {
        Some(path) => Some(Origin::Own { path, shadows }),
        None => shadows.then_some(Origin::BuiltIn),
    }
}

/// False only when it is certain that there is no such file.
fn is_there(path: &Path) -> bool {
    use std::io::ErrorKind::{InvalidInput, NotADirectory, NotFound};
    match std::fs::symlink_metadata(path) {
        Ok(_) => true,
        Err(e) => !matches!(e.kind(), NotFound | NotADirectory | InvalidInput),
    }
}

/// The names of the files in the user's directories, by rising name, each once. Directories that cannot be listed hold none.
pub fn own_names(directories: &[PathBuf]) -> Vec<String> {
    let mut names: Vec<String> = directories
        .iter()
        .filter_map(|d| std::fs::read_dir(d).ok())
        .flatten()
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|file| file.strip_suffix(".toml").map(str::to_string))
        .filter(|name| !name.is_empty() && !name.starts_with('.'))
        .collect();
    names.sort();
    names.dedup();
    names
}

/// [`super::data::find`] in the directories given.
pub fn find_in(
    directories: &[PathBuf],
    kind: &str,
    folder: &str,
    built_in: &[(&str, &str)],
    name_or_path: &str,
) -> Result<(String, String, String), DataError> {
    let named = name_or_path.to_string();
    match locate(directories, built_in, name_or_path) {
        Some(Origin::Named(path)) => {
            let stem = path
                .file_stem()
                .map_or_else(|| named.clone(), |s| s.to_string_lossy().into_owned());
            let text = read(kind, &path)?;
            Ok((stem, named, text))
        }
        Some(Origin::Own { path, .. }) => {
            let text = read(kind, &path)?;
            Ok((named, path.display().to_string(), text))
        }
        Some(Origin::BuiltIn) | None => {
            if let Some((name, text)) = built_in.iter().find(|(n, _)| *n == name_or_path) {
                let file = format!("{folder}/{name}.toml");
                return Ok((named, file, text.to_string()));
            }
            let mut known = own_names(directories);
            known.extend(built_in.iter().map(|(n, _)| n.to_string()));
            known.sort();
            known.dedup();
            Err(DataError::UnknownName {
                kind: kind.to_string(),
                nearest: super::data::nearest(&named, known.iter().map(String::as_str)),
                name: named,
                known,
            })
        }
    }
}

/// The text of a data file.
fn read(kind: &str, path: &Path) -> Result<String, DataError> {
    let refuse = |problem: String| DataError::Unreadable {
        kind: kind.to_string(),
        path: path.display().to_string(),
        problem,
    };
    let meta = std::fs::metadata(path).map_err(|e| refuse(e.to_string()))?;
    if !meta.is_file() {
        return Err(refuse("it is not a file: name a .toml file".to_string()));
    }
    if meta.len() > MOST_BYTES as u64 {
        return Err(refuse(format!(
            "it has {} bytes, and such a file is a page of text: is this the right file?",
            meta.len()
        )));
    }
    let bytes = std::fs::read(path).map_err(|e| refuse(e.to_string()))?;
    String::from_utf8(bytes)
        .map_err(|_| refuse("it is not text (UTF-8): is this the right file?".to_string()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const BUILT_IN: [(&str, &str); 2] = [("mill", "the mill"), ("router", "the router")];

    fn find(directories: &[PathBuf], name: &str) -> Result<(String, String, String), DataError> {
        find_in(directories, "machine", "machines", &BUILT_IN, name)
    }

    #[test]
    fn the_first_directory_wins_then_the_next_then_what_is_built_in() {
        let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let dirs = [a.path().to_path_buf(), b.path().to_path_buf()];
        assert_eq!(
            find(&dirs, "mill").unwrap().1,
            "machines/mill.toml",
            "empty directories"
        );
        std::fs::write(b.path().join("mill.toml"), "b").unwrap();
        assert_eq!(find(&dirs, "mill").unwrap().2, "b");
        std::fs::write(a.path().join("mill.toml"), "a").unwrap();
        let path = a.path().join("mill.toml");
        assert_eq!(
            find(&dirs, "mill").unwrap(),
            ("mill".into(), path.display().to_string(), "a".into())
        );
        let shadows = true;
        assert_eq!(
            locate(&dirs, &BUILT_IN, "mill"),
            Some(Origin::Own { path, shadows })
        );
        assert_eq!(locate(&dirs, &BUILT_IN, "router"), Some(Origin::BuiltIn));
        assert_eq!(locate(&[], &BUILT_IN, "mill"), Some(Origin::BuiltIn));
        std::fs::write(b.path().join("my own.toml"), "c").unwrap();
        assert!(matches!(
            locate(&dirs, &BUILT_IN, "my own"),
            Some(Origin::Own { shadows: false, .. })
        ));
        assert_eq!(locate(&dirs, &BUILT_IN, "none"), None);
    }

    #[test]
    fn a_path_is_taken_as_it_is() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("mill.toml");
        std::fs::write(&path, "here").unwrap();
        let named = path.display().to_string();
        assert_eq!(
            find(&[], &named).unwrap(),
            ("mill".into(), named.clone(), "here".into())
        );
        let elsewhere = tempfile::tempdir().unwrap();
        let e = find(&[dir.path().to_path_buf()], "./mill.toml").unwrap_err();
        assert!(
            e.to_string()
                .starts_with("./mill.toml: cannot be read as a machine: "),
            "{e}"
        );
        assert!(own_names(&[elsewhere.path().to_path_buf()]).is_empty());
    }

    #[test]
    fn a_file_that_is_there_but_no_good_is_not_passed_over() {
        let dir = tempfile::tempdir().unwrap();
        let dirs = [dir.path().to_path_buf()];
        std::fs::create_dir(dir.path().join("mill.toml")).unwrap();
        let e = find(&dirs, "mill").unwrap_err().to_string();
        assert!(
            e.ends_with(
                "mill.toml: cannot be read as a machine: it is not a file: name a .toml file"
            ),
            "{e}"
        );
        std::fs::write(dir.path().join("router.toml"), [0xff, 0xfe, 0]).unwrap();
        let e = find(&dirs, "router").unwrap_err().to_string();
        assert!(e.contains("it is not text (UTF-8)"), "{e}");
        let big = vec![b'#'; MOST_BYTES + 1];
        std::fs::write(dir.path().join("router.toml"), big).unwrap();
        let e = find(&dirs, "router").unwrap_err().to_string();
        assert!(
            e.contains("it has 65537 bytes, and such a file is a page of text"),
            "{e}"
        );
    }

    #[test]
    fn an_unknown_name_lists_the_users_own_too() {
        let dir = tempfile::tempdir().unwrap();
        let dirs = [
            dir.path().join("no such directory"),
            dir.path().to_path_buf(),
        ];
        for name in ["bench.toml", "mill.toml", "notes.txt", ".hidden.toml"] {
            std::fs::write(dir.path().join(name), "").unwrap();
        }
        let e = find(&dirs, "bensh").unwrap_err().to_string();
        assert_eq!(
            e,
            "machine \"bensh\" is not known (did you mean \"bench\"?); there are bench, mill, router; a file of your own is named by its path, e.g. ./bensh.toml"
        );
        for odd in ["", "..", "C:mill", "mill\0"] {
            assert!(
                matches!(find(&dirs, odd), Err(DataError::UnknownName { .. })),
                "{odd:?}"
            );
        }
    }
}
