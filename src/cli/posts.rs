//! `morsemill posts`: dialects listed, shown, checked, and begun anew.

use super::Failure;
use super::output::{say, to_stdout};
use crate::gcode::{Interpreter, Reading};
use crate::machine::DataError;
use crate::machine::{data, proofread, search};
use crate::post::specimen::specimen;
use crate::post::{Adapter, BUILT_IN, Post, Rewrite, specimen_text};
use crate::verify::{Spelling, VerifyError, Witness, dialect_of, worst_state};
use clap::Subcommand;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What `morsemill posts` is asked for.
#[derive(Debug, clap::Args)]
pub struct PostsArgs {
    #[command(subcommand)]
    ask: Option<Ask>,
    /// A directory with posts of your own; may be given more than once
    #[arg(long = "posts", value_name = "DIR", global = true)]
    directories: Vec<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Ask {
    /// All dialects by name (what `posts` alone does)
    List,
    /// A dialect's file, comments and all
    Show {
        /// Name of a post, or a file
        #[arg(value_name = "NAME|FILE")]
        name: String,
        /// A small program written with it instead
        #[arg(long)]
        program: bool,
    },
    /// Judges a post of your own: every complaint with its line, or a small program written with it
    Check {
        /// The file
        file: PathBuf,
    },
    /// Begins a post of your own as a copy of another, comments and all
    New {
        /// The post to begin from
        #[arg(long, value_name = "NAME|FILE")]
        from: String,
        /// The new file; it must not exist
        file: PathBuf,
    },
}

/// Carries it out.
pub fn run(args: &PostsArgs) -> Result<ExitCode, Failure> {
    let dirs = &args.directories;
    if let Some(dir) = dirs.iter().find(|d| !d.is_dir()) {
        return Err(Failure::Failed(format!(
            "--posts {}: is no directory",
            dir.display()
        )));
    }
    match args.ask.as_ref().unwrap_or(&Ask::List) {
        Ask::List => {
            let mut all = dirs.clone();
            all.extend_from_slice(search::directories("posts"));
            let (own, bad) = own(&all);
            bad.iter().for_each(|line| say(line));
            to_stdout(|w| list(w, &own))
        }
        Ask::Show { name, program } => {
            let (name, file, text) = find(name, dirs)?;
            if !program {
                return to_stdout(|w| w.write_all(text.as_bytes()));
            }
            let post = Post::named(&name, &file, &text).map_err(Failure::failed)?;
            let text = specimen_text(&post).map_err(Failure::failed)?;
            to_stdout(|w| w.write_all(text.as_bytes()))
        }
        Ask::Check { file } => {
            let (post, program) = check(file)?;
            to_stdout(|w| {
                writeln!(w, "{}: good", file.display())?;
                writeln!(
                    w,
                    "  {}; programs are read back as {}",
                    post.title, post.reader
                )?;
                writeln!(w, "  a small program written with it:")?;
                writeln!(w)?;
                w.write_all(program.as_bytes())
            })
        }
        Ask::New { from, file } => {
            let (name, _, text) = find(from, dirs)?;
            begin(&name, &text, file)?;
            to_stdout(|w| {
                writeln!(w, "{}: begun from {name}", file.display())?;
                writeln!(
                    w,
                    "  edit it, then: morsemill posts check {}",
                    file.display()
                )?;
                writeln!(
                    w,
                    "  use it:        morsemill mill PART --post {}",
                    as_path(file)
                )
            })
        }
    }
}

/// A path that will not be taken for a name.
fn as_path(file: &Path) -> String {
    let text = file.display().to_string();
    match text.contains(['/', '\\']) || text.ends_with(".toml") {
        true => text,
        false => format!("./{text}"),
    }
}

/// Name, name for complaints and text of a post: in the directories first, then wherever posts are found.
fn find(name: &str, dirs: &[PathBuf]) -> Result<(String, String, String), Failure> {
    let plain = !name.contains(['/', '\\', ':']) && !name.ends_with(".toml") && !name.is_empty();
    let own = dirs
        .iter()
        .map(|d| d.join(format!("{name}.toml")))
        .find(|p| plain && p.exists());
    let wanted = own.map_or_else(|| name.to_string(), |p| p.display().to_string());
    data::find("post", "posts", &BUILT_IN, &wanted).map_err(Failure::failed)
}

/// The good posts of the user's directories, by rising name, and a line for each bad one.
fn own(dirs: &[PathBuf]) -> (Vec<Post>, Vec<String>) {
    let mut files: Vec<PathBuf> = dirs
        .iter()
        .filter_map(|d| std::fs::read_dir(d).ok())
        .flat_map(|entries| entries.filter_map(|e| Some(e.ok()?.path())))
        .filter(|p| p.extension().is_some_and(|e| e == "toml"))
        .collect();
    files.sort();
    let (mut good, mut bad) = (Vec::new(), Vec::new());
    for file in files {
        match Post::load(&file.display().to_string()) {
            Ok(post) => good.push(post),
            Err(e) => bad.push(format!("morsemill: not listed: {e}")),
        }
    }
    (good, bad)
}

/// Lists the user's dialects and those that came with the program as text, one a line: name, title. Fails only when `out` does, or
/// when a built-in file is broken (which a test excludes).
pub fn list(out: &mut dyn Write, own: &[Post]) -> io::Result<()> {
    let built_in = BUILT_IN
        .iter()
        .map(|(name, text)| Post::from_toml(name, text))
        .collect::<Result<Vec<_>, DataError>>()
        .map_err(io::Error::other)?;
    let all = || {
        own.iter()
            .map(|p| ('*', p))
            .chain(built_in.iter().map(|p| (' ', p)))
    };
    let width = all().map(|(_, p)| p.name.len()).max().unwrap_or(0);
    writeln!(out, "  {:width$}  what it is", "post")?;
    for (mark, p) in all() {
        writeln!(out, "{mark} {:width$}  {}", p.name, p.title)?;
    }
    writeln!(out)?;
    if !own.is_empty() {
        writeln!(out, "* your own")?;
    }
    writeln!(
        out,
        "A machine names its own post; --post overrides it. A file of your own works as well: --post ./mine.toml\n\
         To begin one: morsemill posts new --from grbl mine.toml"
    )
}

/// A user's post and a small program written with it. A bad one is rejected with all that is wrong.
fn check(file: &Path) -> Result<(Post, String), Failure> {
    let shown = file.display().to_string();
    let (name, shown, text) =
        data::find("post", "posts", &[], &as_path_of(&shown)).map_err(Failure::failed)?;
    let post = Post::named(&name, &shown, &text)
        .map_err(|_| Failure::Rejected(complaints(&name, &shown, &text)))?;
    let program = specimen_text(&post).map_err(|e| {
        Failure::Rejected(format!("{shown}: no program could be written with it: {e}"))
    })?;
    read_back(&post, &program).map_err(|e| {
        Failure::Rejected(format!(
            "{shown}: a small program written with it does not say to {} what was meant, so the words of this post are wrong for it: {e}",
            post.reader
        ))
    })?;
    Ok((post, program))
}

/// Reads the small program as its controller would, and compares it with what it was written for.
fn read_back(post: &Post, program: &str) -> Result<(), VerifyError> {
    let text = io::Cursor::new(program.as_bytes());
    let state = worst_state(dialect_of(post)?, post);
    let said = Interpreter::from_state(text, state, Reading::default())
        .map_err(|e| VerifyError::Refused(e.to_string()))?;
    let mut witness = Witness::new(said, Spelling::of(post));
    let mut adapter = Adapter::new(post, Rewrite::default());
    for step in specimen(post) {
        adapter.step(&step, &mut |s| witness.step(s).map(drop))?;
    }
    witness.finish().map(drop)
}

/// A name as a path, whatever it ends with.
fn as_path_of(shown: &str) -> String {
    as_path(Path::new(shown))
}

/// All that is wrong with a post, one complaint a line.
fn complaints(name: &str, file: &str, text: &str) -> String {
    let good: Vec<&str> = BUILT_IN.iter().map(|(_, text)| *text).collect();
    let all = proofread::complaints(text, &good, |t| Post::named(name, file, t).map(drop));
    let lines: Vec<String> = all.iter().map(ToString::to_string).collect();
    lines.join("\n")
}

/// Writes a copy of a post under a title that marks it as the user's.
fn begin(from: &str, text: &str, file: &Path) -> Result<(), Failure> {
    if file.extension().is_none_or(|e| e != "toml") {
        return Err(Failure::Failed(format!(
            "{}: a post's name must end in .toml",
            file.display()
        )));
    }
    let mut copy = format!(
        "# A post of your own, begun from {from}. `morsemill posts check` judges it; posts/schema.json says what each key means.\n"
    );
    for line in text.split_inclusive('\n') {
        match line.strip_prefix("title = \"") {
            Some(rest) => copy.push_str(&format!("title = \"My {rest}")),
            None => copy.push_str(line),
        }
    }
    let mut out = std::fs::OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(file)
        .map_err(|e| {
            let advice = match e.kind() {
                io::ErrorKind::AlreadyExists => {
                    "it is there already, and nothing is overwritten: choose another name".into()
                }
                _ => e.to_string(),
            };
            Failure::Failed(format!("{}: cannot be written: {advice}", file.display()))
        })?;
    out.write_all(copy.as_bytes())
        .and_then(|()| out.sync_all())
        .map_err(|e| Failure::Failed(format!("{}: cannot be written: {e}", file.display())))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn words(f: Failure) -> (u8, String) {
        match f {
            Failure::Rejected(t) => (1, t),
            Failure::Failed(t) => (2, t),
        }
    }

    #[test]
    fn lists_each_post_once() {
        let mut out = Vec::new();
        list(&mut out, &[]).unwrap();
        let text = String::from_utf8(out).unwrap();
        for (name, _) in BUILT_IN {
            assert_eq!(
                text.lines()
                    .filter(|l| l.starts_with(&format!("  {name} ")))
                    .count(),
                1,
                "{text}"
            );
        }
        assert!(text.contains("  grbl        GRBL 1.1"), "{text}");
        assert!(!text.contains('*'));
    }

    #[test]
    fn a_new_post_is_a_good_copy_and_nothing_is_overwritten() {
        let dir = tempfile::tempdir().unwrap();
        for (name, text) in BUILT_IN {
            let file = dir.path().join(format!("my-{name}.toml"));
            begin(name, text, &file).unwrap();
            let written = std::fs::read_to_string(&file).unwrap();
            let comments = |t: &str| t.matches('#').count();
            assert_eq!(comments(&written), comments(text) + 1);
            let (post, program) = check(&file).unwrap();
            assert!(post.title.starts_with("My "), "{}", post.title);
            assert_eq!(post.name, format!("my-{name}"));
            assert!(!program.is_empty());
            let (code, e) = words(begin(name, text, &file).unwrap_err());
            assert_eq!(code, 2);
            assert!(
                e.ends_with("nothing is overwritten: choose another name"),
                "{e}"
            );
            assert_eq!(std::fs::read_to_string(&file).unwrap(), written);
        }
        let (good, bad) = own(&[dir.path().to_path_buf()]);
        assert_eq!((good.len(), bad.len()), (BUILT_IN.len(), 0));
        let mut out = Vec::new();
        list(&mut out, &good).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(text.contains("* my-grbl        My GRBL 1.1\n"), "{text}");
        let found = find("my-haas", &[dir.path().to_path_buf()]).unwrap();
        assert!(found.2.contains("title = \"My Haas"));
        assert!(
            find("haas", &[dir.path().to_path_buf()])
                .unwrap()
                .2
                .contains("title = \"Haas")
        );
        let (code, e) = words(begin("grbl", "", Path::new("mine")).unwrap_err());
        assert_eq!(
            (code, e.as_str()),
            (2, "mine: a post's name must end in .toml")
        );
    }

    #[test]
    fn every_complaint_has_its_place_and_what_to_do() {
        let dir = tempfile::tempdir().unwrap();
        let grbl = BUILT_IN.iter().find(|(n, _)| *n == "grbl").unwrap().1;
        let file = dir.path().join("mine.toml");
        let judge = |changes: &[(&str, &str)]| {
            let text = changes.iter().fold(grbl.to_string(), |t, (from, to)| {
                assert!(t.contains(from), "{from}");
                t.replacen(from, to, 1)
            });
            std::fs::write(&file, text).unwrap();
            let (code, e) = words(check(&file).unwrap_err());
            assert_eq!(code, 1);
            e.replace(&file.display().to_string(), "mine.toml")
        };
        let e = judge(&[
            ("longest = 70", "longets = 70"),
            ("speed = 0", "sped = 0"),
            ("feed = true", "fed = true"),
        ]);
        let lines: Vec<&str> = e.lines().collect();
        for (i, key) in [(0, "longest"), (1, "speed"), (2, "feed")] {
            let like = format!("(did you mean \"{key}\"?)");
            assert!(
                lines
                    .iter()
                    .any(|l| l.starts_with("mine.toml:") && l.contains(&like)),
                "{i}: {e}"
            );
        }
        let e = judge(&[
            ("mm = 3", "mm = 9"),
            ("M3 S{speed}", "M3 S{sped}"),
            ("\"lf\"", "\"cr\""),
        ]);
        assert_eq!(
            e.lines().filter(|l| l.starts_with("mine.toml:")).count(),
            e.lines().count(),
            "{e}"
        );
        assert!(e.contains("mm = 9: must be at least 2"), "{e}");
        assert!(
            e.contains("{sped} is not known here (did you mean {speed}?)"),
            "{e}"
        );
        assert!(e.contains("end = \"cr\": must be one of lf, crlf"), "{e}");
        let e = judge(&[("[decimals]", "[decimals"), ("longest", "longets")]);
        assert!(e.starts_with("mine.toml:") && e.lines().count() >= 1, "{e}");
        // Good figures that make no program: lines too short for the post's own words.
        let e = judge(&[
            ("longest = 70", "longest = 40"),
            ("G17 G90 G94 G54", "G17 G90 G94 G54 G40 G49 G61 G80 M9 M5"),
        ]);
        assert!(
            e.contains("no program could be written with it: post mine: "),
            "{e}"
        );
        let e = judge(&[("M5\", \"M9\", \"M30", "M9\", \"M30"), ("charset = ", "#")]);
        assert_eq!(e.lines().count(), 2, "{e}");
        let e = judge(&[(
            "G54\"]",
            "G54 G40 G49 G61 G80 G91.1 M9 M5 G17 G40 G49 G61 G80 G91.1 G94\"]",
        )]);
        assert!(
            e.ends_with("characters, and [lines] longest is 70: split it into two lines"),
            "{e}"
        );
        let e = judge(&[("M3 S{speed}\"]", "M3 S{speed}\", \"M30\"]")]);
        assert!(
            e.contains("cw = \"M30\": M2 and M30 belong to the last lines"),
            "{e}"
        );
        // Figures and words that fit together, but not the controller: only its reader knows.
        let back = "mine.toml: a small program written with it does not say to grbl what was meant, so the words of this post are wrong for it: ";
        for (from, to, why) in [
            (
                "G4 P{seconds}",
                "G4 P{milliseconds}",
                "line 7 (\"G4 P2000\"): it is given 2000 s to reach its speed, and 2 s were meant",
            ),
            ("[\"M8\"]", "[\"M7\"]", "line 8:1 M7 is not a command of"),
            (
                "\"G54\", \"G55\"",
                "\"G55\", \"G54\"",
                "work coordinate system 1 holds, and 2 was meant",
            ),
            ("G94 G54\"]", "G94 G54 G64\"]", "G64 is not a command of"),
            (
                "[modal]",
                "[tool]\nchange = [\"T{tool} M6\"]\nmost = 9\n\n[modal]",
                "line 5:4 M6 is not a command of",
            ),
        ] {
            let e = judge(&[(from, to)]);
            assert!(e.starts_with(back) && e.contains(why), "{e}");
        }
        let (code, e) = words(check(&dir.path().join("none.toml")).unwrap_err());
        assert!(code == 2 && e.contains("cannot be read as a post"), "{e}");
    }
}
