//! The built program at a terminal: a pseudo-terminal with a window, keys pressed, the machine simulated behind a socket; and without a
//! terminal, as a script runs it. Every way out gives the terminal back as it was.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)]

use morsemill::controller::{Controller, Guests, Memory, Pace, Switches, Tcp};
use serialport::{SerialPort as _, TTYPort};
use std::fs::OpenOptions;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Patience with other processes on a busy computer; nothing is measured by it.
const PATIENCE: Duration = Duration::from_secs(120);
const BINARY: &str = env!("CARGO_BIN_EXE_morsemill");
/// Runs what it is given, says so when it has ended, and waits for Enter. Signals are for the program.
const SHELL: &str =
    r#"trap : TERM HUP INT; "$@"; code=$?; printf '<left>' >&2; read -r _; exit $code"#;

fn mill(speed: f64) -> Tcp {
    serve(controller(), speed)
}

fn controller() -> Controller {
    let mut m = Memory::default();
    for axis in 0..3 {
        m.set(110 + axis, 4000.0);
        m.set(120 + axis, 500.0);
    }
    Controller::new(m)
}

fn serve(controller: Controller, speed: f64) -> Tcp {
    let pace = Pace::Times(speed);
    Tcp::serve(controller.into(), "127.0.0.1:0", Guests::Local, pace, None).unwrap()
}

fn program(dir: &Path, text: &str) -> PathBuf {
    let path = dir.join("part.nc");
    std::fs::write(&path, text).unwrap();
    path
}

/// Minutes of cutting, were it not for the operator.
fn long_job() -> String {
    let lines: String = (1..600)
        .map(|i| format!("G1X{}Y{}F1000\n", i % 50, i % 7))
        .collect();
    format!("G21G90G54G94G17\nM3S12000\n{lines}M30\n")
}

/// The program at a terminal of 100 columns and 24 rows.
struct Desk {
    keyboard: TTYPort,
    tty: String,
    modes: String,
    child: Child,
    seen: Vec<u8>,
    mark: usize,
}

impl Desk {
    fn sit_down(args: &[&str]) -> Desk {
        let (keyboard, far) = TTYPort::pair().unwrap();
        let tty = far.name().unwrap();
        let open = || {
            OpenOptions::new()
                .read(true)
                .write(true)
                .open(&tty)
                .unwrap()
        };
        // A login's settings and a window.
        stty(&tty, &["sane", "cols", "100", "rows", "24"]);
        let modes = stty(&tty, &["-g"]);
        // Its own session with this terminal. A shell keeps it open until everything was read: with its session a terminal loses what
        // nobody has read yet.
        let child = Command::new("setsid")
            .args(["--ctty", "sh", "-c", SHELL, "sh", BINARY])
            .args(args)
            .env("NO_COLOR", "1")
            .env("TERM", "xterm")
            .stdin(open())
            .stderr(open())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        // The far side stays open in the child alone, and in `modes` by its name.
        drop(far);
        Desk {
            keyboard,
            tty,
            modes,
            child,
            seen: Vec::new(),
            mark: 0,
        }
    }

    fn press(&mut self, keys: &str) {
        self.keyboard.write_all(keys.as_bytes()).unwrap();
    }

    /// Presses a key until it has its effect: one pressed while the tool still moves stops it, and does nothing else.
    fn press_until(&mut self, keys: &str, text: &str) {
        let start = Instant::now();
        loop {
            self.press(keys);
            let pressed = Instant::now();
            while pressed.elapsed() < Duration::from_secs(6) {
                self.look();
                let new = String::from_utf8_lossy(&self.seen[self.mark..]).into_owned();
                if let Some(at) = new.find(text) {
                    self.mark += at + text.len();
                    return;
                }
            }
            assert!(
                start.elapsed() < PATIENCE,
                "waited for {text:?} of {keys:?}"
            );
        }
    }

    fn look(&mut self) {
        let mut buffer = [0; 4096];
        self.keyboard
            .set_timeout(Duration::from_millis(20))
            .unwrap();
        if let Ok(n) = self.keyboard.read(&mut buffer) {
            self.seen.extend_from_slice(&buffer[..n]);
        }
    }

    /// Until this was shown since the last call.
    fn until(&mut self, text: &str) {
        let start = Instant::now();
        loop {
            let new = String::from_utf8_lossy(&self.seen[self.mark..]).into_owned();
            if let Some(at) = new.find(text) {
                self.mark += at + text.len();
                return;
            }
            assert!(
                start.elapsed() < PATIENCE,
                "waited for {text:?}, saw {new:?}"
            );
            self.look();
        }
    }

    fn signal(&self, name: &str) {
        let group = format!("-{}", self.child.id());
        assert!(
            Command::new("kill")
                .args([name, "--", &group])
                .status()
                .unwrap()
                .success()
        );
    }

    /// Waits for the end: exit code and standard output. The terminal must be as it was, whatever happened.
    fn end(mut self) -> (i32, String) {
        self.until("<left>");
        let seen = String::from_utf8_lossy(&self.seen).into_owned();
        assert_eq!(
            stty(&self.tty, &["-g"]),
            self.modes,
            "the line discipline is as it was"
        );
        assert_eq!(
            seen.matches("\x1b[?1049h").count(),
            1,
            "one screen: {seen:?}"
        );
        assert!(seen.rfind("\x1b[?1049l") > seen.rfind("\x1b[?1049h"));
        assert!(seen.rfind("\x1b[?25h") > seen.rfind("\x1b[?25l"));
        let last_letter =
            |sequence: &str| sequence.chars().find(char::is_ascii_alphabetic) == Some('m');
        assert!(
            !seen.split("\x1b[").skip(1).any(last_letter),
            "no colour where NO_COLOR is set: {seen:?}"
        );
        self.press("\n");
        let mut out = String::new();
        let mut pipe = self.child.stdout.take().unwrap();
        pipe.read_to_string(&mut out).unwrap();
        (self.child.wait().unwrap().code().unwrap(), out)
    }
}

fn stty(tty: &str, args: &[&str]) -> String {
    let out = Command::new("stty")
        .args(["-F", tty])
        .args(args)
        .output()
        .unwrap();
    assert!(
        out.status.success(),
        "{}",
        String::from_utf8_lossy(&out.stderr)
    );
    String::from_utf8(out.stdout).unwrap()
}

/// What the controller answers to this line.
fn ask(tcp: &Tcp, line: &str) -> String {
    let mut s = TcpStream::connect(tcp.address()).unwrap();
    s.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
    s.write_all(format!("{line}\n").as_bytes()).unwrap();
    let (mut got, start) = (String::new(), Instant::now());
    while !got.contains("\nok") {
        let mut buffer = [0; 512];
        if let Ok(n) = s.read(&mut buffer) {
            got += &String::from_utf8_lossy(&buffer[..n]);
        }
        assert!(start.elapsed() < PATIENCE, "{got}");
    }
    got
}

#[test]
fn keys_hold_resume_override_and_ctrl_c_holds_before_it_stops() {
    let dir = tempfile::tempdir().unwrap();
    let file = program(dir.path(), &long_job());
    let tcp = mill(5.0);
    let port = format!("tcp://{}", tcp.address());
    let mut desk = Desk::sit_down(&["send", file.to_str().unwrap(), "--port", &port]);
    desk.until("Run      line");
    for (key, shown) in [
        (" ", "on hold, at rest"),
        ("r", "resumed"),
        ("d", "safety door: close it"),
        ("r", "resumed"),
        ("+", "(110 %)"),
        (",", "(109 %)"),
        ("0", "(100 %)"),
        ("2", "rapid 50 %"),
        ("3", "rapid 100 %"),
        ("]", "rpm (110 %)"),
        ("[", "rpm (100 %)"),
        ("f", "flood"),
        ("s", "the spindle can be stopped by itself only in a hold"),
        ("h", "on hold, at rest"),
        ("s", "on: flood"),
        ("~", "the spindle starts again"),
        ("", "resumed"),
        ("", "Run      line"),
        ("\x03", "hold: r resumes, Ctrl-C once more stops the job"),
        ("", "on hold, at rest"),
        ("\x03", "stopping"),
    ] {
        desk.press(key);
        desk.until(shown);
    }
    let (code, out) = desk.end();
    assert_eq!(code, 1);
    assert!(
        out.contains("result               stopped by the operator\n"),
        "{out}"
    );
    let readout = tcp.readout();
    let again = {
        std::thread::sleep(Duration::from_millis(300));
        tcp.readout()
    };
    assert_eq!(
        readout.position, again.position,
        "nothing moves after the stop"
    );
}

#[test]
fn a_signal_stops_in_order_and_a_lost_controller_ends_the_screen() {
    let dir = tempfile::tempdir().unwrap();
    let file = program(dir.path(), &long_job());
    for how in ["-TERM", "-HUP", "-INT", "unplugged"] {
        let tcp = mill(5.0);
        let port = format!("tcp://{}", tcp.address());
        let args = ["send", file.to_str().unwrap(), "--port", &port];
        let mut desk = Desk::sit_down(&[&args[..], &["--discard-journal"]].concat());
        desk.until("Run      line");
        let tcp = match how {
            "unplugged" => {
                tcp.stop();
                None
            }
            signal => {
                desk.signal(signal);
                Some(tcp)
            }
        };
        let (code, out) = desk.end();
        assert_eq!(code, 1, "{how}");
        let result = match tcp {
            Some(_) => "result               stopped by the operator\n",
            None => "the port is gone: check the cable and the controller's power\n",
        };
        assert!(out.contains(result), "{how}: {out}");
    }
}

/// The tool is lifted before anybody is asked, jogged down by keys, zeroed, the difference confirmed, and every work offset that was set
/// moves by it; the program goes on from where it left off.
#[test]
fn a_tool_change_by_hand_moves_every_work_offset() {
    let dir = tempfile::tempdir().unwrap();
    let text = "G21G90G54G94G17\nG0Z5\nM3S12000\nG1X3Y4F2000\nG1Z1\n(ball 6 mm)\nM6T2\nM3S9000\nX10F2000\nG0Z5\nM30\n";
    let file = program(dir.path(), text);
    let tcp = mill(10.0);
    ask(&tcp, "G10L2P2X7Y8Z-20");
    let port = format!("tcp://{}", tcp.address());
    let mut desk = Desk::sit_down(&["send", file.to_str().unwrap(), "--port", &port]);
    desk.until("lifted by 4.000 mm");
    desk.until("change to tool 2 (ball 6 mm)");
    // Two down by Page Down, a step of a tenth, one to the right.
    desk.press("\x1b[6~");
    desk.until("Z     4.000");
    desk.press_until("\x1b[6~", "Z     3.000");
    desk.press(",");
    desk.until("jog step 0.1 mm");
    desk.press_until("\x1b[C", "X     3.100");
    // A question is answered by y alone.
    desk.press_until("Z", "set work Z zero here? y does it");
    desk.press("n");
    desk.until(">>> line 7: change to tool 2");
    desk.press_until("Z", "set work Z zero here? y does it");
    desk.press("y");
    desk.until("work zero is at machine X0.000 Y0.000 Z3.000 now");
    desk.press("r");
    desk.until("the new tool is 3.000 mm longer than the old one");
    desk.press("r");
    desk.until("written to the controller (G10 L2)");
    let (code, out) = desk.end();
    assert_eq!(code, 0, "{out}");
    assert!(
        out.contains("final position       X10.000 Y4.000 Z5.000 mm, work\n"),
        "{out}"
    );
    let offsets = ask(&tcp, "$#");
    for line in [
        "[G54:0.000,0.000,3.000]",
        "[G55:7.000,8.000,-17.000]",
        "[G56:0.000,0.000,0.000]",
    ] {
        assert!(offsets.contains(line), "{offsets}");
    }
    let journal = std::fs::read_to_string(dir.path().join("part.nc.journal")).unwrap();
    assert!(journal.contains("tool_change"), "{journal}");
}

#[test]
fn before_the_start_the_machine_is_in_the_operators_hands() {
    let dir = tempfile::tempdir().unwrap();
    let file = program(dir.path(), "G21G90G54G94G17\nG1X2F1000\nM30\n");
    let tcp = mill(5.0);
    let port = format!("tcp://{}", tcp.address());
    let args = ["send", file.to_str().unwrap(), "--port", &port, "--setup"];
    let mut desk = Desk::sit_down(&args);
    desk.until("before the start: jog, home, set zero");
    desk.press(".");
    desk.until("jog step 10 mm");
    desk.press("\x1b[A");
    desk.until("Y    10.000");
    desk.press_until("H", "home the machine? It drives to its switches");
    desk.press("y");
    desk.until("homing is switched off in the controller ($22=0)");
    desk.press_until("Y", "set work Y zero here?");
    desk.press("y");
    desk.until("work zero is at machine X0.000 Y10.000 Z0.000 now");
    desk.press("x");
    let (code, out) = desk.end();
    assert_eq!((code, out.as_str()), (1, ""), "nothing is sent");
    assert!(ask(&tcp, "$#").contains("[G54:0.000,10.000,0.000]"));
    assert!(!dir.path().join("part.nc.journal").exists());
}

/// As a script runs it: events out, answers in.
struct Script {
    child: Child,
    events: BufReader<std::process::ChildStdout>,
}

impl Script {
    fn start(file: &Path, tcp: &Tcp, more: &[&str], stdin: Stdio) -> Script {
        let mut child = Command::new(BINARY)
            .args(["send", file.to_str().unwrap(), "--events", "-", "--port"])
            .arg(format!("tcp://{}", tcp.address()))
            .args(more)
            .stdin(stdin)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let events = BufReader::new(child.stdout.take().unwrap());
        Script { child, events }
    }

    /// The next event of this kind.
    fn event(&mut self, kind: &str) -> serde_json::Value {
        let mut line = String::new();
        loop {
            line.clear();
            assert!(
                self.events.read_line(&mut line).unwrap() > 0,
                "ended before {kind}"
            );
            let event: serde_json::Value = serde_json::from_str(&line).unwrap();
            if event["event"] == kind {
                return event;
            }
        }
    }

    fn say(&mut self, text: &str) {
        let input = self.child.stdin.as_mut().unwrap();
        input.write_all(text.as_bytes()).unwrap();
    }
}

#[test]
fn a_script_answers_prompts_on_standard_input() {
    let dir = tempfile::tempdir().unwrap();
    let text = "G21G90G54G94G17\nG1X2F1000\n(turn the part)\nM0\nG1X3\nM6T1\nG1X4\nM30\n";
    let file = program(dir.path(), text);
    let tcp = mill(20.0);
    let mut script = Script::start(&file, &tcp, &[], Stdio::piped());
    let prompt = script.event("prompt");
    assert_eq!(
        (&prompt["kind"], &prompt["line"], &prompt["text"]),
        (
            &serde_json::json!("pause"),
            &serde_json::json!(4),
            &serde_json::json!("turn the part")
        )
    );
    script.say("go\n");
    assert!(
        script.event("note")["text"]
            .as_str()
            .unwrap()
            .starts_with("`go` is no command: write hold, resume, stop")
    );
    script.say("resume\n");
    script.event("resumed");
    assert_eq!(script.event("prompt")["kind"], "tool_change");
    script.say("resume\n");
    assert_eq!(script.event("ended")["result"], "done");
    assert_eq!(script.child.wait().unwrap().code(), Some(0));
}

/// Measured on a plate: the difference waits for a word, as the plate has to be taken away.
#[test]
fn a_new_tool_measured_on_a_plate_is_confirmed_by_a_script() {
    let dir = tempfile::tempdir().unwrap();
    let text = "G21G90G54G94G17\nG0Z3\nG1X2F1000\nM6T1\nG1X4\nM30\n";
    let file = program(dir.path(), text);
    let mut controller = controller();
    // A plate 5 mm below machine zero, at 250 steps/mm.
    controller.set_switches(Switches {
        limits: [None; 6],
        probe_z: Some(-1250),
    });
    let tcp = serve(controller, 20.0);
    ask(&tcp, "G10L2P2X7Y8Z-20");
    let more = ["--tool-plate", "1.5", "--yes"];
    let mut script = Script::start(&file, &tcp, &more, Stdio::piped());
    assert_eq!(script.event("prompt")["kind"], "tool_change");
    script.say("resume\n");
    let confirm = script.event("confirm");
    let told = confirm["text"].as_str().unwrap();
    assert!(
        told.starts_with("the new tool is 6.5")
            && told.contains("shorter than the old one. Take the plate and its clip away"),
        "{told}"
    );
    script.say("resume\n");
    assert_eq!(script.event("ended")["result"], "done");
    assert_eq!(script.child.wait().unwrap().code(), Some(0));
    let offsets = ask(&tcp, "$#");
    let z = |name: &str| -> f64 {
        let line = offsets.lines().find_map(|l| l.strip_prefix(name)).unwrap();
        line.trim_end_matches(']')
            .split(',')
            .nth(2)
            .unwrap()
            .parse()
            .unwrap()
    };
    assert!((z("[G54:") + 6.5).abs() < 0.02, "{offsets}");
    assert!(
        (z("[G55:") - (z("[G54:") - 20.0)).abs() < 0.002,
        "{offsets}"
    );
}

#[test]
fn a_tool_change_that_nobody_can_answer_ends_the_job_in_order() {
    let dir = tempfile::tempdir().unwrap();
    let file = program(dir.path(), "G21G90G54G94G17\nG1X2F1000\nM6T1\nG1X4\nM30\n");
    let tcp = mill(20.0);
    let mut child = Command::new(BINARY)
        .args(["send", file.to_str().unwrap(), "--port"])
        .arg(format!("tcp://{}", tcp.address()))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1));
    let mut out = String::new();
    child.stdout.unwrap().read_to_string(&mut out).unwrap();
    assert!(
        out.contains("line 3: the tool has to be changed, and nobody can answer here: run it on a terminal, or write `resume` to standard input with --events"),
        "{out}"
    );
    assert_eq!(tcp.readout().position[0], 2.0);
}

#[test]
fn a_console_fed_by_a_script_waits_asks_nobody_and_tells_by_its_exit_code() {
    let run = |lines: &str, more: &[&str]| {
        let tcp = mill(20.0);
        let mut child = Command::new(BINARY)
            .args(["console", "--port"])
            .arg(format!("tcp://{}", tcp.address()))
            .args(more)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        child
            .stdin
            .take()
            .unwrap()
            .write_all(lines.as_bytes())
            .unwrap();
        let out = child.wait_with_output().unwrap();
        let text = |b: Vec<u8>| String::from_utf8(b).unwrap();
        (out.status.code(), text(out.stdout), text(out.stderr))
    };
    // `$#` in motion would be error 8: it waits for the end of the motion.
    let (code, out, err) = run("G1X2F600\n$#\n", &[]);
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(
        out.starts_with("ok\n[G54:0.000,0.000,0.000]\n") && out.ends_with("ok\n"),
        "{out}"
    );
    let (code, out, err) = run("M3S100\nG1X1\n", &[]);
    assert_eq!(code, Some(1));
    assert!(
        err.contains("not sent: `M3S100`: the spindle starts, and there is nobody to ask: --yes sends such lines"),
        "{err}"
    );
    assert!(out.starts_with("error:22   no feed rate is set."), "{out}");
    let (code, out, _) = run("M3S100\nG1X1\n", &["--yes", "--raw"]);
    assert_eq!((code, out.as_str()), (Some(1), "ok\nerror:22\n"));
}
