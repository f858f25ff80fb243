#![allow(clippy::unwrap_used)]
use super::*;
use crate::gcode::Dialect;
use crate::link::Known;
use crate::link::job::{JobReader, Standstill, Text};
use crate::link::progress::PromptKind;
use crate::wire::{Firmware, LINE_CHARS};
use proptest::prelude::*;
use std::io::{BufRead, Read, Seek, SeekFrom};
use std::sync::Mutex;

fn vetted(text: &str, options: VetOptions) -> Result<Job, Vec<JobError>> {
    vet(Arc::new(Text(text.into())), options, &mut |_, _| {})
}

fn refused_by(text: &str, options: VetOptions) -> String {
    let errors = vetted(text, options).unwrap_err();
    let list: Vec<String> = errors.iter().map(ToString::to_string).collect();
    list.join("\n")
}

fn refused(text: &str) -> String {
    refused_by(text, VetOptions::default())
}

fn lines(job: &Job) -> Vec<JobLine> {
    let mut lines = job.lines().unwrap();
    std::iter::from_fn(|| lines.next_line().unwrap()).collect()
}

#[test]
fn strips_what_the_controller_would_and_keeps_the_line_numbers() {
    let job = Job::vet("%\n(part ?! \u{e9})\ng21 g90 ; mm\n\nG1 X1.5 Y2 (cut~) F300\nG4 P2\n%\n")
        .unwrap();
    let sent = lines(&job);
    let texts: Vec<(usize, &str)> = sent.iter().map(|l| (l.source, l.text.as_str())).collect();
    assert_eq!(texts, [(3, "G21G90"), (5, "G1X1.5Y2F300"), (6, "G4P2")]);
    assert_eq!(sent[2].standstill, Standstill::Yes { dwell: 2.0 });
    assert_eq!(job.end, [Some(1.5), Some(2.0), None]);
    assert_eq!((job.total, job.bytes, job.source_lines), (3, 7 + 13 + 5, 7));
}

/// Each refusal, where it stands and what it says.
#[test]
fn refuses_what_must_not_be_streamed_by_line_and_column() {
    let buffer = VetOptions {
        rx_bytes: 40,
        ..VetOptions::default()
    };
    let tools = VetOptions {
        tool_changes: ToolChanges::Refuse,
        ..VetOptions::default()
    };
    for (text, starts, says) in [
        (
            "G21\nG10 L2 P1 X0\n",
            "2:1 ",
            "G10 writes the controller's memory",
        ),
        ("G21 G28.1\n", "1:5 ", "G28.1 writes"),
        ("G30.10\n", "1:1 ", "G30.1 writes"),
        ("  $H\n", "1:3 ", "a $ command does not belong into a job"),
        ("$100=250\n", "1:1 ", "a $ command"),
        ("G0X1\n /G0X1\n", "2:2 ", "block delete"),
        ("G0 X1 / Y2\n", "1:7 ", "drops this slash"),
        ("G0 X1!\n", "1:6 ", "would act at once"),
        ("(what?) G0 X1 ?\n", "1:15 ", "'?'"),
        ("G0 X1\u{e9}\n", "1:6 ", "would act at once"),
        ("G0X1~\n", "1:5 ", "'~'"),
        ("G1X1\n", "1:1 ", "error:22"),
        ("G0 X\n", "1:4 ", "error:2)"),
        ("G0 X1 %\n", "1:7 ", "error:1)"),
        ("G2 F100 I5\n", "1:", "error:26"),
        ("F100 G2 X5\n", "1:", "error:35"),
        ("F100 G2 X10 R1\n", "1:", "error:34"),
        ("F100 G2 X10 Y3 I5 J0\n", "1:", "error:33"),
        ("F100 G2 Z-3 R5\n", "1:", "error:32"),
        ("G0 X0 Y0\nF100 G2 X0 Y0 Z-3 R5\n", "2:", ""),
        ("G0 G1 X1\n", "1:4 ", "error:24"),
        ("G17 G18\n", "1:5 ", "error:21"),
        ("G64\n", "1:1 ", "error:20"),
        ("G59.1\n", "1:1 ", "error:"),
        ("G4\n", "1:1 ", "error:28"),
        ("T1 M6 G0 X1\n", "1:4 ", "shares its line"),
        ("", "1:1 ", "no line to send"),
        ("(nothing)\n\n", "2:1 ", "no line to send"),
    ] {
        let said = refused(text);
        assert!(said.starts_with(starts), "{text:?}: {said}");
        assert!(said.contains(says), "{text:?}: {said}");
    }
    let long = format!("G0 X{}\n", "0".repeat(90));
    assert!(refused(&long).contains("at most 79") && refused(&long).contains("error:11"));
    let said = refused_by("G1 X1.000001 Y2.000001 Z3.0000001 F100.000001\n", buffer);
    assert!(
        said.starts_with("1:1 the line has 42 bytes, but the controller's receive buffer takes 39"),
        "{said}"
    );
    assert!(
        refused_by("G0X1\nT1 M6\n", tools).starts_with("2:4 a tool change: cut the program at M6")
    );
}

#[test]
fn an_arc_by_radius_that_goes_straight_up_is_refused() {
    let said = refused("G0 X5 Y5\nG3 X5 Y5 Z-3 R5 F100\n");
    assert!(said.starts_with("2:"), "{said}");
}

#[test]
fn at_most_so_many_errors_and_one_per_run_of_missing_feeds() {
    assert_eq!(Job::vet(&"G1X1\n".repeat(100)).unwrap_err().len(), 1);
    assert_eq!(
        Job::vet(&"G64\n".repeat(100)).unwrap_err().len(),
        MAX_ERRORS
    );
}

#[test]
fn the_end_is_known_only_where_the_text_decides_it() {
    assert_eq!(Job::vet("G0 X1 Y1 Z1\nG53 G0 Z0\n").unwrap().end, [None; 3]);
    assert_eq!(
        Job::vet("G0 X1 Y1 Z1\nG91\nG0 X1\n").unwrap().end,
        [Some(2.0), Some(1.0), Some(1.0)]
    );
    assert_eq!(Job::vet("G91\nG0 X1\n").unwrap().end, [None; 3]);
    assert_eq!(
        Job::vet("G0 X1\nG92 X0\nG0 X5 Z2\nM30\n").unwrap().end,
        [Some(5.0), None, Some(2.0)]
    );
}

#[test]
fn block_delete_is_skipped_or_kept_as_told() {
    let with = |block_delete| VetOptions {
        block_delete,
        ..VetOptions::default()
    };
    let text = "G0X1\n/ G0 X2\nG0X3\n";
    let skipped = vetted(text, with(BlockDelete::Skip)).unwrap();
    assert_eq!(skipped.total, 2);
    assert!(
        skipped
            .warnings
            .iter()
            .any(|w| w.to_string() == "2:1 lines that begin with / are left out")
    );
    let kept = vetted(text, with(BlockDelete::Keep)).unwrap();
    assert_eq!(lines(&kept)[1].text, "G0X2");
    let said = refused_by("/ G0 X\n", with(BlockDelete::Keep));
    assert!(said.starts_with("1:6 "), "{said}");
}

#[test]
fn memory_writers_go_alone_when_allowed() {
    let options = VetOptions {
        memory_writers: MemoryWriters::Barrier,
        ..VetOptions::default()
    };
    let job = vetted("G10 L2 P2 X5\nG0X1\n$110=600\nG28.1\n", options.clone()).unwrap();
    let writers: Vec<bool> = lines(&job).iter().map(|l| l.writes_memory).collect();
    assert_eq!(writers, [true, false, true, true]);
    // These would make the session misread what comes back.
    for text in ["$13=1\n", "$10=0\n", "$H\n", "$RST=*\n", "$J=X1F1\n"] {
        assert!(
            refused_by(text, options.clone()).contains("a $ command"),
            "{text}"
        );
    }
}

#[test]
fn stops_carry_the_comment_beside_them() {
    let options = VetOptions {
        optional_stops: OptionalStops::Stop,
        ..VetOptions::default()
    };
    let job = vetted(
        "M0 (turn the part)\n; look at the chip\nM1\nG0 X1\nT2 M6 (3 mm ball)\nM3 S1000\n",
        options,
    )
    .unwrap();
    let sent = lines(&job);
    let prompts: Vec<String> = sent
        .iter()
        .filter_map(|l| l.prompt.as_ref().map(ToString::to_string))
        .collect();
    assert_eq!(
        prompts,
        [
            "the program pauses at line 1 (turn the part): resume when ready",
            "the program pauses at line 3 (look at the chip): resume when ready",
            "line 5: change to tool 2 (3 mm ball): resume when ready",
        ]
    );
    assert_eq!(
        (sent[1].text.as_str(), sent[3].text.as_str()),
        ("M0", "M5M9")
    );
    assert!(matches!(
        sent[3].prompt.as_ref().unwrap().kind,
        PromptKind::ToolChange { tool: 2 }
    ));
    // Unless told, M1 goes as it is.
    assert!(lines(&Job::vet("M1\n").unwrap())[0].prompt.is_none());
}

#[test]
fn modes_never_set_and_other_doubts_are_warned_of_by_name() {
    let told = |text: &str| -> Vec<String> {
        Job::vet(text)
            .unwrap()
            .warnings
            .iter()
            .map(ToString::to_string)
            .collect()
    };
    assert_eq!(
        told("G21 G54\nG0 X1\nG2 X2 I0.5 F100\n"),
        [
            "2:1 the program moves without having set G90 or G91 (distances): G90, absolute is set for it before the job",
            "3:1 the program moves without having set G93 or G94 (feed mode): G94, per minute is set for it before the job",
            "3:1 the program moves without having set G17, G18 or G19 (plane of arcs): G17, XY is set for it before the job",
        ]
    );
    assert!(told("G17 G21 G54 G90 G94\nG1 X1 F100\nG2 X2 I0.5\nM30\n").is_empty());
    let behind = told("G21 G90 G54\nG0 X1\nM2\nG0 X2\n");
    assert!(
        behind[0].starts_with("4:1 the program goes on behind its end"),
        "{behind:?}"
    );
    let off = told("G21 G90 G54 G94\nM3 S100\nG1 X1 F100\nT2 M6\nG1 X2\n");
    assert!(
        off[0].starts_with(
            "5:1 after the tool change before it, this line cuts with the spindle off"
        ),
        "{off:?}"
    );
}

fn known(settings: &[(u16, f64)], machine: [f64; 3], g54: [f64; 3]) -> Known {
    let mut known = crate::link::Introduction::new(Default::default(), Default::default())
        .known()
        .clone();
    known.firmware = Firmware::Grbl11;
    known.settings = settings.to_vec();
    known.offsets.g5x = [Some([0.0; 3]); 6];
    known.offsets.g5x[0] = Some(g54);
    known.offsets.g92 = Some([0.0; 3]);
    known.machine_position = Some(machine);
    known
}

const HOMED: [(u16, f64); 5] = [
    (20, 1.0),
    (22, 1.0),
    (130, 300.0),
    (131, 200.0),
    (132, 80.0),
];

#[test]
fn limits_are_the_machine_s_own_where_it_told_them() {
    let options = VetOptions::of(
        &known(&HOMED, [-1.0, -1.0, -1.0], [-290.0, -190.0, -40.0]),
        Some([500.0; 3]),
    );
    assert_eq!(
        options.limits,
        Limits::Box {
            low: [-300.0, -200.0, -80.0],
            high: [0.0; 3],
            soft: true
        }
    );
    vetted(
        "G0 Z5\nG0 X0 Y0\nG1 Z-20 F100\nX290\nG53 G0 Z0\n",
        options.clone(),
    )
    .unwrap();
    let said = refused_by("G0 Z5\nG1 X291 F100\n", options.clone());
    assert_eq!(
        said,
        "2:1 X would go to 1.000 in machine coordinates, outside of -300.000 to 0.000 (the controller would answer ALARM:2): move the \
         work zero or the program"
    );
    // An arc whose ends are inside but whose middle is not.
    let said = refused_by("G0 X0 Y185\nG2 X20 Y185 I10 F100\n", options.clone());
    assert!(said.starts_with("2:1 Y would go to 5.000"), "{said}");
    assert!(refused_by("G53 G0 Z1\n", options.clone()).starts_with("1:1 Z would go to 1.000"));
    // In another work system the same line goes elsewhere.
    assert!(
        refused_by("G55 G0 X-5 Y-5 Z-5\nG0 X1\n", options).starts_with("2:1 X would go to 1.000")
    );
}

#[test]
fn without_a_home_only_the_size_is_known_and_who_told_it() {
    let unhomed = known(
        &[(22, 0.0), (130, 300.0), (131, 200.0), (132, 80.0)],
        [0.0; 3],
        [0.0; 3],
    );
    let options = VetOptions::of(&unhomed, None);
    vetted("G0 X-100\nG0 X200\n", options.clone()).unwrap();
    assert_eq!(
        refused_by("G0 X-100\nG0 X200.5\n", options),
        "2:1 with this line the program takes 300.500 mm along X, but the machine has 300.000 ($130 to $132): make the part smaller, or \
         turn it"
    );
    let silent = VetOptions::of(&known(&[], [0.0; 3], [0.0; 3]), Some([100.0; 3]));
    assert!(refused_by("G0 Y-1\nG0 Y100\n", silent).contains("(by the machine file)"));
    // An axis that homes at its low end on a build that counts from there.
    let mut forced = known(&HOMED, [1.0; 3], [0.0; 3]);
    forced.letters = "VZ".into();
    forced.settings.push((23, 3.0));
    let limits = VetOptions::of(&forced, None).limits;
    assert_eq!(
        limits,
        Limits::Box {
            low: [0.0, 0.0, -80.0],
            high: [300.0, 200.0, 0.0],
            soft: true
        }
    );
}

#[test]
fn a_resume_starts_in_the_middle_with_the_state_it_is_given() {
    let mut start = State::new(Dialect::Grbl);
    start.position.z = 5.0;
    let options = VetOptions {
        start,
        entry: vec![
            "G1 F300".into(),
            "M3 S1000".into(),
            "G0 X1 Y1".into(),
            "G1 Z-1".into(),
        ],
        first_line: 4,
        ..VetOptions::default()
    };
    let job = vetted("G64 nonsense\nG1 F100\nX1 Y1\nX2\nX3\n", options).unwrap();
    assert_eq!(job.entry.len(), 4);
    assert_eq!(job.total, 2);
    let sent = lines(&job);
    assert_eq!((sent[0].source, sent[0].text.as_str()), (4, "X2"));
    assert_eq!(job.end_state.position.z, -1.0);
}

#[test]
fn weights_follow_from_what_a_line_does() {
    let job = Job::vet(
        "G21 G90 G94\nG0 Z5\nG0 X1\nG1 Z-1 F300\nX2 Z-1.2\nX9 Z-2\nG2 X10 I0.5\nX11 I0.5\nM3 S1\nG91\nG1 X1\nG55\nG38.2 Z-1 F10\n",
    )
    .unwrap();
    let weights: Vec<String> = lines(&job)
        .iter()
        .map(|l| {
            let w = l.weight;
            let letters = [
                (w.dangerous, 'd'),
                (w.changes_frame, 'f'),
                (w.changes_motion, 'm'),
                (w.restates_motion, 'r'),
            ];
            letters.iter().filter(|l| l.0).map(|l| l.1).collect()
        })
        .collect();
    assert_eq!(
        weights,
        [
            "r", "dr", "dr", "dmr", "", "d", "mr", "", "dr", "fr", "mr", "fr", "dmr"
        ]
    );
}

/// A program of any length that is nowhere in memory: every line the same ten bytes.
struct Endless {
    at: u64,
    length: u64,
    most: Arc<Mutex<u64>>,
}

const LINE: &[u8; 10] = b"G1X1F9999\n";

impl Read for Endless {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let n = self.fill_buf()?.len().min(into.len());
        into[..n].copy_from_slice(&self.fill_buf()?[..n]);
        self.consume(n);
        Ok(n)
    }
}

impl BufRead for Endless {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        if self.at >= self.length {
            return Ok(&[]);
        }
        Ok(&LINE[(self.at % 10) as usize..])
    }

    fn consume(&mut self, n: usize) {
        self.at += n as u64;
        let mut most = self.most.lock().unwrap();
        *most = (*most).max(self.at);
    }
}

impl Seek for Endless {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        if let SeekFrom::Start(at) = to {
            self.at = at;
        }
        Ok(self.at)
    }
}

#[test]
fn a_long_program_is_read_as_it_is_needed_and_never_kept() {
    let most = Arc::new(Mutex::new(0));
    let shared = most.clone();
    let source = move || {
        let most = shared.clone();
        Ok(Box::new(Endless {
            at: 0,
            length: 10 * 100_000,
            most,
        }) as Box<dyn JobReader>)
    };
    let job = vet(Arc::new(source), VetOptions::default(), &mut |_, _| {}).unwrap();
    assert_eq!((job.total, job.source_lines), (100_000, 100_000));
    // Kept: 16 bytes for every 256 lines.
    assert_eq!(job.parts.len(), 100_000_usize.div_ceil(256));
    // Read again, no more is taken from the source than the part of the line wanted.
    *most.lock().unwrap() = 0;
    let mut lines = job.lines().unwrap();
    for n in 1..=1000u64 {
        lines.next_line().unwrap().unwrap();
        assert!(
            *most.lock().unwrap() <= n.div_ceil(256) * 2560,
            "at line {n}"
        );
    }
}

#[test]
fn a_program_that_changed_is_noticed_before_any_of_the_change_is_sent() {
    let text = Arc::new(Mutex::new("G0X1\n".repeat(1000)));
    let shared = text.clone();
    let source = move || {
        let bytes = shared.lock().unwrap().clone().into_bytes();
        Ok(Box::new(std::io::Cursor::new(bytes)) as Box<dyn JobReader>)
    };
    let job = vet(Arc::new(source), VetOptions::default(), &mut |_, _| {}).unwrap();
    let with = |change: &dyn Fn(&mut String)| {
        let mut changed = "G0X1\n".repeat(1000);
        change(&mut changed);
        *text.lock().unwrap() = changed;
        let mut lines = job.lines().unwrap();
        let mut sent = 0;
        loop {
            match lines.next_line() {
                Ok(Some(_)) => sent += 1,
                Ok(None) => return (sent, String::new()),
                Err(e) => return (sent, e.to_string()),
            }
        }
    };
    assert_eq!(with(&|_| {}), (1000, String::new()));
    let (sent, why) = with(&|t| t.replace_range(5 * 600..5 * 600 + 4, "G0X2"));
    assert_eq!(sent, 512);
    assert!(
        why.starts_with("the program changed after it was checked, at or behind line 513"),
        "{why}"
    );
    assert_eq!(with(&|t| t.truncate(5 * 900)).0, 768);
    assert_eq!(with(&|t| t.push_str("G0X9\n")).0, 768);
}

proptest! {
    /// Whatever the text: a vetted line never holds a byte the controller would take for itself.
    #[test]
    fn no_real_time_byte_ever_travels_in_a_line(text in "[GXYZF0-9 .!?~;()\\n\u{e9}\u{91}$/%-]{0,60}") {
        if let Ok(job) = Job::vet(&text) {
            for line in lines(&job) {
                prop_assert!(line.text.bytes().all(|b| b > b' ' && b < 0x7E && !b"!?~$%/;()".contains(&b)), "{}", line.text);
                prop_assert!(line.text.len() <= LINE_CHARS);
            }
        }
    }

    /// Whatever the options, nothing panics, and what is read again is what was vetted.
    #[test]
    fn reading_again_gives_the_same_lines(
        words in proptest::collection::vec(proptest::sample::select(vec![
            "G0X1", "G1Y2F100", "\n", "G2X1R5", "(a?", ")", ";x", "M6", "T1", "M0", "M1", "/", "$1=2", "G10L2P1X0", "%", "G91", "G20", "G92X0", "\r", "Z-1", "é",
        ]), 0..60),
        keep in proptest::sample::select(vec![BlockDelete::Skip, BlockDelete::Keep]),
    ) {
        let options = VetOptions {
            block_delete: keep,
            memory_writers: MemoryWriters::Barrier,
            optional_stops: OptionalStops::Stop,
            limits: Limits::Size { size: [50.0; 3], told_by: ToldBy::MachineFile },
            ..VetOptions::default()
        };
        if let Ok(job) = vetted(&words.concat(), options) {
            prop_assert_eq!(lines(&job).len(), job.total);
        }
    }
}
