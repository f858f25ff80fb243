//! The fronts of the simulated controller as other programs meet them: a socket, a second client, hostile bytes, a pseudo-terminal opened
//! twice, a rehearsal over a part, ports opened by name.
#![allow(clippy::unwrap_used)]

use clap::Parser;
use morsemill::cli::controller::{ControllerArgs, run_until};
use morsemill::controller::{
    Controller, FaultPlan, Faults, Guests, Memory, News, Opening, Pace, Pty, Rig, RigOptions, Tcp,
};
use morsemill::link::port::inquiry::Inquiry;
use morsemill::link::port::{self, Port};
use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// Patience with another thread on a busy computer; nothing is measured by it.
const PATIENCE: Duration = Duration::from_secs(60);

/// Opening restarts it, and it greets at once.
const AT_ONCE: Opening = Opening::Restarts(Duration::ZERO);

fn mill() -> Controller {
    let mut m = Memory::default();
    for axis in 0..3 {
        m.set(110 + axis, 3000.0);
        m.set(120 + axis, 500.0);
    }
    Controller::new(m)
}

fn serve(rig: impl Into<Rig>) -> Tcp {
    Tcp::serve(
        rig.into(),
        "127.0.0.1:0",
        Guests::Local,
        Pace::Unbound,
        None,
    )
    .unwrap()
}

fn connect(to: SocketAddr) -> TcpStream {
    let s = TcpStream::connect(to).unwrap();
    s.set_read_timeout(Some(Duration::from_millis(20))).unwrap();
    s.set_nodelay(true).unwrap();
    s
}

/// Reads until `end` has come or the far side closes; all that came.
fn until(s: &mut TcpStream, end: &str) -> String {
    let (mut got, start) = (Vec::new(), Instant::now());
    let mut buffer = [0; 256];
    loop {
        match s.read(&mut buffer) {
            Ok(0) => break,
            Ok(n) => got.extend_from_slice(&buffer[..n]),
            Err(e)
                if matches!(
                    e.kind(),
                    std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut
                ) => {}
            Err(_) => break,
        }
        let text = String::from_utf8_lossy(&got);
        if text.contains(end) {
            break;
        }
        assert!(
            start.elapsed() < PATIENCE,
            "waited for {end:?}, got {text:?}"
        );
    }
    String::from_utf8_lossy(&got).into_owned()
}

#[test]
fn a_second_client_is_told_and_shown_out_and_the_first_goes_on() {
    let tcp = serve(mill());
    let mut first = connect(tcp.address());
    assert_eq!(
        until(&mut first, "help]\r\n"),
        "\r\nGrbl 1.1h ['$' for help]\r\n"
    );
    let mut second = connect(tcp.address());
    let said = until(&mut second, "never said");
    let local = first.local_addr().unwrap();
    assert_eq!(
        said,
        format!(
            "[MSG:Busy: {local} is connected, and one program at a time may be. Close it first]\r\n"
        )
    );
    first.write_all(b"G1X5F600\n$G\n").unwrap();
    assert!(until(&mut first, "]\r\nok\r\n").starts_with("ok\r\n[GC:G1 "));
    // The first leaves in the middle of its job: the controller goes on, and the next one finds it where it is.
    first.write_all(b"G1X7\n").unwrap();
    until(&mut first, "ok\r\n");
    drop(first);
    let start = Instant::now();
    while tcp.readout().position[0] < 7.0 {
        assert!(start.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(5));
    }
    let mut third = connect(tcp.address());
    third.write_all(b"?").unwrap();
    let said = until(&mut third, ">\r\n");
    assert!(said.starts_with("<Idle|MPos:7.000,0.000,0.000|"), "{said}");
}

#[test]
fn only_loopback_unless_told() {
    let refuse = |address: &str| {
        Tcp::serve(mill().into(), address, Guests::Local, Pace::Unbound, None)
            .err()
            .unwrap()
            .to_string()
    };
    assert_eq!(
        refuse("0.0.0.0:0"),
        "--tcp 0.0.0.0:0: anybody in the network could drive this controller there: listen on 127.0.0.1, or add --allow-remote if that is what you want"
    );
    assert!(refuse("127.0.0.1").starts_with("--tcp 127.0.0.1: write ADDRESS:PORT"));
    let taken = serve(mill());
    let at = taken.address().to_string();
    assert!(refuse(&at).starts_with(&format!("--tcp {at}: cannot listen: ")));
    let open = Tcp::serve(
        mill().into(),
        "0.0.0.0:0",
        Guests::Remote,
        Pace::Unbound,
        None,
    );
    assert!(open.unwrap().address().port() > 0);
}

#[test]
fn hostile_bytes_over_a_socket_crash_nothing() {
    let tcp = serve(mill());
    // Numbers from a fixed seed: the bytes are the same every time.
    let mut x = 0x2545_f491_4f6c_dd1d_u64;
    for round in 0..20 {
        let mut s = connect(tcp.address());
        let bytes: Vec<u8> = (0..4000)
            .map(|_| {
                x ^= x << 13;
                x ^= x >> 7;
                x ^= x << 17;
                (x >> 32) as u8
            })
            .collect();
        // It may be shown out while the one before has not been missed yet, and its writes fail then.
        let _ = s.write_all(&bytes);
        if round % 2 == 0 {
            let _ = s.read(&mut [0; 100]);
        }
    }
    // Whatever state that left: after resets it greets again. Each try is a connection of its own, as one may find the door still taken.
    let start = Instant::now();
    loop {
        let mut s = connect(tcp.address());
        let _ = s.write_all(&[0x18]);
        std::thread::sleep(Duration::from_millis(300));
        let mut buffer = [0; 4096];
        let mut got = Vec::new();
        while let Ok(n) = s.read(&mut buffer) {
            got.extend_from_slice(&buffer[..n]);
            if n == 0 {
                break;
            }
        }
        if String::from_utf8_lossy(&got).contains("Grbl 1.1h") {
            break;
        }
        assert!(
            start.elapsed() < PATIENCE,
            "{}",
            String::from_utf8_lossy(&got)
        );
    }
    assert!(tcp.stop().is_some(), "the thread is alive and ends");
}

#[test]
fn ports_by_name_reach_a_socket_and_a_pseudo_terminal() {
    let tcp = serve(mill());
    let pty = Pty::start(mill(), Pace::Times(1.0)).unwrap();
    for name in [format!("tcp://{}", tcp.address()), pty.path().to_string()] {
        let mut port: Box<dyn Port> = port::open(&name, 115_200).unwrap();
        let mut inquiry = Inquiry::default();
        let (start, mut buffer) = (Instant::now(), [0; 64]);
        let found = loop {
            let n = port.read(&mut buffer).unwrap();
            let now = start.elapsed().as_secs_f64();
            inquiry.receive(&buffer[..n], now);
            inquiry.tick(now);
            port.write(&inquiry.output()).unwrap();
            if let Some(found) = inquiry.finished() {
                break found.clone();
            }
        };
        assert_eq!(
            found.to_string(),
            "Grbl 1.1h, version 1.1h.20190830, Idle",
            "{name}"
        );
    }
}

#[test]
fn each_opening_of_a_pseudo_terminal_greets_anew() {
    let (sender, news) = mpsc::channel();
    let pty = Pty::serve(mill().into(), AT_ONCE, Pace::Times(1.0), Some(sender)).unwrap();
    for _ in 0..3 {
        let mut port = port::open(pty.path(), 115_200).unwrap();
        assert_eq!(news.recv_timeout(PATIENCE).unwrap(), News::Came);
        let (mut got, mut buffer) = (Vec::new(), [0; 64]);
        while !got.ends_with(b"help]\r\n") {
            let n = port.read(&mut buffer).unwrap();
            got.extend_from_slice(&buffer[..n]);
        }
        assert_eq!(got, b"\r\nGrbl 1.1h ['$' for help]\r\n");
        // No echo, and a carriage return arrives as one: two line ends, two answers.
        port.write(b"$\r\n").unwrap();
        got.clear();
        while !got.ends_with(b"ok\r\nok\r\n") {
            let n = port.read(&mut buffer).unwrap();
            got.extend_from_slice(&buffer[..n]);
        }
        assert!(
            got.starts_with(b"[HLP:"),
            "{}",
            String::from_utf8_lossy(&got)
        );
        drop(port);
        assert!(matches!(
            news.recv_timeout(PATIENCE).unwrap(),
            News::Left(_)
        ));
    }
}

/// A sender as many are: it opens the device as a file and sets nothing, wakes the controller with two line ends, then sends a line, waits
/// for its `ok`, and the next; it comes a second time for the next job.
#[test]
fn a_plain_sender_of_another_maker() {
    use std::io::{BufRead as _, BufReader};
    let (sender, news) = mpsc::channel();
    let pty = Pty::serve(mill().into(), AT_ONCE, Pace::Unbound, Some(sender)).unwrap();
    for job in 1..=2 {
        let mut file = std::fs::OpenOptions::new()
            .read(true)
            .write(true)
            .open(pty.path())
            .unwrap();
        let mut lines = BufReader::new(file.try_clone().unwrap())
            .lines()
            .map(|l| l.unwrap());
        let mut next = || {
            lines
                .find(|l| !l.trim().is_empty())
                .unwrap()
                .trim()
                .to_string()
        };
        let mut said = next();
        while said.starts_with('<') {
            // The answers to the last questions of the one before may be on their way still.
            said = next();
        }
        assert_eq!(said, "Grbl 1.1h ['$' for help]");
        file.write_all(b"\r\n\r\n").unwrap();
        for _ in 0..4 {
            assert_eq!(next(), "ok");
        }
        for k in 0..60 {
            file.write_all(format!("G1 X{}.5 Y{k} F2000\n", k % 5).as_bytes())
                .unwrap();
            assert_eq!(next(), "ok", "line {k} of job {job}");
        }
        file.write_all(b"G4 P0\n?").unwrap();
        let mut said = next();
        while !said.starts_with("<Idle|MPos:4.500,59.000,0.000|") {
            file.write_all(b"?").unwrap();
            said = next();
        }
        drop((file, lines));
        // Nobody opens a device again sooner than its closing can be seen.
        while !matches!(news.recv_timeout(PATIENCE).unwrap(), News::Left(_)) {}
    }
    assert_eq!(pty.readout().bytes_lost, 0);
}

/// Opens it as a file that never blocks, setting nothing.
fn open_raw(path: &str) -> std::fs::File {
    use std::os::unix::fs::OpenOptionsExt as _;
    std::fs::OpenOptions::new()
        .read(true)
        .write(true)
        .custom_flags(rustix::fs::OFlags::NONBLOCK.bits().cast_signed())
        .open(path)
        .unwrap()
}

/// Reads until `end` has come; all that came.
fn read_until(file: &mut std::fs::File, end: &str) -> String {
    let (mut got, start, mut buffer) = (Vec::new(), Instant::now(), [0; 512]);
    loop {
        if let Ok(n) = file.read(&mut buffer) {
            got.extend_from_slice(&buffer[..n]);
        }
        let text = String::from_utf8_lossy(&got).into_owned();
        if text.contains(end) {
            return text;
        }
        assert!(
            start.elapsed() < PATIENCE,
            "waited for {end:?}, got {text:?}"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn wait_for(what: &str, mut is: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is() {
        assert!(start.elapsed() < PATIENCE, "waited for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// However soon it is opened again, the opening is one.
#[cfg(target_os = "linux")]
#[test]
fn an_opening_right_behind_a_closing_restarts_too() {
    let pty = Pty::serve(mill().into(), AT_ONCE, Pace::Times(100.0), None).unwrap();
    let mut file = open_raw(pty.path());
    for round in 0..30 {
        let said = read_until(&mut file, "help]\r\n");
        assert!(
            said.ends_with("\r\nGrbl 1.1h ['$' for help]\r\n"),
            "round {round}: {said:?}"
        );
        file.write_all(b"G0X5\n").unwrap();
        assert!(read_until(&mut file, "ok\r\n").starts_with("ok\r\n"));
        wait_for("X5", || pty.readout().position[0] == 5.0);
        drop(file);
        file = open_raw(pty.path());
    }
    // A second program that opens it meanwhile restarts nothing, nor does its leaving.
    read_until(&mut file, "help]\r\n");
    file.write_all(b"G0X5\n").unwrap();
    read_until(&mut file, "ok\r\n");
    wait_for("X5", || pty.readout().position[0] == 5.0);
    drop(open_raw(pty.path()));
    let other = open_raw(pty.path());
    file.write_all(b"?").unwrap();
    assert!(read_until(&mut file, ">\r\n").starts_with("<Idle|MPos:5.000,"));
    drop(other);
    file.write_all(b"?").unwrap();
    assert!(read_until(&mut file, ">\r\n").starts_with("<Idle|MPos:5.000,"));
}

#[test]
fn what_opening_does_is_a_matter_of_the_board() {
    let serve = |opening| {
        let (sender, news) = mpsc::channel();
        let pty = Pty::serve(mill().into(), opening, Pace::Unbound, Some(sender)).unwrap();
        (pty, news)
    };
    // Moves it, leaves, and waits until that was seen: what is said within the same moment as a closing may be taken for the last words
    // of the host that left.
    let moved = |pty: &Pty, news: &mpsc::Receiver<News>| {
        let mut file = open_raw(pty.path());
        read_until(&mut file, "help]\r\n");
        file.write_all(b"G0X5\nG4P0\n").unwrap();
        read_until(&mut file, "ok\r\nok\r\n");
        assert_eq!(pty.readout().position[0], 5.0);
        drop(file);
        while !matches!(news.recv_timeout(PATIENCE).unwrap(), News::Left(_)) {}
    };
    // It greets a little later, and hears then what was said at once.
    let (pty, news) = serve(Opening::Restarts(Duration::from_millis(60)));
    moved(&pty, &news);
    let mut file = open_raw(pty.path());
    file.write_all(b"$I\n").unwrap();
    let said = read_until(&mut file, "ok\r\n");
    file.write_all(b"?").unwrap();
    let said = said + &read_until(&mut file, ">\r\n");
    assert!(
        said.starts_with("\r\nGrbl 1.1h ['$' for help]\r\n"),
        "{said}"
    );
    assert!(
        said.contains("[VER:") && said.contains("<Idle|MPos:0.000,"),
        "{said}"
    );
    // A boot loader eats it.
    let (pty, _) = serve(Opening::BootLoader(Duration::from_millis(60)));
    let mut file = open_raw(pty.path());
    file.write_all(b"$I\n?").unwrap();
    let said = read_until(&mut file, "help]\r\n");
    file.write_all(b"$G\n").unwrap();
    let said = said + &read_until(&mut file, "ok\r\n");
    assert!(said.contains("help]\r\n[GC:"), "{said}");
    // Reset not wired: it is found where it was left.
    let (pty, news) = serve(Opening::Nothing);
    moved(&pty, &news);
    let mut file = open_raw(pty.path());
    file.write_all(b"?").unwrap();
    assert!(read_until(&mut file, ">\r\n").starts_with("<Idle|MPos:5.000,"));
}

/// A sender that hangs: it asks and asks and never reads. The machine goes on, and once it reads again it is answered.
#[test]
fn a_host_that_does_not_read_stops_nothing() {
    let pty = Pty::serve(mill().into(), AT_ONCE, Pace::Times(1000.0), None).unwrap();
    let mut file = open_raw(pty.path());
    read_until(&mut file, "help]\r\n");
    file.write_all(b"G1X100F600\n").unwrap();
    // Each asks for more than a KiB: far more than the kernel keeps.
    let mut asked = 0;
    wait_for("questions", || {
        asked += usize::from(file.write(b"$$\n?").is_ok());
        asked > 400
    });
    wait_for("the end of the way", || pty.readout().position[0] == 100.0);
    wait_for("an answer", || {
        let mut all = Vec::new();
        let _ = file.read_to_end(&mut all);
        file.write_all(b"?").unwrap();
        String::from_utf8_lossy(&all).contains("<Idle|MPos:100.000,")
    });
    assert!(pty.stop().is_some(), "its thread does not hang");
}

#[test]
fn telnet_programs_reset_and_hold_nothing() {
    let tcp = serve(mill());
    let mut s = connect(tcp.address());
    until(&mut s, "help]\r\n");
    // Offers that telnet programs make: terminal type (24, GRBL's reset), flow control (33, its hold).
    s.write_all(b"G1X5F6000\n\xff\xfb\x18\xff\xfd\x21G4P0\n?")
        .unwrap();
    let (mut got, start) = (Vec::new(), Instant::now());
    while !String::from_utf8_lossy(&got).contains("<Idle|MPos:5.000,") {
        let mut buffer = [0; 256];
        if let Ok(n) = s.read(&mut buffer) {
            got.extend_from_slice(&buffer[..n]);
        }
        s.write_all(b"?").unwrap();
        assert!(start.elapsed() < PATIENCE);
    }
    let declined = [0xff, 0xfe, 0x18, 0xff, 0xfc, 0x21];
    assert!(
        got.windows(6).any(|w| w == declined),
        "the offers are declined"
    );
    let text = String::from_utf8_lossy(&got);
    assert!(!text.contains("Grbl") && !text.contains("Hold"), "{text}");
}

/// A second client that talks at once is told all the same, and nothing of what it says is carried out.
#[test]
fn a_second_client_is_refused_the_write_side() {
    let tcp = serve(mill());
    let mut first = connect(tcp.address());
    until(&mut first, "help]\r\n");
    for _ in 0..20 {
        let mut second = connect(tcp.address());
        let _ = second.write_all(b"\x18G0X9\n?$H\n");
        assert!(until(&mut second, "never said").starts_with("[MSG:Busy: "));
    }
    first.write_all(b"G4P0\n").unwrap();
    assert_eq!(until(&mut first, "ok\r\n"), "ok\r\n");
    first.write_all(b"?").unwrap();
    let said = until(&mut first, ">\r\n");
    assert!(said.starts_with("<Idle|MPos:0.000,"), "{said}");
}

#[test]
fn a_name_for_the_pseudo_terminal_comes_and_goes_with_it() {
    let dir = tempfile::tempdir().unwrap();
    let link = dir.path().join("mill");
    let name = link.display().to_string();
    let words = ["c", "--pty", "--speed", "max", "--link", &name];
    let args = Cli::try_parse_from(words).unwrap().controller;
    let (out, stop) = (Shared::default(), Arc::new(AtomicBool::new(false)));
    let (mut writer, stopper) = (out.clone(), stop.clone());
    let thread = std::thread::spawn(move || run_until(&args, &mut writer, &stopper));
    wait_for("its path", || out.text().ends_with('\n'));
    assert_eq!(
        std::fs::read_link(&link).unwrap().to_str(),
        Some(out.text().trim())
    );
    let mut file = open_raw(&name);
    read_until(&mut file, "help]\r\n");
    drop(file);
    stop.store(true, Ordering::Relaxed);
    assert_eq!(thread.join().unwrap(), 0);
    assert!(std::fs::read_link(&link).is_err(), "it is gone");
    std::fs::write(&link, "mine").unwrap();
    let args = Cli::try_parse_from(words).unwrap().controller;
    assert_eq!(
        run_until(&args, &mut Vec::new(), &AtomicBool::new(false)),
        2
    );
    assert!(Cli::try_parse_from(["c", "--tcp", "127.0.0.1:0", "--link", "x"]).is_err());
    assert!(Cli::try_parse_from(["c", "--tcp", "127.0.0.1:0", "--on-open", "nothing"]).is_err());
}

/// A session-like exchange with faults, in virtual time, by the wall clock of nobody: twice the same.
#[test]
fn faults_replay_without_any_front() {
    let run = |seed| {
        let mut plan = FaultPlan::default();
        for f in [
            "drop:0.01",
            "flip:0.01",
            "lose-ok:0.1",
            "delay:5ms",
            "reset-at-line:40",
        ] {
            plan.add(f).unwrap();
        }
        let mut rig = Rig::new(
            mill(),
            RigOptions {
                faults: Faults::new(seed, plan),
                ..RigOptions::default()
            },
        );
        let mut log = Vec::new();
        for k in 0..200 {
            rig.feed(format!("G1X{}F1000\n?", k % 7).as_bytes());
            rig.advance(0.05);
            log.extend(rig.output());
        }
        (log, rig.faults().tally(), rig.controller().position())
    };
    let first = run(3);
    assert_eq!(run(3), first);
    assert_ne!(run(4).0, first.0);
    assert!(first.1.dropped > 0 && first.1.flipped > 0 && first.1.oks_lost > 0);
    assert_eq!(first.1.restarts, 1);
}

#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    controller: ControllerArgs,
}

/// Where `morsemill controller` writes its results, to be read while it runs.
#[derive(Clone, Default)]
struct Shared(Arc<std::sync::Mutex<Vec<u8>>>);

impl Shared {
    fn text(&self) -> String {
        String::from_utf8(self.0.lock().unwrap().clone()).unwrap()
    }
}

impl std::io::Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Runs `morsemill controller --tcp` with these words and a plain sender of a program; exit code, what it printed, and what the
/// controller said.
fn controller(words: &[&str], program: &str) -> (u8, String, String) {
    let all = [
        &[
            "controller",
            "--tcp",
            "127.0.0.1:0",
            "--speed",
            "max",
            "--once",
        ],
        words,
    ]
    .concat();
    let args = Cli::try_parse_from(all).unwrap().controller;
    let out = Shared::default();
    let stop = Arc::new(AtomicBool::new(false));
    let (mut writer, stopper) = (out.clone(), stop.clone());
    let thread = std::thread::spawn(move || run_until(&args, &mut writer, &stopper));
    let start = Instant::now();
    let address = loop {
        if let Some((line, _)) = out.text().split_once('\n') {
            break line.strip_prefix("tcp://").unwrap().parse().unwrap();
        }
        if thread.is_finished() {
            return (thread.join().unwrap(), out.text(), String::new());
        }
        assert!(start.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(2));
    };
    let mut s = connect(address);
    let mut said = until(&mut s, "help]\r\n");
    for line in program.lines() {
        s.write_all(format!("{line}\n").as_bytes()).unwrap();
        said += &until(&mut s, "ok\r\n");
    }
    // What is still queued is driven before it leaves.
    let start = Instant::now();
    loop {
        s.write_all(b"?").unwrap();
        if until(&mut s, ">\r\n").contains("<Idle") {
            break;
        }
        assert!(start.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(20));
    }
    drop(s);
    let code = thread.join().unwrap();
    stop.store(true, Ordering::Relaxed);
    (code, out.text(), said)
}

const PLATE: &str = "solid p
facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 12 0 0\nvertex 12 9 0\nendloop\nendfacet
facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 12 9 0\nvertex 0 9 0\nendloop\nendfacet
endsolid p\n";

#[test]
fn a_rehearsal_shows_the_cut_and_fails_on_a_crash() {
    let dir = tempfile::tempdir().unwrap();
    let part = dir.path().join("p.stl").display().to_string();
    std::fs::write(&part, PLATE).unwrap();
    let mut text = String::from("G21 G90\nM3 S12000\nG0 Z20\nG0 X-4 Y0\nG0 Z2\nG1 Z0 F500\n");
    for k in 0..=15 {
        let y = 0.6 * f64::from(k);
        let (a, b) = if k % 2 == 0 { (-4, 16) } else { (16, -4) };
        text += &format!("G1 X{a} Y{y:.3} F1500\nX{b}\n");
    }
    let words = ["--part", part.as_str(), "--origin", "part", "--up", "+z"];
    let (code, said, _) = controller(&words, &(text.clone() + "G0 Z20\nM5\nM30"));
    assert!(said.contains("\nrehearsal 1: program, "), "{said}");
    assert!(said.ends_with("verdict   pass\n"), "{said}");
    assert_eq!(code, 0, "{said}");
    // Never lifted before it goes home: a rapid through stock that still stands.
    let (code, said, _) = controller(
        &words,
        "G21 G90\nM3 S12000\nG0 Z20\nG0 X-4 Y4\nG0 Z0\nG0 X6\nG0 Z20",
    );
    assert!(
        said.contains("rehearsal 1: way without an M2 or M30, 0.0 mm at feed"),
        "{said}"
    );
    assert!(said.contains("problem   collision: after "), "{said}");
    assert!(said.ends_with("verdict   crash\n"), "{said}");
    assert_eq!(code, 1);
    let (code, _, _) = controller(&words, &(text + "G1 X6 Z-0.1\nG0 Z20\nM5\nM30"));
    assert_eq!(code, 1, "a gouge");
}

#[test]
fn what_the_command_line_cannot_carry_out_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = dir.path().join(name).display().to_string();
        std::fs::write(&path, text).unwrap();
        path
    };
    let bad = file("bad.txt", "$110=fast\n");
    let pins = file("pins.txt", "soon probe on\n");
    for words in [
        &["--settings", bad.as_str()][..],
        &["--pins", pins.as_str()],
        &["--fault", "loose-ok:0.1"],
        &["--machine", "no-such-mill"],
        &["--part", "no-such-part.stl"],
    ] {
        assert_eq!(
            controller(words, ""),
            (2, String::new(), String::new()),
            "{words:?}"
        );
    }
    let parse = |words: &[&str]| Cli::try_parse_from(words).err().unwrap().to_string();
    assert!(parse(&["c", "--pty", "--tcp", "127.0.0.1:0"]).contains("cannot be used with"));
    assert!(parse(&["c", "--allow-remote"]).contains("--tcp"));
    assert!(parse(&["c", "--work-zero", "1,2"]).contains("write three numbers of mm with commas"));
}

#[test]
fn settings_of_a_file_are_the_controllers() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("s.txt").display().to_string();
    std::fs::write(&path, "$110=1234\n$22=0\n$13=0\n").unwrap();
    let args = Cli::try_parse_from(["c", "--settings", &path])
        .unwrap()
        .controller;
    // Not served: how to reach it was not said.
    let mut out = Vec::new();
    assert_eq!(run_until(&args, &mut out, &AtomicBool::new(false)), 2);
    let kept = dir.path().join("eeprom.txt").display().to_string();
    // Homing finds its switches, and what is set stays for the next run.
    std::fs::write(
        &path,
        "$110=1234\n$22=1\n$130=30\n$131=30\n$132=30\n$25=1500\n",
    )
    .unwrap();
    let (code, _, said) = controller(
        &["--settings", &path, "--eeprom", &kept],
        "$H\nG10L2P2X-1.5Y-2Z-3\n$N0=G55\n$13=1\n?",
    );
    assert_eq!(code, 0);
    assert!(said.contains("unlock]\r\n"), "{said}");
    let text = std::fs::read_to_string(&kept).unwrap();
    assert!(
        text.contains("$13=1\n")
            && text.contains("$N0=G55\n")
            && text.contains("\nG55=-1.5,-2,-3\n"),
        "{text}"
    );
    let (_, _, said) = controller(&["--eeprom", &kept], "$H\n$$\n$#");
    assert!(
        said.contains("$13=1\r\n") && said.contains("$110=1234.000\r\n"),
        "{said}"
    );
    assert!(said.contains("[G55:-0.0591,-0.0787,-0.1181]"), "{said}");
    assert!(said.contains(">G55:ok"), "{said}");
    std::fs::write(&kept, "$110=1e3x").unwrap();
    assert_eq!(controller(&["--eeprom", &kept], "").0, 2);
    std::fs::write(&path, "$110=1234\n$22=0\n$13=0\n").unwrap();
    let (code, _, said) = controller(&["--settings", &path], "$$");
    assert_eq!(code, 0);
    assert!(said.contains("$110=1234.000\r\n$111=4000.000"), "{said}");
}
