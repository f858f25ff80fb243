//! Memory does not grow with the length of a program: what is held at most, counted by the allocator, is the same for a program ten times
//! as long. A test binary of its own, since an allocator serves a whole program.
#![allow(
    unsafe_code,
    clippy::unwrap_used,
    reason = "an allocator cannot be written without; a test may panic"
)]

use morsemill::gcode::Dialect;
use morsemill::kinematics::{Clock, Settings};
use morsemill::link::resume::{Now, ProgramText, ResumeOptions, from_line};
use morsemill::link::vet::{VetOptions, vet};
use morsemill::link::{JobReader, JobSource};
use morsemill::machine::Machine;
use morsemill::simulate::{DryRunOptions, Stock, dry_run_of};
use std::alloc::{GlobalAlloc, Layout, System};
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};

/// The system's allocator, with the bytes it has lent out now and at most.
struct Counting;

static LENT: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: everything is the system allocator's doing; counting touches no memory of it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let now = LENT.fetch_add(layout.size(), SeqCst) + layout.size();
        MOST.fetch_max(now, SeqCst);
        // SAFETY: the caller keeps the rules of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        LENT.fetch_sub(layout.size(), SeqCst);
        // SAFETY: the caller keeps the rules of `dealloc`.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Bytes that some work held at most beyond what was held before.
fn held(work: impl FnOnce()) -> usize {
    let before = LENT.load(SeqCst);
    MOST.store(before, SeqCst);
    work();
    MOST.load(SeqCst) - before
}

/// A relief in rows of 1000 segments of 0.2 mm, as long as wanted, in a file.
fn relief(dir: &Path, lines: usize) -> PathBuf {
    let path = dir.join(format!("{lines}.nc"));
    let mut out = BufWriter::new(File::create(&path).unwrap());
    write!(
        out,
        "G21 G90 G94\nM3 S12000\nG0 Z10\nG0 X0 Y0\nG1 Z0 F300\nG1 F1500\n"
    )
    .unwrap();
    for k in 0..lines {
        let (row, along) = (k / 1000, k % 1000);
        let x = if row % 2 == 0 { along } else { 999 - along };
        let z = -2.0 + (x as f64 / 37.0).sin();
        let (x, y) = (0.2 * x as f64, 0.2 * (row % 500) as f64);
        writeln!(out, "X{x:.3} Y{y:.3} Z{z:.3}").unwrap();
    }
    write!(out, "G0 Z10\nM5\nM30\n").unwrap();
    out.flush().unwrap();
    path
}

fn opened(path: &Path) -> std::io::Result<Box<dyn JobReader>> {
    Ok(Box::new(BufReader::new(File::open(path)?)))
}

/// Beyond this nothing may grow from a program to one ten times as long; a digest of 16 bytes for some hundred lines is part of a job.
const SAME: usize = 32_000;
/// Nothing here may hold more, bytes.
const ENOUGH: usize = 4_000_000;

#[test]
fn ten_times_the_program_takes_the_same_memory() {
    let dir = tempfile::tempdir().unwrap();
    let machine = Machine::load("longmill-30x30").unwrap();
    let files = [10_000, 100_000].map(|lines| (lines, relief(dir.path(), lines)));
    let judged = DryRunOptions::new(0.02, Stock::Allowance(0.0));
    type Law<'a> = (&'a str, &'a dyn Fn(usize, &Path));
    let laws: [Law; 3] = [
        ("dry run", &|lines, path| {
            let run = dry_run_of(&|| opened(path), Dialect::Grbl, &machine, None, &judged);
            assert!(run.passed(), "{:?}", run.problems);
            assert_eq!(run.program.lines, lines + 9);
        }),
        ("vetting, timing, and reading to send", &|lines, path| {
            let path = path.to_path_buf();
            let source: Arc<dyn JobSource> = Arc::new(move || opened(&path));
            let mut clock = Clock::new(&Settings::from(&machine));
            let job = vet(source, VetOptions::default(), &mut |_, event| {
                clock.hear(event, &mut |_, _| {});
            });
            let job = job.unwrap();
            assert!(clock.finish(&mut |_, _| {}).total.0 > 0.0);
            let mut sent = job.lines().unwrap();
            let mut count = 0;
            while sent.next_line().unwrap().is_some() {
                count += 1;
            }
            assert_eq!((count, job.total), (lines + 9, lines + 9));
        }),
        ("beginning at a line, and its simulation", &|lines, path| {
            let path = path.to_path_buf();
            let source: Arc<dyn JobSource> = Arc::new(move || opened(&path));
            let text: &dyn ProgramText = &source.as_ref();
            let now = Now {
                state: "Idle".into(),
                position: Some([0.0; 3]),
                dialect: "grbl".into(),
                ..Now::default()
            };
            let plan = from_line(text, lines * 9 / 10, false, &now, &ResumeOptions::default());
            let plan = plan.unwrap();
            let run = dry_run_of(
                &|| plan.reader(text),
                Dialect::Grbl,
                &machine,
                None,
                &judged,
            );
            assert!(run.passed(), "{:?}", run.problems);
        }),
    ];
    for (name, law) in laws {
        // What threads and tables take once and for all is taken now.
        law(files[0].0, &files[0].1);
        let [short, long] = [0, 1].map(|k| held(|| law(files[k].0, &files[k].1)));
        assert!(long < short + SAME, "{name}: {short} and {long} bytes");
        assert!(long < ENOUGH, "{name}: {long} bytes");
    }
}
