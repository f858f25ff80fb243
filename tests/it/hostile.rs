//! The built program against what users, disks and pipes do to it: rubbish in, outputs that close, signals under way. Codes and
//! words are the contract; no panic (101) and no wait without an end.
#![allow(clippy::unwrap_used)]

use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

const MACHINE: [&str; 2] = ["--machine", "longmill-30x30"];

struct Bench {
    dir: tempfile::TempDir,
}

impl Bench {
    fn new() -> Bench {
        Bench {
            dir: tempfile::tempdir().unwrap(),
        }
    }

    fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.dir.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }
}

fn morsemill(command: &str, file: &Path) -> Command {
    let mut c = Command::new(env!("CARGO_BIN_EXE_morsemill"));
    c.arg(command).arg(file).args(MACHINE).stdin(Stdio::null());
    c
}

/// Exit code and both outputs.
fn outcome(command: &mut Command) -> (i32, String) {
    let child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let o: Output = child.wait_with_output().unwrap();
    let text = String::from_utf8_lossy(&[o.stdout, o.stderr].concat()).into_owned();
    (o.status.code().unwrap_or(-1), text)
}

fn code_in_time(child: &mut Child, limit: Duration) -> i32 {
    let start = Instant::now();
    while start.elapsed() < limit {
        if let Some(status) = child.try_wait().unwrap() {
            return status.code().unwrap_or(-1);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.kill().unwrap();
    panic!("no end within {limit:?}");
}

#[test]
fn rubbish_programs_are_refused_in_words() {
    let b = Bench::new();
    let noise: Vec<u8> = (0..20_000u32)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8)
        .collect();
    let cases: [(&str, Vec<u8>, &str); 14] = [
        ("noise", noise, "problem   syntax (line"),
        (
            "empty",
            vec![],
            "the file is empty: there is no program in it",
        ),
        (
            "utf16",
            b"\xff\xfeG\x000\x00".to_vec(),
            "this is text in UTF-16: save it as plain ASCII or UTF-8",
        ),
        (
            "blank",
            b" \n\t\r\n%\n".to_vec(),
            "nothing in this text makes the machine do anything: is it the right file?",
        ),
        (
            "one-line",
            b"G1 X1 ".repeat(200_000),
            "the line has more than 1048576 bytes: this is no program text, or its line ends are lost",
        ),
        (
            "exponent",
            b"G21 G90\nG0 Z1e300\n".to_vec(),
            "column 6: E is not a word of this controller",
        ),
        ("nan", b"G0 ZNaN\n".to_vec(), "column 4: Z has no number"),
        (
            "wide",
            b"G21 G90\nM3 S12000\nG0 Z5\nG0 X999999999999\nG1 X0 F100\n".to_vec(),
            "axis X: the program reaches from",
        ),
        (
            "arc-r0",
            b"G21 G90\nG0 X0 Y0\nG2 X0 Y0 R0 F100\n".to_vec(),
            "an arc by R cannot end where it starts",
        ),
        (
            "arc-i0",
            b"G21 G90\nG0 X0 Y0\nG2 X1 Y1 I0 J0 F100\n".to_vec(),
            "(line 3)",
        ),
        (
            "feed-0",
            b"G21 G90\nG0 Z5\nG1 X1 F0\n".to_vec(),
            "this move has no feed rate",
        ),
        (
            "feed-minus",
            b"G21 G90\nG0 Z5\nG1 X1 F-5\n".to_vec(),
            "F must not be negative",
        ),
        (
            "axes",
            b"G0 A90\n".to_vec(),
            "A is not a word of this controller",
        ),
        (
            "dwell",
            b"G4 P-1\n".to_vec(),
            "P must not be negative: write a value of zero or more",
        ),
    ];
    for (name, bytes, words) in cases {
        let path = b.file(&format!("{name}.nc"), bytes);
        let (code, text) = outcome(&mut morsemill("check", &path));
        assert!(text.contains(words), "{name}: {text}");
        assert!(matches!(code, 1 | 2), "{name}: {code}");
        // `send` refuses the same, and never opens the port. What fits no machine is for `check` to say.
        if name != "wide" {
            let (code, text) = outcome(morsemill("send", &path).args(["--port", "/dev/none"]));
            assert!(matches!(code, 1 | 2), "{name}: {code}");
            assert!(!text.contains("cannot open the port"), "{name}: {text}");
        }
    }
}

/// A program far beside the part costs no more than one near it.
#[test]
fn a_program_that_wanders_kilometres_is_judged() {
    let b = Bench::new();
    let mut text = String::from("G21 G90 G17\nM3 S12000\nG0 Z5\nG0 X-10 Y5\nG1 Z-0.5 F100\n");
    for _ in 0..40 {
        text += "G1 X900000 Y900000\nX-900000\nY-900000\n";
    }
    let program = b.file("far.nc", text + "G2 X9999999 Y0 R99999999\n");
    let part = b.file("p.stl", PLATE);
    let mut child = morsemill("check", &program)
        .arg("--part")
        .arg(part)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    assert_eq!(code_in_time(&mut child, Duration::from_secs(60)), 1);
}

const PLATE: &str = "solid p\r\n\tFACET  normal 0 0 1\r\n outer   loop\r\nvertex 0 0 0\r\nvertex 12. 0 -0\r\nvertex 1.2e1 9 0\r\n\
                     endloop\r\n\r\nendfacet\r\nfacet normal 0 0 1 outer loop\r\nvertex 0 0 0 vertex 12 9 0 vertex 0 9 0\r\n\
                     endloop endfacet\r\nendsolid p\r\n";

fn binary(triangles: &[[f32; 9]], count: u32) -> Vec<u8> {
    let mut out = vec![0u8; 80];
    out.extend(count.to_le_bytes());
    for t in triangles {
        out.extend([0u8; 12]);
        out.extend(t.iter().flat_map(|v| v.to_le_bytes()));
        out.extend([0u8; 2]);
    }
    out
}

#[test]
fn odd_part_files_are_read_or_refused_in_words() {
    let b = Bench::new();
    let program = b.file(
        "g.nc",
        "G21 G90\nM3 S12000\nG0 Z5\nG0 X0 Y0\nG1 Z1 F300\nG0 Z5\n",
    );
    let t = [0.0, 0.0, 0.0, 30.0, 0.0, 0.0, 0.0, 30.0, 5.0];
    let back = [30.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 30.0, 5.0];
    let far = [1e9, 1e9, 0.0, 1.1e9, 1e9, 0.0, 1e9, 1.1e9, 9.0];
    let obj = "# q\nmtllib none.mtl\no thing\ng a b\nv 0 0 0\nv 30 0 0 1.0\nv 30 30 5\nv 0 30 5 .5 .5 .5\nusemtl m\ns off\n\
               f 1//1 2//1 3//1 4//1\ng c\nf -4 -3 -2\nl 1 2\n";
    let cases: [(&str, Vec<u8>, &str); 9] = [
        ("one.stl", binary(&[t], 1), "1 triangles"),
        ("twice.stl", binary(&[t, t, back, t], 4), "verdict"),
        ("crlf.stl", PLATE.into(), "2 triangles"),
        (
            "line.stl",
            "solid a facet normal 0 0 1 outer loop vertex 0 0 0 vertex 30 0 0 vertex 30 30 5 endloop endfacet endsolid a".into(),
            "1 triangles",
        ),
        ("quads.obj", obj.into(), "verdict"),
        (
            "flat.stl",
            binary(&[[1.0; 9], [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0]], 2),
            "none of the 2 triangles has any area",
        ),
        (
            "far.stl",
            binary(&[far], 1),
            "more than a kilometre out: repair the part",
        ),
        (
            "short.stl",
            binary(&[t], 4_000_000_000),
            "truncated STL: the header promises 4000000000 triangles",
        ),
        (
            "minus.obj",
            b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf -9 1 2\n".to_vec(),
            "minus.obj:4:1: the face uses vertex -9, but the file has 3 vertices",
        ),
    ];
    for (name, bytes, words) in cases {
        let part = b.file(name, bytes);
        let (code, text) = outcome(morsemill("check", &program).arg("--part").arg(part));
        assert!(text.contains(words), "{name}: {text}");
        assert!(matches!(code, 1 | 2), "{name}: {code}");
    }
}

#[test]
fn results_that_cannot_be_written_are_told() {
    let b = Bench::new();
    let program = b.file("g.nc", "G21 G90\nM3 S12000\nG0 Z5\nG1 X1 F300\n");
    let nowhere = b.path("none/x.json");
    let (code, text) = outcome(morsemill("check", &program).arg("--json").arg(&nowhere));
    assert!(
        code == 2 && text.contains("x.json: cannot be written"),
        "{text}"
    );
    let (code, text) = outcome(morsemill("check", &program).arg("--report").arg(&program));
    assert!(code == 2 && text.contains("g.nc: cannot be made"), "{text}");
    let sim = ["--port", "sim"];
    let (code, text) = outcome(
        morsemill("send", &program)
            .args(sim)
            .arg("--json")
            .arg(&nowhere),
    );
    assert!(
        code == 2 && text.contains("(the job itself: done)"),
        "{text}"
    );
    let (code, text) = outcome(
        morsemill("send", &program)
            .args(sim)
            .args(["--speed", "1e300"]),
    );
    assert!(
        code == 2 && text.contains("up to 1000000, or `max`"),
        "{text}"
    );
}

/// Long enough to be interrupted at real time.
fn long_job(b: &Bench) -> PathBuf {
    let passes = "G1 X30 F600\nG1 X0\n".repeat(50);
    b.file(
        "long.nc",
        format!("G21 G90\nM3 S12000\nG0 Z5\nG0 X0 Y0\nG1 Z1 F300\n{passes}G0 Z5\nM5\nM30\n"),
    )
}

fn result(json: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(json).unwrap()).unwrap()
}

/// The other end of both outputs goes away while the machine runs: the job must run on to its end.
#[cfg(unix)]
#[test]
fn closed_outputs_do_not_end_a_job() {
    let b = Bench::new();
    let json = b.path("r.json");
    let mut child = morsemill("send", &long_job(&b))
        .args(["--port", "sim", "--speed", "50", "--json"])
        .arg(&json)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    drop(child.stderr.take());
    assert_eq!(code_in_time(&mut child, Duration::from_secs(120)), 0);
    let r = result(&json);
    assert_eq!(r["result"], "done");
    assert_eq!(r["lines"], r["acknowledged"]);
}

#[cfg(unix)]
#[test]
fn signals_end_in_feed_hold_and_reset() {
    let b = Bench::new();
    let job = long_job(&b);
    for signal in ["INT", "TERM"] {
        let json = b.path("r.json");
        let mut child = morsemill("send", &job)
            .args(["--port", "sim", "--speed", "1", "--json"])
            .arg(&json)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        while !line.starts_with("connected") {
            line.clear();
            assert!(said.read_line(&mut line).unwrap() > 0, "never connected");
        }
        std::thread::sleep(Duration::from_millis(1500));
        let kill = Command::new("kill")
            .args(["-s", signal])
            .arg(child.id().to_string())
            .status();
        assert!(kill.unwrap().success());
        assert_eq!(
            code_in_time(&mut child, Duration::from_secs(30)),
            1,
            "{signal}"
        );
        let mut rest = String::new();
        said.read_to_string(&mut rest).unwrap();
        assert!(
            rest.contains("feed hold, then standstill, then reset"),
            "{rest}"
        );
        let r = result(&json);
        assert_eq!(r["result"], "stopped", "{r}");
        assert_eq!(r["position_kept"], true, "{r}");
        assert!(r["lines"].as_u64() < r["lines_total"].as_u64(), "{r}");
    }
}
