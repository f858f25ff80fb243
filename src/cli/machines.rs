//! `morsemill machines`: machines listed, shown, checked, and begun anew.

use super::Failure;
use super::output::{say, to_stdout};
use crate::machine::search::{self, Origin};
use crate::machine::{BUILT_IN, DEFAULT_MACHINE, Machine, advice, data, proofread};
use crate::post;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What `morsemill machines` is asked for.
#[derive(Debug, clap::Args)]
pub struct MachinesArgs {
    #[command(subcommand)]
    ask: Option<Ask>,
}

#[derive(Debug, clap::Subcommand)]
enum Ask {
    /// All machines by name (what `machines` alone does)
    List,
    /// Every figure of a machine, and where it comes from
    Show {
        /// Name of a machine, or a file
        #[arg(value_name = "NAME|FILE")]
        name: String,
    },
    /// Judges a machine file of your own: every complaint with its line; exit code 1 when it cannot be used
    Check {
        /// The file
        file: PathBuf,
    },
    /// Begins a machine file of your own as a copy of another, comments and all
    New {
        /// The machine to begin from
        #[arg(long, value_name = "NAME|FILE")]
        from: String,
        /// The new file; it must not exist
        file: PathBuf,
    },
}

/// Carries it out.
pub fn run(args: &MachinesArgs) -> Result<ExitCode, Failure> {
    let directories = search::directories("machines");
    match args.ask.as_ref().unwrap_or(&Ask::List) {
        Ask::List => {
            let (machines, broken) = all(directories);
            broken.iter().for_each(|line| say(line));
            to_stdout(|w| list(&machines, w))
        }
        Ask::Show { name } => {
            let machine = Machine::load(name).map_err(Failure::failed)?;
            let origin = search::locate(directories, &BUILT_IN, name);
            to_stdout(|w| show(&machine, origin.as_ref(), w))
        }
        Ask::Check { file } => {
            let (machine, warnings) = check(file)?;
            to_stdout(|w| {
                for warning in &warnings {
                    writeln!(w, "{warning}")?;
                }
                let count = match warnings.len() {
                    0 => String::new(),
                    1 => ", 1 warning".to_string(),
                    n => format!(", {n} warnings"),
                };
                writeln!(w, "{}: good{count}: {}", file.display(), machine.title)
            })
        }
        Ask::New { from, file } => {
            begin(from, file)?;
            to_stdout(|w| {
                writeln!(
                    w,
                    "{}: a copy of {from}: change its figures, then `morsemill machines check` it, and name it with --machine",
                    file.display()
                )
            })
        }
    }
}

/// The user's own machines and the built-in ones that they do not hide, with where each comes from; and a line on each that is broken.
fn all(directories: &[PathBuf]) -> (Vec<(Machine, Origin)>, Vec<String>) {
    let mut names = search::own_names(directories);
    names.extend(BUILT_IN.iter().map(|(n, _)| n.to_string()));
    names.sort();
    names.dedup();
    let (mut machines, mut broken) = (Vec::new(), Vec::new());
    for name in names {
        let Some(origin) = search::locate(directories, &BUILT_IN, &name) else {
            continue;
        };
        let found = search::find_in(directories, "machine", "machines", &BUILT_IN, &name)
            .and_then(|(name, file, text)| Machine::named(&name, &file, &text));
        match found {
            Ok(machine) => machines.push((machine, origin)),
            Err(e) => broken.push(e.to_string()),
        }
    }
    (machines, broken)
}

/// Machines as text, one a line: name, travels in mm, controller, title; the default and the user's own are marked.
fn list(machines: &[(Machine, Origin)], out: &mut dyn Write) -> io::Result<()> {
    let width = machines
        .iter()
        .map(|(m, _)| m.name.chars().count())
        .max()
        .unwrap_or(0);
    writeln!(
        out,
        "  {:width$}  {:>18}  {:10}  what it is",
        "machine", "travel X Y Z, mm", "controller"
    )?;
    let mut own = false;
    for (m, origin) in machines {
        let mark = if m.name == DEFAULT_MACHINE { '*' } else { ' ' };
        let [x, y, z] = m.travel;
        let travel = format!("{} x {} x {}", x.0, y.0, z.0);
        let from = match origin {
            Origin::Own { path, .. } => format!("  [{}]", path.display()),
            _ => String::new(),
        };
        own |= !from.is_empty();
        writeln!(
            out,
            "{mark} {:width$}  {travel:>18}  {:10}  {}{from}",
            m.name, m.controller, m.title
        )?;
    }
    writeln!(out)?;
    if own {
        writeln!(
            out,
            "[FILE] is your own, and stands before a built-in one of its name."
        )?;
    }
    writeln!(
        out,
        "* is used when no --machine is given. A file of your own works as well: --machine ./mine.toml"
    )
}

/// Every figure of a machine with its unit.
fn show(m: &Machine, origin: Option<&Origin>, out: &mut dyn Write) -> io::Result<()> {
    let origin = match origin {
        Some(Origin::Named(path)) => path.display().to_string(),
        Some(Origin::Own { path, shadows }) => {
            let instead = if *shadows {
                " (stands before the built-in one of that name)"
            } else {
                ""
            };
            format!("{}{instead}", path.display())
        }
        Some(Origin::BuiltIn) | None => {
            "built in (its file's comments name the source of each figure: `machines new` copies it)"
                .to_string()
        }
    };
    let family = m.family().map_or(m.controller.as_str(), |f| f.title);
    let xyz = |v: [f64; 3]| format!("{} {} {}", v[0], v[1], v[2]);
    let feed = m.max_feed.map_or_else(
        || "as fast as the axes go".to_string(),
        |f| format!("{} mm/min", f.0),
    );
    let baud = match m.baud {
        0 => "none: programs are files".to_string(),
        n => format!("{n} baud"),
    };
    let marked = |key: &str, figure: String| {
        if m.stand_ins.contains(&key) {
            format!("{figure} (a stand-in: the file does not say)")
        } else {
            figure
        }
    };
    let lines = [
        ("machine", m.name.clone()),
        ("title", m.title.clone()),
        ("from", origin),
        ("controller", format!("{} ({family})", m.controller)),
        ("post", m.post.clone()),
        ("travel X Y Z", format!("{} mm", xyz(m.travel.map(|v| v.0)))),
        (
            "rapid X Y Z",
            format!("{} mm/min", xyz(m.max_rate.map(|v| v.0))),
        ),
        ("cutting feed at most", feed),
        (
            "acceleration X Y Z",
            format!("{} mm/s2", xyz(m.acceleration.map(|v| v.0))),
        ),
        (
            "steps X Y Z",
            marked("steps_per_mm", format!("{} per mm", xyz(m.steps_per_mm))),
        ),
        (
            "junction deviation",
            marked(
                "junction_deviation_mm",
                format!("{} mm", m.junction_deviation.0),
            ),
        ),
        (
            "arc tolerance",
            marked("arc_tolerance_mm", format!("{} mm", m.arc_tolerance.0)),
        ),
        (
            "look-ahead",
            marked("planner_blocks", format!("{} blocks", m.planner_blocks)),
        ),
        (
            "receive buffer",
            marked("rx_buffer_bytes", format!("{} bytes", m.rx_buffer)),
        ),
        (
            "spindle",
            format!("{} to {} rpm", m.spindle[0].0, m.spindle[1].0),
        ),
        ("serial line", baud),
    ];
    for (what, figure) in lines {
        writeln!(out, "{what:21} {figure}")?;
    }
    Ok(())
}

/// A machine file and its warnings. A file that cannot be used is rejected with all its complaints.
fn check(file: &Path) -> Result<(Machine, Vec<String>), Failure> {
    // A bare name is a file here too: nobody checks what is built in.
    let named = Path::new(".").join(file);
    let (name, _, text) = data::find("machine", "machines", &[], &named.to_string_lossy())
        .map_err(Failure::failed)?;
    let shown = file.display().to_string();
    let machine = Machine::named(&name, &shown, &text).map_err(|_| {
        let good: Vec<&str> = BUILT_IN.iter().map(|(_, text)| *text).collect();
        let read = |t: &str| Machine::named(&name, &shown, t).map(drop);
        let all = proofread::complaints(&text, &good, read);
        let lines: Vec<String> = all.iter().map(ToString::to_string).collect();
        Failure::Rejected(format!("{shown} cannot be used:\n{}", lines.join("\n")))
    })?;
    let mut posts = search::own_names(search::directories("posts"));
    posts.extend(post::BUILT_IN.iter().map(|(n, _)| n.to_string()));
    let mut warnings = advice::of(&machine, &shown, &text);
    if !search::is_path(&machine.post) && !posts.contains(&machine.post) {
        let near = data::nearest(&machine.post, posts.iter().map(String::as_str))
            .map_or_else(String::new, |n| format!(" (did you mean \"{n}\"?)"));
        warnings.push(advice::at(
            &shown,
            &text,
            "post",
            &format!(
                "there is no post \"{}\"{near}: `morsemill posts` lists them",
                machine.post
            ),
        ));
    }
    Ok((machine, warnings))
}

/// Writes a copy of a machine's file to a file that must not exist.
fn begin(from: &str, file: &Path) -> Result<(), Failure> {
    let (_, _, text) =
        data::find("machine", "machines", &BUILT_IN, from).map_err(Failure::failed)?;
    if file.extension().is_none_or(|e| e != "toml") {
        return Err(Failure::Failed(format!(
            "{}: a machine file's name ends in .toml",
            file.display()
        )));
    }
    let fail = |e: io::Error| {
        let why = if e.kind() == io::ErrorKind::AlreadyExists {
            "it exists already: name a new file".to_string()
        } else {
            e.to_string()
        };
        Failure::Failed(format!("{}: cannot be written: {why}", file.display()))
    };
    let mut new = std::fs::File::create_new(file).map_err(fail)?;
    new.write_all(text.as_bytes())
        .and_then(|()| new.sync_all())
        .map_err(fail)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn listed(directories: &[PathBuf]) -> (String, Vec<String>) {
        let (machines, broken) = all(directories);
        let mut out = Vec::new();
        list(&machines, &mut out).unwrap();
        (String::from_utf8(out).unwrap(), broken)
    }

    #[test]
    fn lists_each_machine_once_and_marks_the_default() {
        let (text, broken) = listed(&[]);
        assert_eq!(broken, Vec::<String>::new());
        for (name, _) in BUILT_IN {
            let starts = |l: &&str| {
                l.get(2..)
                    .is_some_and(|l| l.starts_with(&format!("{name} ")))
            };
            assert_eq!(text.lines().filter(starts).count(), 1, "{text}");
        }
        let line = text.lines().find(|l| l.starts_with('*')).unwrap();
        assert!(
            line.starts_with("* longmill-30x30 ") && line.ends_with("Sienci LongMill MK2 30x30"),
            "{line}"
        );
        assert_eq!(text.matches('*').count(), 2, "one mark and its legend");
    }

    #[test]
    fn the_users_own_are_listed_with_their_files_and_broken_ones_are_told() {
        let dir = tempfile::tempdir().unwrap();
        let mine = BUILT_IN[0].1.replace("title = \"", "title = \"My own ");
        std::fs::write(dir.path().join("grbl-3018.toml"), &mine).unwrap();
        std::fs::write(dir.path().join("bench.toml"), &mine).unwrap();
        std::fs::write(dir.path().join("broken.toml"), "title = 5\n").unwrap();
        let (text, broken) = listed(&[dir.path().to_path_buf()]);
        assert_eq!(text.matches("My own").count(), 2, "{text}");
        assert_eq!(
            text.lines().filter(|l| l.contains(" grbl-3018 ")).count(),
            1,
            "{text}"
        );
        assert!(
            text.contains("bench.toml]\n") && text.contains("[FILE] is your own"),
            "{text}"
        );
        assert_eq!(broken.len(), 1);
        assert!(broken[0].contains("broken.toml:1:9: "), "{}", broken[0]);
    }

    #[test]
    fn shows_every_figure_with_its_unit_and_what_stands_in() {
        let mut out = Vec::new();
        let m = Machine::load("haas-vf-2").unwrap();
        show(&m, Some(&Origin::BuiltIn), &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        for line in [
            "travel X Y Z          762 406 508 mm",
            "cutting feed at most  16500 mm/min",
            "steps X Y Z           1000 1000 1000 per mm (a stand-in: the file does not say)",
            "look-ahead            80 blocks",
            "spindle               60 to 8100 rpm",
            "serial line           none: programs are files",
        ] {
            assert!(text.contains(line), "{line}\n{text}");
        }
    }

    #[test]
    fn check_rejects_with_every_complaint_and_warns_of_the_rest() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("mine.toml");
        let good = include_str!("../../machines/grbl-3018.toml");
        std::fs::write(&file, good).unwrap();
        assert_eq!(check(&file).unwrap().1, Vec::<String>::new());
        std::fs::write(&file, good.replace("post = \"grbl\"", "post = \"gbrl\"")).unwrap();
        let warnings = check(&file).unwrap().1;
        assert_eq!(warnings.len(), 1);
        assert!(
            warnings[0].ends_with("mine.toml:7:1: warning: post: there is no post \"gbrl\" (did you mean \"grbl\"?): `morsemill posts` lists them"),
            "{}", warnings[0]
        );
        std::fs::write(&file, good.replace("[284, ", "[0, ").replace("0.002", "-1")).unwrap();
        let Err(Failure::Rejected(e)) = check(&file) else {
            panic!("not rejected");
        };
        assert_eq!(e.lines().count(), 3, "{e}");
        assert!(e.contains("mine.toml:8:14: travel_mm = 0: "), "{e}");
        assert!(matches!(
            check(&dir.path().join("none.toml")),
            Err(Failure::Failed(_))
        ));
    }

    #[test]
    fn new_copies_and_never_overwrites() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("mine.toml");
        begin("haas-vf-2", &file).unwrap();
        let text = std::fs::read_to_string(&file).unwrap();
        assert_eq!(text, include_str!("../../machines/haas-vf-2.toml"));
        let Err(Failure::Failed(e)) = begin("grbl-3018", &file) else {
            panic!("overwrote");
        };
        assert!(e.ends_with("it exists already: name a new file"), "{e}");
        assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
        let Err(Failure::Failed(e)) = begin("grbl-3018", &dir.path().join("mine.txt")) else {
            panic!("wrote");
        };
        assert!(e.ends_with("a machine file's name ends in .toml"), "{e}");
        assert!(matches!(begin("no-such", &file), Err(Failure::Failed(_))));
    }
}
