//! `--link PATH`: a name of the user's choice for the pseudo-terminal.

use std::path::{Path, PathBuf};

/// A symbolic link that goes when this is dropped, if it is still ours.
#[derive(Debug)]
pub(super) struct Link {
    link: PathBuf,
    to: PathBuf,
}

impl Link {
    /// Makes the link. One that points nowhere, or to a pseudo-terminal, was left behind by an earlier run and is replaced; anything else
    /// in its place is somebody's.
    pub fn make(link: &Path, to: &str) -> Result<Link, String> {
        let fail = |why: &str, next: &str| {
            format!("--link {}: cannot be made: {why}. {next}", link.display())
        };
        match std::fs::read_link(link) {
            Ok(old) if old.starts_with("/dev/pts") || !link.exists() => {
                std::fs::remove_file(link)
                    .map_err(|e| fail(&e.to_string(), "Remove it, or choose another name"))?;
            }
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {}
            _ => {
                return Err(fail(
                    "something else is there",
                    "Remove it, or choose another name",
                ));
            }
        }
        std::os::unix::fs::symlink(to, link)
            .map_err(|e| fail(&e.to_string(), "Choose a place where you may write"))?;
        Ok(Link {
            link: link.to_path_buf(),
            to: PathBuf::from(to),
        })
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        if std::fs::read_link(&self.link).is_ok_and(|to| to == self.to) {
            // Nothing can be done about one that stays; the next run replaces it.
            let _ = std::fs::remove_file(&self.link);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_link_comes_and_goes_and_takes_no_place_of_others() {
        let dir = tempfile::tempdir().unwrap();
        let at = dir.path().join("mill");
        let link = Link::make(&at, "/dev/pts/41").unwrap();
        assert_eq!(std::fs::read_link(&at).unwrap(), Path::new("/dev/pts/41"));
        // Another run with the same name takes it over, and the first one leaves it alone then.
        let second = Link::make(&at, "/dev/pts/42").unwrap();
        drop(link);
        assert_eq!(std::fs::read_link(&at).unwrap(), Path::new("/dev/pts/42"));
        drop(second);
        assert!(std::fs::read_link(&at).is_err());
        // Somebody's file, somebody's link, no such folder.
        std::fs::write(&at, "mine").unwrap();
        let refused = Link::make(&at, "/dev/pts/43").unwrap_err();
        assert_eq!(
            refused,
            format!(
                "--link {}: cannot be made: something else is there. Remove it, or choose another name",
                at.display()
            )
        );
        let theirs = dir.path().join("theirs");
        std::os::unix::fs::symlink(&at, &theirs).unwrap();
        assert!(Link::make(&theirs, "/dev/pts/43").is_err());
        assert_eq!(std::fs::read_to_string(&theirs).unwrap(), "mine");
        let refused = Link::make(&dir.path().join("no/mill"), "/dev/pts/43").unwrap_err();
        assert!(
            refused.ends_with("Choose a place where you may write"),
            "{refused}"
        );
    }
}
