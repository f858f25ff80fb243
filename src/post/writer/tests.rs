//! Programs of many dialects, judged line by line.
#![allow(clippy::unwrap_used)]

use super::*;
use crate::cldata::{Bow, Coolant};
use crate::geom::{Plane, Point};
use crate::post::definition::{Arcs, Form, Units};
use crate::post::{BUILT_IN, Rewrite};
use crate::units::{MmPerMin, Rpm, Seconds};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Every shipped post, read once.
pub(in crate::post) fn posts() -> &'static [Post] {
    static POSTS: std::sync::LazyLock<Vec<Post>> = std::sync::LazyLock::new(|| {
        let load = |(name, _): &(&str, &str)| Post::load(name).unwrap();
        BUILT_IN.iter().map(load).collect()
    });
    &POSTS
}

fn written(post: &Post, options: Options, steps: &[Step]) -> Result<String, PostError> {
    let mut w = Writer::new(post, options, Vec::new())?;
    for s in steps {
        w.step(s)?;
    }
    Ok(String::from_utf8(w.finish()?).unwrap())
}

fn plain(name: &str, steps: &[Step]) -> Result<String, PostError> {
    let mut all = steps.to_vec();
    all.push(Step::End);
    written(&Post::load(name).unwrap(), Options::default(), &all)
}

fn refusal(name: &str, steps: &[Step]) -> String {
    plain(name, steps).unwrap_err().to_string()
}

fn rapid(x: Option<f64>, y: Option<f64>, z: Option<f64>) -> Step {
    Step::Rapid { to: [x, y, z] }
}

fn start() -> Step {
    rapid(Some(10.0), Some(0.0), Some(5.0))
}

fn feed(x: f64, y: f64, z: f64) -> Step {
    Step::Feed {
        to: Point::new(x, y, z),
        bow: None,
        feed: MmPerMin(100.0),
    }
}

fn bow(to: Point, plane: Plane, sweep: f64) -> Step {
    Step::Feed {
        to,
        bow: Some(Bow {
            plane,
            center: Point::new(0.0, 0.0, 5.0),
            sweep,
        }),
        feed: MmPerMin(100.0),
    }
}

#[test]
fn where_the_tool_is_must_be_told() {
    let unknown = "is not known: put a rapid that names";
    assert!(
        refusal("grbl", &[feed(1.0, 1.0, 1.0)])
            .starts_with("post grbl: step 1: a feed move, but where X is at its start")
    );
    let e = refusal(
        "grbl",
        &[rapid(Some(1.0), Some(1.0), None), feed(1.0, 1.0, 1.0)],
    );
    assert!(
        e.contains("step 2") && e.contains("where Z is at its start") && e.contains(unknown),
        "{e}"
    );
    for between in [
        Step::WorkOffset(2),
        Step::Tool { number: 2 },
        Step::MachineRapid {
            to: [None, None, Some(0.0)],
        },
    ] {
        let e = refusal("linuxcnc", &[start(), between, feed(1.0, 1.0, 1.0)]);
        assert!(e.contains(unknown), "{e}");
    }
    let text = plain("grbl", &[rapid(None, Some(3.0), None)]).unwrap();
    assert!(
        text.contains("\nG0 Y3\n") && !text.contains(['X', 'Z']),
        "{text}"
    );
    // Said again after it was lost, though it is the same number.
    let text = plain(
        "grbl",
        &[start(), Step::WorkOffset(2), start(), feed(10.0, 0.0, 4.0)],
    )
    .unwrap();
    assert!(
        text.contains("G0 X10 Y0 Z5\nG55\nG0 X10 Y0 Z5\nG1 Z4 F100\n"),
        "{text}"
    );
    assert!(refusal("grbl", &[rapid(None, None, None)]).contains("names no axis"));
}

#[test]
fn what_a_controller_cannot_do_is_refused_by_name_and_step() {
    let spin = |direction| Step::Spindle {
        direction,
        speed: Rpm(1000.0),
        spin_up: Seconds(0.0),
    };
    let machine = Step::MachineRapid {
        to: [None, None, Some(0.0)],
    };
    for (name, step, what) in [
        ("grbl", Step::Coolant(Coolant::Mist), "no words for mist"),
        (
            "marlin",
            Step::Coolant(Coolant::Flood),
            "no words for flood",
        ),
        ("marlin", machine.clone(), "no rapid in machine coordinates"),
        ("carbide", machine, "no rapid in machine coordinates"),
        (
            "marlin",
            Step::WorkOffset(1),
            "work offset 1: this controller has 0",
        ),
        (
            "grbl",
            Step::WorkOffset(7),
            "work offset 7: this controller has 6",
        ),
        ("grbl", Step::WorkOffset(0), "work offset 0"),
        ("haas", Step::WorkOffset(106), "this controller has 105"),
        ("smoothie", Step::Pause { optional: false }, "no pause"),
        (
            "marlin",
            Step::Pause { optional: true },
            "no optional pause",
        ),
        (
            "marlin",
            spin(-1),
            "cannot turn its spindle counter-clockwise",
        ),
        ("grbl", spin(5), "direction is 5"),
        ("uccnc", Step::Tool { number: 97 }, "tools 0 to 96"),
        (
            "grbl",
            Step::Tool { number: 2 },
            "no tool change: make one program for each tool",
        ),
        (
            "grbl",
            Step::Dwell(Seconds(-1.0)),
            "the dwell in s is -1: it must be above zero",
        ),
        (
            "grbl",
            Step::Dwell(Seconds(f64::NAN)),
            "the dwell in s is NaN",
        ),
    ] {
        let e = refusal(name, &[Step::Tool { number: 1 }, step]);
        assert!(
            e.starts_with(&format!("post {name}: step 2: ")) && e.contains(what),
            "{e}"
        );
    }
    let after = [Step::End, start()];
    let e = written(&Post::load("grbl").unwrap(), Options::default(), &after).unwrap_err();
    assert_eq!(
        e.to_string(),
        "post grbl: step 2: comes after the end of the program: nothing may"
    );
    let e = written(&Post::load("grbl").unwrap(), Options::default(), &[start()]).unwrap_err();
    assert!(e.to_string().contains("no End step"), "{e}");
    // A refused step spoils the program.
    let post = Post::load("grbl").unwrap();
    let mut w = Writer::new(&post, Options::default(), Vec::new()).unwrap();
    w.step(&Step::WorkOffset(9)).unwrap_err();
    assert_eq!(w.step(&start()).unwrap_err().refusal, Refusal::Broken);
    assert_eq!(w.finish().unwrap_err().refusal, Refusal::Broken);
}

#[test]
fn further_work_offsets_have_their_own_words() {
    for (name, number, word) in [
        ("fanuc", 7, "G54.1 P1"),
        ("haas", 8, "G154 P2"),
        ("linuxcnc", 9, "G59.3"),
        ("okuma", 3, "G15 H3"),
        ("siemens", 5, "G505"),
        ("heidenhain", 4, "Q339=+4"),
    ] {
        let text = plain(name, &[Step::WorkOffset(number)]).unwrap();
        assert!(text.contains(word), "{text}");
    }
}

#[test]
fn arcs_in_every_plane_and_form() {
    let quarter = |plane: Plane| {
        let [u, v, _] = plane.axes();
        let center = Point::new(0.0, 0.0, 5.0);
        let (mut from, mut to) = (center, center);
        from[u] += 10.0;
        to[v] += 10.0;
        vec![
            rapid(Some(from.x), Some(from.y), Some(from.z)),
            bow(to, plane, FRAC_PI_2),
        ]
    };
    for (plane, lines) in [
        (Plane::Xy, "G0 X10 Y0 Z5\nG3 X0 Y10 I-10 F100\n"),
        (Plane::Zx, "G0 X0 Y0 Z15\nG18\nG3 X10 Z5 K-10 F100\nG17\n"),
        (Plane::Yz, "G0 X0 Y10 Z5\nG19\nG3 Y0 Z15 J-10 F100\nG17\n"),
    ] {
        let text = plain("grbl", &quarter(plane)).unwrap();
        assert!(text.contains(lines), "{text}");
        let mut steps = quarter(plane);
        steps.push(Step::End);
        let mut post = Post::load("grbl").unwrap();
        post.arcs.form = Form::Radius("CR=");
        let text = written(&post, Options::default(), &steps).unwrap();
        assert!(text.contains(" CR=10 F100\n"), "{text}");
        post.arcs.form = Form::Absolute;
        let text = written(&post, Options::default(), &steps).unwrap();
        assert!(
            text.contains(match plane {
                Plane::Xy => " I0 J0 F",
                Plane::Zx => " I0 K5 F",
                Plane::Yz => " J0 K5 F",
            }),
            "{text}"
        );
    }
    let e = refusal("marlin", &quarter(Plane::Zx));
    assert!(
        e.contains("step 2: it is an arc of 90.0 degrees with radius 10.0000 mm in plane ZX"),
        "{e}"
    );
    assert!(
        e.ends_with("let it be written as lines within a tolerance (--arcs-to-lines 0.005)"),
        "{e}"
    );
}

#[test]
fn arcs_that_contradict_themselves_are_refused() {
    let to = Point::new(0.0, 10.0, 5.0);
    for (sweep, what) in [
        (1.0, "its turn does not lead from its start to its end"),
        (0.0, "its turn is no angle"),
        (f64::NAN, "its turn is no angle"),
        (-FRAC_PI_2, "its turn does not lead"),
    ] {
        let e = refusal("grbl", &[start(), bow(to, Plane::Xy, sweep)]);
        assert!(e.contains(what), "{sweep}: {e}");
    }
    let e = refusal(
        "grbl",
        &[
            start(),
            bow(Point::new(10.0, 0.0, 5.0), Plane::Xy, 2.0 * TAU),
        ],
    );
    assert!(
        e.ends_with("let it be split into arcs (--split-circles)"),
        "{e}"
    );
    let mut post = Post::load("grbl").unwrap();
    post.arcs = Arcs::NONE;
    let told = Options {
        rewrite: Rewrite {
            lines_within: Some(Mm(0.5)),
            ..Rewrite::default()
        },
        ..Options::default()
    };
    let mut w = Writer::new(&post, told, Vec::new()).unwrap();
    w.step(&start()).unwrap();
    w.step(&bow(to, Plane::Xy, FRAC_PI_2)).unwrap();
    assert!(w.deviation().0 > 0.0 && w.deviation().0 <= 0.5);
}

#[test]
fn a_rapid_that_goes_at_f_says_it_and_puts_it_back() {
    let text = plain(
        "marlin",
        &[start(), feed(9.0, 0.0, 1.0), start(), feed(9.0, 0.0, 1.0)],
    )
    .unwrap();
    assert!(
        text.contains("G0 X10 Y0 Z5 F3000\nG1 X9 Z1 F100\nG0 X10 Z5 F3000\nG1 X9 Z1 F100\nM5\n"),
        "{text}"
    );
}

#[test]
fn length_compensation_comes_with_the_first_z_and_again_after_machine_coordinates() {
    let top = Step::MachineRapid {
        to: [None, None, Some(-1.0)],
    };
    let steps = [
        Step::Tool { number: 3 },
        rapid(Some(1.0), Some(2.0), None),
        rapid(None, None, Some(5.0)),
        top,
        rapid(None, None, Some(5.0)),
    ];
    let text = plain("fanuc", &steps).unwrap();
    assert!(
        text.contains(
            "N1 T3 M6\nG0 X1. Y2.\nG0 G43 Z5. H3\nG53 G0 Z-1.\nG0 G43 Z5. H3\nG53 G0 Z0.\n"
        ),
        "{text}"
    );
    let text = plain("linuxcnc", &steps).unwrap();
    assert!(
        text.contains("T3 M6\nG43 H3\nG0 X1 Y2\nZ5\nG53 G0 Z-1\nG0 Z5\n"),
        "{text}"
    );
}

#[test]
fn names_numbers_units_and_tolerances() {
    let post = Post::load("heidenhain").unwrap();
    let named = |name: &str| Options {
        name: Some(name.into()),
        ..Options::default()
    };
    let text = written(&post, named("PART_7"), &[Step::End]).unwrap();
    assert!(
        text.starts_with("0 BEGIN PGM PART_7 MM\r\n") && text.ends_with(" END PGM PART_7 MM\r\n"),
        "{text}"
    );
    for bad in ["", "a b", "naïve", "x\ny", "(a)", &"n".repeat(25)] {
        let e = written(&post, named(bad), &[]).unwrap_err();
        assert!(
            e.to_string().contains("cannot be written: letters, digits"),
            "{e}"
        );
    }
    let inch = Options {
        units: Some(Units::Inch),
        ..Options::default()
    };
    let e = written(&post, inch.clone(), &[]).unwrap_err();
    assert_eq!(
        e.to_string(),
        "post heidenhain: this post has no programs in inches: choose the other units"
    );
    let post = Post::load("fanuc").unwrap();
    let text = written(&post, inch, &[start(), feed(0.0, 0.0, 0.0), Step::End]).unwrap();
    assert!(
        text.contains("\nG20\n") && text.contains("G1 X0. Z0. F3.94\n"),
        "{text}"
    );
    for (number, good) in [(1, true), (8999, true), (9000, false), (0, false)] {
        let options = Options {
            number: Some(number),
            ..Options::default()
        };
        match written(&post, options, &[Step::End]) {
            Ok(text) => assert!(
                good && text.starts_with(&format!("%\nO{number}\n")),
                "{text}"
            ),
            Err(e) => assert!(
                !good && e.to_string().ends_with("this controller has 1 to 8999"),
                "{e}"
            ),
        }
    }
    let options = Options {
        path_tolerance: Some(Mm(0.025)),
        ..Options::default()
    };
    let text = written(&Post::load("siemens").unwrap(), options, &[Step::End]).unwrap();
    assert!(text.contains("CYCLE832(0.025,_FINISH,1)"), "{text}");
}

#[test]
fn comments_are_split_or_refused() {
    let long = Step::Comment("word ".repeat(40));
    let post = Post::load("fanuc").unwrap();
    let steps = [long, Step::End];
    let text = written(&post, Options::default(), &steps).unwrap();
    assert!(
        text.lines().all(|l| l.len() <= 60) && text.matches("(WORD").count() > 3,
        "{text}"
    );
    let strict = Options {
        rewrite: Rewrite {
            comments: false,
            ..Rewrite::default()
        },
        ..Options::default()
    };
    let e = written(&post, strict, &steps).unwrap_err().to_string();
    assert_eq!(
        e,
        "post fanuc: step 1: a comment of 200 characters, and a line holds 60: shorten it, or let it be split"
    );
}

#[test]
fn a_full_disk_is_said() {
    struct Full;
    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(std::io::Error::other("no space left"))
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let post = Post::load("grbl").unwrap();
    let mut w = Writer::new(&post, Options::default(), Full).unwrap();
    let e = w.step(&start()).unwrap_err().to_string();
    assert_eq!(
        e,
        "post grbl: step 1: the program could not be put out: no space left"
    );
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        20 => -200.0..200.0_f64,
        6 => (-20..20_i32).prop_map(f64::from),
        1 => prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(1e9), Just(-1e300), Just(1e-12)],
    ]
}

fn any_place() -> impl Strategy<Value = [Option<f64>; 3]> {
    [
        proptest::option::weighted(0.8, any_number()),
        proptest::option::weighted(0.8, any_number()),
        proptest::option::weighted(0.8, any_number()),
    ]
}

fn any_bow() -> impl Strategy<Value = Bow> {
    let plane = prop_oneof![Just(Plane::Xy), Just(Plane::Zx), Just(Plane::Yz)];
    (
        plane,
        any_number(),
        any_number(),
        any_number(),
        prop_oneof![-7.0..7.0_f64, any_number()],
    )
        .prop_map(|(plane, x, y, z, sweep)| Bow {
            plane,
            center: Point::new(x, y, z),
            sweep,
        })
}

/// Any step at all, sensible or not.
pub(in crate::post) fn any_step() -> impl Strategy<Value = Step> {
    prop_oneof![
        2 => any::<String>().prop_map(Step::Comment),
        1 => (0..3_u32).prop_map(|number| Step::Tool { number }),
        2 => (-2..3_i8, prop_oneof![Just(8000.0), any_number()], prop_oneof![Just(0.0), any_number()]).prop_map(
            |(direction, speed, spin_up)| Step::Spindle { direction, speed: Rpm(speed), spin_up: Seconds(spin_up) }),
        1 => prop_oneof![Just(Coolant::Off), Just(Coolant::Flood), Just(Coolant::Mist)].prop_map(Step::Coolant),
        1 => any_number().prop_map(|s| Step::Dwell(Seconds(s))),
        1 => any::<bool>().prop_map(|optional| Step::Pause { optional }),
        1 => (0..9_u16).prop_map(Step::WorkOffset),
        6 => any_place().prop_map(|to| Step::Rapid { to }),
        1 => any_place().prop_map(|to| Step::MachineRapid { to }),
        9 => ([any_number(), any_number(), any_number()], proptest::option::weighted(0.4, any_bow()), prop_oneof![9 => 1.0..3000.0_f64, 1 => any_number()])
            .prop_map(|([x, y, z], bow, feed)| Step::Feed { to: Point::new(x, y, z), bow, feed: MmPerMin(feed) }),
    ]
}

/// What a machine may choke on in a line.
fn judge(post: &Post, line: &str) -> Result<(), TestCaseError> {
    prop_assert!(line.len() <= post.longest, "{}", line);
    prop_assert!(line.chars().all(|c| (' '..='~').contains(&c)), "{:?}", line);
    let comment = line.starts_with('(') || line.contains(';');
    prop_assert!(
        comment || !line.contains("NaN") && !line.contains("inf"),
        "{}",
        line
    );
    prop_assert!(
        !(comment && post.comments.upper_case && line.chars().any(|c| c.is_ascii_lowercase())),
        "{}",
        line
    );
    if line != "%" {
        prop_assert!(
            !line.contains(|c| post.comments.forbidden.contains(c)),
            "{}",
            line
        );
    }
    if !comment {
        for word in line
            .split(' ')
            .filter(|w| w.starts_with(['X', 'Y', 'Z', 'I', 'J', 'K']) && w.len() > 1)
        {
            let number = word.trim_start_matches(|c: char| c.is_ascii_alphabetic());
            let decimals = number.split_once('.').map(|(_, d)| d.len());
            prop_assert!(number.parse::<f64>().is_ok(), "{}", line);
            prop_assert!(
                decimals.unwrap_or(0) <= usize::from(post.decimals.mm.max(post.decimals.angle)),
                "{}",
                line
            );
            prop_assert_eq!(post.numbers.point && decimals.is_none(), false, "{}", line);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    // Steps that are refused are left out by writing the rest again, so that long programs come about too.
    #[test]
    fn any_steps_are_refused_with_a_reason_or_written_well(
        mut steps in proptest::collection::vec(any_step(), 0..25), halves: bool, lines: bool, known: bool,
    ) {
        if known {
            steps.insert(0, start());
        }
        let options = Options {
            rewrite: Rewrite { halves, lines_within: lines.then_some(Mm(0.05)), comments: true },
            ..Options::default()
        };
        for post in posts() {
            let name = &post.name;
            let mut good: Vec<Step> = Vec::new();
            let mut w = Writer::new(post, options.clone(), Vec::new()).unwrap();
            for s in &steps {
                match w.step(s) {
                    Ok(line) => {
                        prop_assert!(line <= w.scribe.page.lines);
                        good.push(s.clone());
                    }
                    Err(e) => {
                        let text = e.to_string();
                        prop_assert!(text.starts_with(&format!("post {name}: step ")) && text.len() > 30, "{}", text);
                        w = Writer::new(post, options.clone(), Vec::new()).unwrap();
                        for s in &good {
                            w.step(s).unwrap();
                        }
                    }
                }
            }
            w.step(&Step::End).unwrap();
            let text = String::from_utf8(w.finish().unwrap()).unwrap();
            for line in text.lines() {
                judge(post, line)?;
            }
        }
    }
}
