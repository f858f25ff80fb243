//! The user's own machines and dialects: which directories are looked through, and a word on what was taken from where.

use super::output::say;
use crate::machine::search::{self, Directories, Origin};
use crate::machine::{self, DataError, Machine};
use crate::post::{self, Post};
use std::ffi::OsString;
use std::path::PathBuf;

/// The directories that the environment names, first to last: those of `MORSEMILL_MACHINES` and `MORSEMILL_POSTS` (path lists, as `PATH`
/// is one), then `machines` and `posts` in the user's configuration directory: `%APPDATA%\morsemill` on Windows, elsewhere
/// `$XDG_CONFIG_HOME/morsemill`, or `~/.config/morsemill`. `variable` answers for the environment.
pub fn directories(variable: impl Fn(&str) -> Option<OsString>) -> Directories {
    let filled = |name: &str| variable(name).filter(|v| !v.is_empty());
    let configuration = if cfg!(windows) {
        filled("APPDATA").map(PathBuf::from)
    } else {
        // A relative path there is to be ignored (XDG Base Directory Specification).
        filled("XDG_CONFIG_HOME")
            .map(PathBuf::from)
            .filter(|p| p.is_absolute())
            .or_else(|| filled("HOME").map(|h| PathBuf::from(h).join(".config")))
    };
    let all = |list: &str, folder: &str| {
        let mut out: Vec<PathBuf> = filled(list)
            .map(|v| std::env::split_paths(&v).collect())
            .unwrap_or_default();
        out.retain(|p| !p.as_os_str().is_empty());
        out.extend(
            configuration
                .iter()
                .map(|c| c.join("morsemill").join(folder)),
        );
        out
    };
    Directories {
        machines: all("MORSEMILL_MACHINES", "machines"),
        posts: all("MORSEMILL_POSTS", "posts"),
    }
}

/// Hands the environment's directories to whoever looks for files, and warns of one that was named and is not there: what it should
/// hold would otherwise be passed over without a word.
pub fn hand_in() {
    for list in ["MORSEMILL_MACHINES", "MORSEMILL_POSTS"] {
        let named = std::env::var_os(list).unwrap_or_default();
        for path in std::env::split_paths(&named) {
            if !path.as_os_str().is_empty() && !path.is_dir() {
                say(&format!(
                    "morsemill: warning: {list} names {}, which is no directory: nothing is taken from there",
                    path.display()
                ));
            }
        }
    }
    search::hand_in(directories(|name| std::env::var_os(name)));
}

/// [`Machine::load`], with a word when it is not a built-in one.
pub fn machine(name_or_path: &str) -> Result<Machine, DataError> {
    tell(
        "machine",
        "machines",
        machine::BUILT_IN.as_slice(),
        name_or_path,
    );
    Machine::load(name_or_path)
}

/// [`Post::load`], with a word when it is not a built-in one.
pub fn post(name_or_path: &str) -> Result<Post, DataError> {
    tell("post", "posts", post::BUILT_IN.as_slice(), name_or_path);
    Post::load(name_or_path)
}

fn tell(kind: &str, folder: &str, built_in: &[(&str, &str)], name_or_path: &str) {
    let origin = search::locate(search::directories(folder), built_in, name_or_path);
    if let Some(line) = origin.and_then(|o| word(kind, name_or_path, &o)) {
        say(&line);
    }
}

/// What to say of an origin; nothing for a built-in one, nor for a file that the user named by its path.
fn word(kind: &str, name: &str, origin: &Origin) -> Option<String> {
    let Origin::Own { path, shadows } = origin else {
        return None;
    };
    let instead = if *shadows {
        ", which stands before the built-in one of that name"
    } else {
        ""
    };
    Some(format!("{kind} {name}: {}{instead}", path.display()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn under(variables: &[(&str, &str)]) -> Directories {
        directories(|name| {
            let found = variables.iter().find(|(n, _)| *n == name)?;
            Some(OsString::from(found.1))
        })
    }

    #[cfg(unix)]
    #[test]
    fn the_lists_come_before_the_configuration_directory() {
        let paths = |p: &[&str]| p.iter().map(PathBuf::from).collect::<Vec<_>>();
        let d = under(&[("MORSEMILL_MACHINES", "/a:/b"), ("HOME", "/home/me")]);
        assert_eq!(
            d.machines,
            paths(&["/a", "/b", "/home/me/.config/morsemill/machines"])
        );
        assert_eq!(d.posts, paths(&["/home/me/.config/morsemill/posts"]));
        let d = under(&[("XDG_CONFIG_HOME", "/etc/mine"), ("HOME", "/home/me")]);
        assert_eq!(d.machines, paths(&["/etc/mine/morsemill/machines"]));
        let d = under(&[("XDG_CONFIG_HOME", "relative"), ("HOME", "/home/me")]);
        assert_eq!(d.posts, paths(&["/home/me/.config/morsemill/posts"]));
        assert_eq!(under(&[]), Directories::default());
        let d = under(&[("MORSEMILL_POSTS", ":/a::"), ("HOME", "")]);
        assert_eq!(d.posts, paths(&["/a"]));
    }

    #[test]
    fn a_file_of_the_users_own_is_said_and_what_it_hides() {
        let own = |shadows| Origin::Own {
            path: "/m/mine.toml".into(),
            shadows,
        };
        assert_eq!(
            word("machine", "mine", &own(false)).unwrap(),
            "machine mine: /m/mine.toml"
        );
        assert_eq!(
            word("post", "grbl", &own(true)).unwrap(),
            "post grbl: /m/mine.toml, which stands before the built-in one of that name"
        );
        assert_eq!(word("post", "grbl", &Origin::BuiltIn), None);
        assert_eq!(
            word("post", "./x.toml", &Origin::Named("./x.toml".into())),
            None
        );
    }
}
