//! `send --resume` and `send --from-line`: finds the journal, makes the plan, shows it, simulates it, and asks.
//!
//! The journal lies beside the program, as `PROGRAM.journal` (`part.nc` has `part.nc.journal`), unless `--journal` names another. One of a
//! job that was finished is set aside when the next begins (`.journal.1` to `.journal.9`, the oldest goes); one of a job that was not is
//! never overwritten: `send` asks for `--resume` or `--discard-journal`.

use crate::cli::Failure;
use crate::cli::program_file::ProgramFile;
use crate::gcode::Dialect;
use crate::link::journal::{Begin, Damage, FORMAT, History, JournalFile, Offsets, Start, read};
use crate::link::resume::{
    Now, Overlap, Plan, ResumeOptions, Trust, from_line, may_lack_the_last, resume,
};
use crate::link::vet::{self, VetOptions};
use crate::link::{Job, Known};
use crate::machine::Machine;
use crate::simulate::{DryRunOptions, Kind, Stock, dry_run_of};
use std::fmt::Write as _;
use std::io::{self, BufRead as _, BufReader, IsTerminal as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What `send` takes beside its own arguments.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct ResumeArgs {
    /// Take up the job that its journal says was broken: shown and simulated first
    #[arg(long, conflicts_with = "from_line")]
    pub resume: bool,
    /// Begin at this line, with all modes that the lines before it set: shown and simulated first
    #[arg(long, value_name = "N")]
    pub from_line: Option<usize>,
    /// The journal, if not beside the program as PROGRAM.journal
    #[arg(long, value_name = "FILE")]
    pub journal: Option<PathBuf>,
    /// Set the journal of an unfinished job aside and begin afresh
    #[arg(long, conflicts_with = "resume")]
    pub discard_journal: bool,
    /// Cut path to go over again before the first line in doubt [default: 5 with --resume, 0 with --from-line]
    #[arg(long, value_name = "MM", value_parser = length)]
    pub overlap: Option<f64>,
    /// Height of the way in, machine coordinates [default: the highest place of the program]
    #[arg(long, value_name = "Z", allow_negative_numbers = true, value_parser = number)]
    pub safe_z: Option<f64>,
    /// Feed of the way down [default: the program's slowest so far]
    #[arg(long, value_name = "MM_PER_MIN", value_parser = length)]
    pub plunge_feed: Option<f64>,
    /// Seconds for the spindle to come to speed before the way down
    #[arg(long, value_name = "S", default_value_t = 5.0, value_parser = length)]
    pub spin_up: f64,
    /// Your word that position, work zero and part are right, whatever the journal says
    #[arg(long)]
    pub trust_position: bool,
    /// Do not ask before a resumed job begins: the part is clamped where it was, and the tool is the one of the plan. Prompts of
    /// the program (M0, M6) still wait, and so does a plate to be taken away
    #[arg(long)]
    pub yes: bool,
}

fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        _ => Err("write a number".to_string()),
    }
}

fn length(text: &str) -> Result<f64, String> {
    match number(text)? {
        v if v >= 0.0 => Ok(v),
        _ => Err("write a number of zero or more".to_string()),
    }
}

impl ResumeArgs {
    /// True when the job is not to begin at its first line.
    pub fn wanted(&self) -> bool {
        self.resume || self.from_line.is_some()
    }

    fn options(&self) -> ResumeOptions {
        let overlap = match (self.overlap, self.from_line) {
            (Some(mm), _) if mm > 0.0 => Overlap::Mm(mm),
            (None, None) => ResumeOptions::default().overlap,
            (Some(_), None) => Overlap::Mm(0.0),
            _ => Overlap::Nothing,
        };
        ResumeOptions {
            overlap,
            safe_z: self.safe_z,
            plunge: self.plunge_feed,
            spin_up_s: self.spin_up,
            trust: match self.trust_position {
                true => Trust::Operator,
                false => Trust::Shown,
            },
        }
    }
}

/// The journal of a program.
pub fn journal_path(program: &Path, given: Option<&Path>) -> PathBuf {
    if let Some(given) = given {
        return given.to_path_buf();
    }
    let mut name = program.as_os_str().to_owned();
    name.push(".journal");
    PathBuf::from(name)
}

/// What lies where a journal is to be.
#[derive(Debug)]
pub enum Found {
    /// Nothing.
    Nothing,
    /// The journal of a job that was carried out to its end.
    Finished,
    /// That of a job that was not.
    Unfinished(Box<History>),
}

/// Looks for a journal.
///
/// # Errors
/// It cannot be read.
pub fn look(path: &Path) -> Result<Found, Failure> {
    let unreadable = |e: io::Error| Failure::Failed(format!("{}: {e}", path.display()));
    let file = match std::fs::File::open(path) {
        Ok(file) => file,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Found::Nothing),
        Err(e) => return Err(unreadable(e)),
    };
    if JournalFile::in_use(path).map_err(unreadable)? {
        return Err(Failure::Rejected(format!(
            "{}: another morsemill is sending this job and writes this journal now: wait until it ends, or stop it",
            path.display()
        )));
    }
    let history = read(BufReader::new(file)).map_err(unreadable)?;
    Ok(match history.done {
        true => Found::Finished,
        false => Found::Unfinished(Box::new(history)),
    })
}

/// Old journals kept beside the new one.
const KEPT: u32 = 9;

/// Sets a journal aside: `.1` is the newest. It stays where it is too, until the next takes its place: whoever is killed in between
/// leaves a journal to resume by. Nothing there is fine.
///
/// # Errors
/// The files cannot be renamed.
pub fn set_aside(path: &Path) -> Result<(), Failure> {
    let numbered = |n: u32| {
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".{n}"));
        PathBuf::from(name)
    };
    let rename = |from: &Path, to: &Path| match std::fs::rename(from, to) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(Failure::Failed(format!(
            "{}: cannot set the old journal aside: {e}",
            from.display()
        ))),
        _ => Ok(()),
    };
    if !path.exists() {
        return Ok(());
    }
    for n in (1..KEPT).rev() {
        rename(&numbered(n), &numbered(n + 1))?;
    }
    // A second name; where a file system has none for it, a copy.
    let kept = std::fs::hard_link(path, numbered(1))
        .or_else(|_| std::fs::copy(path, numbered(1)).map(|_| ()));
    kept.map_err(|e| {
        Failure::Failed(format!(
            "{}: cannot set the old journal aside: {e}",
            path.display()
        ))
    })
}

/// False when what is missing may have told that something was sent.
fn is_sound(history: &History) -> bool {
    let lacking = |begin| may_lack_the_last(begin, history, boot().as_deref());
    !matches!(history.damage, Damage::Broken { .. }) && !history.begin.as_ref().is_some_and(lacking)
}

/// A job that begins at its first line must not bury a broken one: makes room for its journal.
///
/// # Errors
/// An unfinished journal is there and `discard` is not said.
pub fn make_room(path: &Path, discard: bool) -> Result<(), Failure> {
    if let Found::Unfinished(history) = look(path)?
        && !discard
        && (history.sent.max(history.allowed) > 0 || !is_sound(&history))
    {
        if let Some(format) = history.foreign {
            let why = crate::link::resume::Refusal::OtherFormat(format);
            return Err(Failure::Rejected(format!("{}: {why}", path.display())));
        }
        let lines = history.begin.as_ref().map_or(0, |b| b.lines);
        return Err(Failure::Rejected(format!(
            "{}: a job of this program was broken after line {} of {lines} was answered ({}): take it up with --resume, or begin afresh with --discard-journal",
            path.display(),
            history.acknowledged,
            history
                .end
                .as_deref()
                .unwrap_or("the sender ended without a word"),
        )));
    }
    set_aside(path)
}

/// The machine, its controller and the program.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// Path of the program, as given.
    pub path: &'a Path,
    /// The program itself.
    pub program: &'a ProgramFile,
    /// SHA-256 of its bytes.
    pub sha256: &'a str,
    /// Its lines.
    pub lines: usize,
    /// The machine.
    pub machine: &'a Machine,
    /// What the controller says of itself.
    pub known: &'a Known,
    /// Lines that begin with `/` are left out.
    pub skips_slashed: bool,
}

/// Something that is different after each start of this computer, where the system has it.
pub fn boot() -> Option<String> {
    let id = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").ok()?;
    Some(id.trim().to_string()).filter(|id| !id.is_empty())
}

/// Bytes per second of a link whose speed nobody sets (network, simulated).
const FASTEST_LINK: f64 = 1e6;

impl Subject<'_> {
    /// The first record of this job's journal: of a job from its first line, or of the plan's.
    pub fn begin(&self, plan: Option<&Plan>, serial: bool) -> Begin {
        let known = self.known;
        let start = Start {
            position: known.machine_position.unwrap_or_default(),
            offsets: Offsets::of(&known.offsets),
            modes: known.modes.to_string(),
        };
        let baud = f64::from(self.machine.baud);
        Begin {
            format: FORMAT,
            program: self.path.display().to_string(),
            sha256: self.sha256.to_string(),
            lines: self.lines,
            machine: self.machine.name.clone(),
            firmware: known.version.clone(),
            dialect: known.dialect().name().to_string(),
            settings: known.settings.clone(),
            start: plan.map_or(start, |p| p.start.clone()),
            rx_bytes: known.rx_bytes,
            planner_blocks: known.blocks.unwrap_or(self.machine.planner_blocks),
            // Eight bits, a start and a stop.
            bytes_per_s: match serial && baud > 0.0 {
                true => baud / 10.0,
                false => FASTEST_LINK,
            },
            boot: boot(),
            skips_slashed: self.skips_slashed,
            resumed: plan.map(Plan::resumed),
        }
    }

    /// Makes the plan that the arguments ask for; `notes` are for the operator.
    ///
    /// # Errors
    /// There is no journal; the job is not to be taken up, and why.
    pub fn plan(&self, args: &ResumeArgs, notes: &mut Vec<String>) -> Result<Plan, Failure> {
        let now = Now::of(self.known, &self.machine.name, boot());
        let rejected = |e: crate::link::resume::Refusal| {
            Failure::Rejected(format!("{}: {e}", self.path.display()))
        };
        if let Some(line) = args.from_line {
            let options = args.options();
            return from_line(self.program, line, self.skips_slashed, &now, &options)
                .map_err(rejected);
        }
        let path = journal_path(self.path, args.journal.as_deref());
        let history = match look(&path)? {
            Found::Unfinished(history) => history,
            Found::Finished => {
                return Err(rejected(crate::link::resume::Refusal::Finished));
            }
            Found::Nothing => {
                return Err(Failure::Failed(format!(
                    "{}: there is no journal to resume by. --journal names another, --from-line begins at a line without one",
                    path.display()
                )));
            }
        };
        notes.extend(damage(&history));
        resume(self.program, self.sha256, &history, &now, &args.options()).map_err(rejected)
    }

    /// Simulates a plan: vets what will be sent, way in included, by the controller's own limits, and runs the resumed program dry on the
    /// machine. The job to send.
    ///
    /// # Errors
    /// Whatever speaks against sending it.
    pub fn simulate(&self, plan: &Plan, notes: &mut Vec<String>) -> Result<Job, Failure> {
        let travel = self.machine.travel.map(|t| t.0);
        let mut start = self.known.start();
        start.g92 = Default::default();
        start.tlo = 0.0;
        if let Some(p) = self.known.machine_position {
            start.set_machine_position(&crate::geom::Point::from(p));
        }
        let options = VetOptions {
            start,
            entry: plan.head.clone(),
            first_line: plan.entry.line,
            block_delete: match self.skips_slashed {
                true => vet::BlockDelete::Skip,
                false => VetOptions::default().block_delete,
            },
            ..VetOptions::of(self.known, Some(travel))
        };
        let source = Arc::new(self.program.clone());
        let job = vet::vet(source, options, &mut |_, _| {}).map_err(|errors| {
            let list: Vec<String> = errors
                .iter()
                .map(|e| format!("{}:{e}", self.path.display()))
                .collect();
            Failure::Rejected(format!(
                "the resumed program cannot be sent:\n{}",
                list.join("\n")
            ))
        })?;
        let dialect: Dialect = self.known.dialect();
        let judged = DryRunOptions::new(0.02, Stock::Allowance(0.0));
        let run = dry_run_of(
            &|| plan.reader(self.program),
            dialect,
            self.machine,
            None,
            &judged,
        );
        let map = plan.map();
        let mut told = String::new();
        for problem in &run.problems {
            let line = match problem.line.map(|l| map.original(l)) {
                Some(0) => "way in: ".to_string(),
                Some(line) => format!("line {line}: "),
                None => String::new(),
            };
            match problem.kind {
                // Writing into a String cannot fail.
                Kind::Limit | Kind::Syntax => _ = write!(told, "\n{line}{}", problem.text),
                _ => notes.push(format!("{line}{}", problem.text)),
            }
        }
        if !told.is_empty() {
            return Err(Failure::Rejected(format!(
                "the simulation of the resumed program found:{told}"
            )));
        }
        notes.push(format!(
            "simulated: about {:.1} s on {}",
            run.time_s.total, self.machine.title
        ));
        Ok(job)
    }
}

/// What is wrong with a journal's bytes, in words.
fn damage(history: &History) -> Option<String> {
    match history.damage {
        Damage::None => None,
        Damage::Torn { bytes } => Some(format!(
            "the journal's last record was being written when the sender ended: {bytes} bytes left out, on which nothing depends"
        )),
        Damage::Zeros { bytes } => Some(format!(
            "the journal ends in {bytes} zero bytes, as after a power cut: the zone in doubt is as much larger"
        )),
        Damage::Broken { line, behind } => Some(format!(
            "the journal is damaged at its line {line}: that and {behind} records behind it are not believed, and every line from there on is in doubt"
        )),
    }
}

/// Asks whether to go on. Without a terminal only `--yes` is a yes.
///
/// # Errors
/// No.
pub fn ask(yes: bool) -> Result<(), Failure> {
    if yes {
        return Ok(());
    }
    if !io::stdin().is_terminal() {
        return Err(Failure::Rejected(
            "nothing was sent: look at the plan above and say --yes to carry it out".to_string(),
        ));
    }
    crate::cli::output::say(
        "go on? Only if the part is clamped where it was and this is the tool: type yes and Enter:",
    );
    let mut line = String::new();
    let read = io::stdin().lock().read_line(&mut line);
    match read.is_ok() && line.trim().eq_ignore_ascii_case("yes") {
        true => Ok(()),
        false => Err(Failure::Rejected("nothing was sent".to_string())),
    }
}

#[cfg(test)]
#[path = "resume_tests.rs"]
mod tests;
