//! Every post, many programs: what is written reads back as what was meant, in that dialect.

use morsemill::cldata::{Bow, Coolant, Step};
use morsemill::gcode::{Interpreter, Reading};
use morsemill::geom::{Plane, Point};
use morsemill::post::{Adapter, BUILT_IN, Options, Post, Refusal, Rewrite, Spot, Units, Writer};
use morsemill::units::{Mm, MmPerMin, Rpm, Seconds};
use morsemill::verify::{Deviation, Spelling, VerifyError, Witness, dialect_of, worst_state};
use proptest::prelude::*;
use std::io::Cursor;

fn options() -> Options {
    Options {
        rewrite: Rewrite {
            lines_within: Some(Mm(0.01)),
            halves: true,
            comments: true,
        },
        path_tolerance: Some(Mm(0.01)),
        ..Options::default()
    }
}

/// A program, and the steps it was made of: those that the post refuses are left out, and counted.
fn write(post: &Post, steps: &[Step]) -> (Vec<u8>, Vec<Step>, usize) {
    let mut kept = steps.to_vec();
    loop {
        let mut writer = Writer::new(post, options(), Vec::new()).expect("options");
        let refused = kept.iter().position(|s| match writer.step(s) {
            Ok(_) => false,
            Err(e) => {
                assert!(matches!(e.spot, Spot::Step(_)), "{e}");
                true
            }
        });
        match refused {
            Some(i) => drop(kept.remove(i)),
            None => {
                let text = writer.finish().expect("a program with an end");
                let refused = steps.len() - kept.len();
                return (text, kept, refused);
            }
        }
    }
}

/// What went wrong, for the reader of a failed test.
struct Trouble(String);

impl From<Refusal> for Trouble {
    fn from(e: Refusal) -> Self {
        Trouble(e.to_string())
    }
}

impl From<VerifyError> for Trouble {
    fn from(e: VerifyError) -> Self {
        Trouble(e.to_string())
    }
}

fn read_back(post: &Post, text: &[u8], steps: &[Step]) -> Result<Deviation, Trouble> {
    let state = worst_state(dialect_of(post).expect("a reader"), post);
    let said =
        Interpreter::from_state(Cursor::new(text), state, Reading::default()).expect("memory");
    let mut witness = Witness::new(said, Spelling::of(post));
    let mut adapter = Adapter::new(post, options().rewrite);
    for step in steps {
        adapter.step(step, &mut |s: &Step| {
            witness.step(s)?;
            Ok::<(), Trouble>(())
        })?;
    }
    Ok(witness.finish()?)
}

/// How far off a written place may be, mm.
fn furthest(post: &Post) -> f64 {
    let units = if Spelling::of(post).polar { 2.0 } else { 1.0 };
    units * post.rounding().0 * 3.0_f64.sqrt() * (1.0 + 1e-6)
}

/// A coordinate: anywhere on a bench, on decimals, on ties, zero.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -200.0..200.0_f64,
        2 => (-40_i32..40).prop_map(|i| f64::from(i) / 16.0),
        2 => (-5_i32..5).prop_map(|i| f64::from(i) * 0.0005),
        1 => Just(0.0),
    ]
}

/// One thing to do, as a choice and figures: what it becomes hangs on where the tool is then.
type Choice = (u8, [f64; 3], f64, f64, bool);

fn choices() -> impl Strategy<Value = Vec<Choice>> {
    let one = (
        0..24_u8,
        [coordinate(), coordinate(), coordinate()],
        0.3..60.0_f64,
        0.02..7.5_f64,
        any::<bool>(),
    );
    proptest::collection::vec(one, 1..40)
}

fn steps(choices: &[Choice], text: &str) -> Vec<Step> {
    let mut at = Point::new(choices[0].1[0], choices[0].1[1], 25.0);
    let mut all = vec![
        Step::Comment(text.to_string()),
        Step::Tool { number: 1 },
        Step::Rapid {
            to: [None, None, Some(25.0)],
        },
        Step::Spindle {
            direction: 1,
            speed: Rpm(8000.0),
            spin_up: Seconds(2.0),
        },
        Step::Rapid {
            to: [Some(at.x), Some(at.y), None],
        },
    ];
    for &(what, [x, y, z], radius, angle, yes) in choices {
        let feed = MmPerMin((100.0 + 20.0 * radius).round());
        match what {
            0..8 => {
                at = match what {
                    // Along one axis, by a little, and anywhere.
                    0..2 => Point::new(x, at.y, at.z),
                    2..4 => Point::new(at.x, at.y + 1e-4 * z, at.z),
                    _ => Point::new(x, y, z),
                };
                all.push(Step::Feed {
                    to: at,
                    bow: None,
                    feed,
                });
            }
            8..14 => {
                let plane = match what {
                    8..11 => Plane::Xy,
                    11..13 => Plane::Zx,
                    _ => Plane::Yz,
                };
                let [a, b, n] = plane.axes();
                let sweep = if yes { angle } else { -angle };
                let start: f64 = x / 30.0;
                let mut center = at;
                center[a] -= radius * start.cos();
                center[b] -= radius * start.sin();
                let mut to = at;
                to[a] = center[a] + radius * (start + sweep).cos();
                to[b] = center[b] + radius * (start + sweep).sin();
                to[n] += if z > 0.0 { 0.01 * z } else { 0.0 };
                all.push(Step::Feed {
                    to,
                    bow: Some(Bow {
                        plane,
                        center,
                        sweep,
                    }),
                    feed,
                });
                at = to;
            }
            14 => {
                let mut to = at;
                to.z = 25.0;
                all.push(Step::Rapid {
                    to: [None, None, Some(25.0)],
                });
                at = Point::new(x, y, 25.0);
                all.push(Step::Rapid {
                    to: [Some(x), Some(y), None],
                });
            }
            15 => {
                at = Point::new(x, y, z);
                all.push(Step::Rapid {
                    to: [Some(x), Some(y), Some(z)],
                });
            }
            16 => all.push(Step::Dwell(Seconds((radius * 10.0).round() / 10.0))),
            17 if radius > 50.0 => all.push(Step::Coolant(Coolant::Both)),
            17 => all.push(Step::Coolant(if yes {
                Coolant::Flood
            } else {
                Coolant::Mist
            })),
            18 => all.push(Step::Coolant(Coolant::Off)),
            19 => all.push(Step::Spindle {
                direction: if yes { 1 } else { -1 },
                speed: Rpm((1000.0 * angle).round()),
                spin_up: Seconds(1.5),
            }),
            20 => all.push(Step::Pause { optional: yes }),
            21 => all.push(Step::Comment(format!("{text} {x}"))),
            22 => {
                // A tool change, a work offset: from there everything is told anew.
                if yes {
                    all.push(Step::Tool {
                        number: 2 + (radius as u32) % 9,
                    });
                    all.push(Step::Spindle {
                        direction: 1,
                        speed: Rpm(5000.0),
                        spin_up: Seconds(2.0),
                    });
                } else {
                    all.push(Step::WorkOffset(1 + (radius as u16) % 6));
                }
                all.push(Step::Rapid {
                    to: [None, None, Some(30.0)],
                });
                all.push(Step::Rapid {
                    to: [Some(x), Some(y), None],
                });
                at = Point::new(x, y, 30.0);
            }
            _ => {
                all.push(Step::MachineRapid {
                    to: [None, None, Some(-1.0)],
                });
                all.push(Step::Rapid {
                    to: [Some(x), Some(y), None],
                });
                all.push(Step::Rapid {
                    to: [None, None, Some(30.0)],
                });
                at = Point::new(x, y, 30.0);
            }
        }
    }
    all.push(Step::End);
    all
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_post_reads_back_as_meant(choices in choices(), text in any::<String>(), inch: bool) {
        let all = steps(&choices, &text);
        let mut wrong = String::new();
        for (name, _) in BUILT_IN {
            let mut post = Post::load(name).expect("a shipped post");
            if inch && post.unit_word(Units::Inch).is_some() {
                post.units = Units::Inch;
            }
            let (program, kept, _) = write(&post, &all);
            let said = match read_back(&post, &program, &kept) {
                // Half a unit of the last decimal an axis; a whole one where a helix ends by its angle.
                Ok(d) if d.position.0 <= furthest(&post) => continue,
                Ok(d) => format!("{d:?}"),
                Err(Trouble(e)) => e,
            };
            wrong += &format!("{name}: {said}\n{}\n", String::from_utf8_lossy(&program));
        }
        prop_assert!(wrong.is_empty(), "{wrong}");
    }
}
