//! `morsemill controller`: the simulated controller behind a pseudo-terminal or a socket, for any sender to open.

mod keep;
mod name;
mod rehearse;

use super::Failure;
use super::args::{PartArgs, ToolArgs, parse};
use super::mill::StockArg;
use super::output::say;
use super::send::pace;
use crate::controller::{
    Build, Controller, FaultPlan, Faults, Guests, Memory, News, Opening, Pace, Profile, Pty,
    Quirks, Readout, Rig, RigOptions, Script, Switches, Tcp,
};
use crate::machine::{Machine, SettingsFile};
use rehearse::Bench;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::Duration;

/// Arguments of `morsemill controller`.
#[derive(Clone, Debug, clap::Args)]
pub struct ControllerArgs {
    /// Machine: a built-in name or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = crate::machine::DEFAULT_MACHINE)]
    pub machine: String,
    /// The firmware it plays: grbl-1.1h, grbl-1.1f, grblhal or fluidnc (of the last two, what a sender must notice)
    #[arg(long, value_name = "NAME", default_value = "grbl-1.1h", value_parser = super::args::parse::<Profile>)]
    pub firmware: Profile,
    /// Serve on a pseudo-terminal, to be opened like a serial device; its path is printed
    #[arg(long, conflicts_with = "tcp")]
    pub pty: bool,
    /// Serve on a TCP socket; port 0 takes any free one. Its address is printed
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub tcp: Option<String>,
    /// Let --tcp listen where other computers can reach it: anybody there may drive this controller
    #[arg(long, requires = "tcp")]
    pub allow_remote: bool,
    /// What opening the pseudo-terminal does: restart (as most boards: it greets half a second later, and hears what was said meanwhile),
    /// bootloader (as an Arduino Uno: 1.6 s, in which what is said is lost) or nothing (reset not wired to DTR)
    #[arg(
        long,
        value_name = "WHAT",
        value_enum,
        default_value = "restart",
        conflicts_with = "tcp"
    )]
    pub on_open: OnOpen,
    /// Let this name point to the pseudo-terminal as long as it is there, for senders that want to be told once what to open
    #[arg(long, value_name = "PATH", requires = "pty", conflicts_with = "tcp")]
    pub link: Option<PathBuf>,
    /// Times real time, or `max` for as fast as the sender keeps up
    #[arg(long, value_name = "N|max", default_value = "1", value_parser = pace)]
    pub speed: Pace,
    /// End when the first sender has left
    #[arg(long)]
    pub once: bool,
    /// What goes wrong on purpose, e.g. drop:0.001, flip:1e-5, lose-ok:0.01, delay:20ms, reset-at-line:120, unplug-at:12.5s, plug-at:20s,
    /// power-cycle-at:30s, eeprom-loss, rx-bytes:64, seed:42; may be given more than once
    #[arg(long, value_name = "NAME:VALUE")]
    pub fault: Vec<String>,
    /// What is done to the limit, probe, door and button pins, one thing a line: `12.5s limit x on`, `at Z<-5 probe on`
    #[arg(long, value_name = "FILE")]
    pub pins: Option<PathBuf>,
    /// Settings of the firmware in place of the machine's: `$n=value` lines, or what a controller answers to $$
    #[arg(long, value_name = "FILE")]
    pub settings: Option<PathBuf>,
    /// Keep settings, work offsets and startup lines in this file from run to run
    #[arg(long, value_name = "FILE")]
    pub eeprom: Option<PathBuf>,
    /// The part on the table (STL or OBJ): what is driven is judged at each program's end; exit 1 on a crash
    #[arg(long, value_name = "FILE")]
    pub part: Option<PathBuf>,
    #[allow(
        missing_docs,
        reason = "a doc comment here would become the command's help"
    )]
    #[command(flatten)]
    pub placement: PartArgs,
    #[allow(
        missing_docs,
        reason = "a doc comment here would become the command's help"
    )]
    #[command(flatten)]
    pub tool: ToolArgs,
    /// What stands before a program's first move: allowance:MM over the finished surface, or block (up to the part's top)
    #[arg(long, default_value = "allowance:0.5", value_parser = parse::<StockArg>, value_name = "STOCK")]
    pub stock: StockArg,
    /// Where the part's zero (G54) is, machine coordinates; with --part half way of each axis if left out
    #[arg(long, value_name = "X,Y,Z", value_parser = place, allow_hyphen_values = true)]
    pub work_zero: Option<[f64; 3]>,
    /// Replay recordings of a real controller (JSON lines) and print each with what the simulated one answers
    #[arg(long, value_name = "FILE.jsonl")]
    pub replay: Option<PathBuf>,
    /// With --replay: print only what differs; exit 1 if anything does
    #[arg(long, requires = "replay")]
    pub compare: bool,
}

/// What opening the pseudo-terminal does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum OnOpen {
    /// It restarts and greets.
    Restart,
    /// It restarts, and its boot loader eats what is said.
    Bootloader,
    /// It goes on.
    Nothing,
}

impl OnOpen {
    fn opening(self) -> Opening {
        match self {
            // Time for a program to open the device, set it up and clear its buffers.
            OnOpen::Restart => Opening::Restarts(Duration::from_millis(500)),
            // An Uno's boot loader waits a second for a program, and starting takes it another half.
            OnOpen::Bootloader => Opening::BootLoader(Duration::from_millis(1600)),
            OnOpen::Nothing => Opening::Nothing,
        }
    }
}

/// Three numbers with commas.
fn place(text: &str) -> Result<[f64; 3], String> {
    let figures: Vec<f64> = text
        .split(',')
        .filter_map(|t| t.trim().parse().ok())
        .filter(|v: &f64| v.abs() <= 20_000.0)
        .collect();
    match figures[..] {
        [x, y, z] if text.split(',').count() == 3 => Ok([x, y, z]),
        _ => Err("write three numbers of mm with commas, e.g. -100,-80,-40".to_string()),
    }
}

/// Serves until Ctrl-C; what to open is the first line on `out`. Returns the exit code: 0, 1 when a rehearsal crashed, 2 when it could
/// not be carried out.
pub fn run(args: &ControllerArgs, out: &mut dyn Write) -> u8 {
    if let Some(file) = &args.replay {
        return super::replay::run(file, args.compare, out);
    }
    let stop = Arc::new(AtomicBool::new(false));
    let on_interrupt = stop.clone();
    if let Err(e) = ctrlc::set_handler(move || on_interrupt.store(true, Ordering::Relaxed)) {
        say(&format!("error: Ctrl-C cannot be caught: {e}"));
        return 2;
    }
    run_until(args, out, &stop)
}

/// [`run`] until `stop` is set.
pub fn run_until(args: &ControllerArgs, out: &mut dyn Write, stop: &AtomicBool) -> u8 {
    match serve(args, out, stop) {
        Ok(crashed) => u8::from(crashed),
        Err(message) => {
            say(&format!("error: {message}"));
            2
        }
    }
}

/// What serves, whichever it is.
enum Serving {
    Pty(Pty),
    Tcp(Tcp),
}

impl Serving {
    fn readout(&self) -> Readout {
        match self {
            Serving::Pty(p) => p.readout(),
            Serving::Tcp(t) => t.readout(),
        }
    }

    fn stop(self) -> Option<Rig> {
        match self {
            Serving::Pty(p) => p.stop(),
            Serving::Tcp(t) => t.stop(),
        }
    }
}

/// True when a rehearsal crashed.
fn serve(args: &ControllerArgs, out: &mut dyn Write, stop: &AtomicBool) -> Result<bool, String> {
    if !args.pty && args.tcp.is_none() {
        return Err("say how to reach it: --pty, or --tcp 127.0.0.1:0".to_string());
    }
    let machine = machine(args)?;
    let faults = faults(&args.fault)?;
    let script = match &args.pins {
        None => Script::default(),
        Some(file) => {
            let text = text_of(file, "a pins script")?;
            Script::read(&file.display().to_string(), &text).map_err(|e| e.to_string())?
        }
    };
    let eeprom_loss = faults.plan().eeprom_loss;
    let mut controller = controller(args, &machine, script.moves_the_door(), eeprom_loss)?;
    let bench = match &args.part {
        None => None,
        Some(part) => {
            let steps = controller.memory().axes(100);
            Some(Bench::lay(part, args, &steps)?)
        }
    };
    if let Some(zero) = args.work_zero.or_else(|| {
        let half = machine.travel.map(|t| -0.5 * t.0);
        bench.as_ref().map(|_| half)
    }) {
        controller.set_work_zero(&zero.into());
        say(&format!(
            "work zero (G54) at machine X{:.3} Y{:.3} Z{:.3}",
            zero[0], zero[1], zero[2]
        ));
    }
    if !faults.plan().is_empty() {
        say(&format!(
            "faults: {}; the same again with --fault seed:{}",
            faults.plan(),
            faults.seed()
        ));
    }
    let rig = Rig::new(
        controller,
        RigOptions {
            faults,
            script,
            record: bench.is_some(),
        },
    );
    let (sender, news) = mpsc::channel();
    let (serving, name) = match &args.tcp {
        None => {
            let pty = Pty::serve(rig, args.on_open.opening(), args.speed, Some(sender))
                .map_err(|e| e.to_string())?;
            let name = pty.path().to_string();
            (Serving::Pty(pty), name)
        }
        Some(address) => {
            let guests = if args.allow_remote {
                Guests::Remote
            } else {
                Guests::Local
            };
            let tcp = Tcp::serve(rig, address, guests, args.speed, Some(sender))
                .map_err(|e| e.to_string())?;
            let name = format!("tcp://{}", tcp.address());
            (Serving::Tcp(tcp), name)
        }
    };
    // Taken away again when this is left, however.
    let _link = match &args.link {
        None => None,
        Some(link) => Some(name::Link::make(link, &name)?),
    };
    writeln!(out, "{name}")
        .and_then(|()| out.flush())
        .map_err(|e| format!("standard output: {e}"))?;
    if args.allow_remote {
        say("--allow-remote: any computer that reaches this address can drive this controller");
    }
    let how = match serving {
        Serving::Pty(_) => "open that path as a serial device",
        Serving::Tcp(_) => "connect to that address",
    };
    say(&format!(
        "{}, {}: {how}; Ctrl-C ends",
        args.firmware.name(),
        machine.title
    ));
    let mut listener = Listener {
        args,
        bench,
        out,
        crashed: false,
    };
    listener.listen(&news, stop)?;
    let lost = serving.readout().bytes_lost;
    if lost > 0 {
        say(&format!(
            "{lost} bytes were lost: more was sent than the receive buffer holds"
        ));
    }
    let Some(mut rig) = serving.stop() else {
        return Ok(listener.crashed);
    };
    for news in news.try_iter() {
        listener.hear(news)?;
    }
    listener.judge(&rig.take_drive(), false)?;
    if let Some(file) = &args.eeprom {
        keep::write(file, &rig.memory())?;
    }
    if !rig.faults().plan().is_empty() {
        say(&format!("faults done: {}", rig.faults().tally()));
    }
    Ok(listener.crashed)
}

/// Hears what the front tells.
struct Listener<'a> {
    args: &'a ControllerArgs,
    bench: Option<Bench>,
    out: &'a mut dyn Write,
    crashed: bool,
}

impl Listener<'_> {
    fn listen(&mut self, news: &Receiver<News>, stop: &AtomicBool) -> Result<(), String> {
        while !stop.load(Ordering::Relaxed) {
            match news.recv_timeout(Duration::from_millis(100)) {
                Ok(news) => {
                    let left = matches!(news, News::Left(_));
                    self.hear(news)?;
                    if left && self.args.once {
                        return Ok(());
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
        }
        Ok(())
    }

    fn hear(&mut self, news: News) -> Result<(), String> {
        match news {
            News::Came => say("a sender has come"),
            News::Left(drive) => {
                say("the sender has left");
                self.judge(&drive, false)?;
            }
            News::ProgramEnded(drive) => self.judge(&drive, true)?,
            News::Stored(memory) => {
                if let Some(file) = &self.args.eeprom {
                    keep::write(file, &memory)?;
                }
            }
        }
        Ok(())
    }

    fn judge(&mut self, drive: &crate::controller::Drive, ended: bool) -> Result<(), String> {
        if let Some(bench) = &mut self.bench
            && !drive.pieces.is_empty()
        {
            self.crashed |= bench
                .judge(drive, ended, self.out)
                .map_err(|e| format!("standard output: {e}"))?;
        }
        Ok(())
    }
}

fn machine(args: &ControllerArgs) -> Result<Machine, String> {
    let machine = super::sources::machine(&args.machine).map_err(|e| e.to_string())?;
    if !machine.speaks_grbl() {
        let family = machine.family().map_or("another controller", |f| f.title);
        return Err(format!(
            "machine {} runs {family}, and only GRBL is simulated: name a machine with a GRBL family controller",
            machine.name
        ));
    }
    Ok(machine)
}

/// The controller with its memory: the machine's figures, then those of `--settings`, unless `--eeprom` has its own. A script that opens
/// the door means a build that has a pin for it.
fn controller(
    args: &ControllerArgs,
    machine: &Machine,
    door_pin: bool,
    timed: bool,
) -> Result<Controller, String> {
    let mut memory = Memory::of_machine(machine);
    if let Some(file) = &args.settings {
        for s in read_settings(file)?.settings {
            memory.set(s.number, s.value);
        }
    }
    if let Some(file) = &args.eeprom
        && let Some(kept) = keep::read(file)?
    {
        if args.settings.is_some() {
            return Err(format!(
                "{} has settings of its own: leave --settings out, or begin with another --eeprom file",
                file.display()
            ));
        }
        memory = kept;
    }
    let build = Build {
        blocks: machine.planner_blocks,
        rx_bytes: match args.firmware {
            Profile::Grbl11h | Profile::Grbl11f => machine.rx_buffer,
            other => other.rx_bytes(),
        },
        // Only on a line that takes its time does anything arrive while the firmware writes.
        baud: timed.then_some(machine.baud),
        quirks: Quirks {
            door_pin,
            ..Quirks::default()
        },
        ..Build::of_profile(args.firmware)
    };
    let switches = switches(&memory);
    let mut controller = Controller::with_build(memory, build);
    controller.set_switches(switches);
    Ok(controller)
}

/// Limit switches where a machine parked at home has them: at the home end of each axis the pull-off away, so that homing finds them, and
/// at the other end a millimetre behind the travel.
fn switches(memory: &Memory) -> Switches {
    let (steps, travel) = (memory.axes(100), memory.axes(130));
    let (pull_off, negative) = (memory.get(27), memory.get(23) as u32);
    let mut limits = [None; 6];
    for (axis, pair) in limits.chunks_mut(2).enumerate() {
        let (home, end) = (pull_off, -(travel[axis] - pull_off + 1.0));
        let places = if negative >> axis & 1 == 1 {
            [-home, -end]
        } else {
            [end, home]
        };
        for (limit, mm) in pair.iter_mut().zip(places) {
            *limit = Some((mm * steps[axis]).round() as i64);
        }
    }
    Switches {
        limits,
        probe_z: None,
    }
}

/// Faults of the command line. Without `seed:N` the clock gives one.
fn faults(texts: &[String]) -> Result<Faults, String> {
    let mut plan = FaultPlan::default();
    for text in texts {
        plan.add(text).map_err(|e| format!("--fault: {e}"))?;
    }
    let seed = plan.seed.unwrap_or_else(|| {
        std::time::SystemTime::now()
            .duration_since(std::time::UNIX_EPOCH)
            .map_or(1, |d| u64::from(d.subsec_nanos()) ^ (d.as_secs() << 20))
    });
    Ok(Faults::new(seed, plan))
}

/// Bytes of a settings file or a pins script, at most.
const MOST_BYTES: u64 = 1 << 20;

/// The text of a small file; `kind` says what it should be.
pub(super) fn text_of(file: &Path, kind: &str) -> Result<String, String> {
    let fail = |why: String| format!("{}: cannot be read as {kind}: {why}", file.display());
    let meta = std::fs::metadata(file).map_err(|e| fail(e.to_string()))?;
    if !meta.is_file() {
        return Err(fail("it is not a file".to_string()));
    }
    if meta.len() > MOST_BYTES {
        return Err(fail(format!(
            "it has {} bytes: is this the right file?",
            meta.len()
        )));
    }
    let bytes = std::fs::read(file).map_err(|e| fail(e.to_string()))?;
    String::from_utf8(bytes)
        .map_err(|_| fail("it is not text (UTF-8): is this the right file?".to_string()))
}

/// The settings of a file.
fn read_settings(file: &Path) -> Result<SettingsFile, String> {
    let text = text_of(file, "settings")?;
    SettingsFile::read(&file.display().to_string(), &text).map_err(|e| e.to_string())
}

/// Puts the settings of `--settings` into a machine, for `check` and `mill`, so that a program is timed under them. Settings are GRBL's:
/// a machine with another controller has none.
pub(super) fn apply_settings(file: Option<&Path>, machine: &mut Machine) -> Result<(), Failure> {
    let Some(file) = file else { return Ok(()) };
    if !machine.speaks_grbl() {
        let family = machine.family().map_or("another controller", |f| f.title);
        return Err(Failure::Failed(format!(
            "--settings: machine {} runs {family}, which has no $ settings: name a machine with a GRBL family controller",
            machine.name
        )));
    }
    read_settings(file).map_err(Failure::Failed)?.apply(machine);
    Ok(())
}
