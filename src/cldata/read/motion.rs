//! Straight motions, and how they go.

use super::super::error::{ClProblem, Fault};
use super::super::note::NoteKind;
use super::super::step::Step;
use super::args::{Args, Value, point, upper, vector};
use super::{Feed, Manner, State};
use crate::geom::{Point, Vector};
use crate::units::MmPerMin;

/// Places beyond this are no machine's, mm.
const FAR: f64 = 1e6;

/// The tool axis may lean by this much (seven decimals are written).
const LEAN: f64 = 1e-6;

const PLACE: &str = "3 (x, y, z), or 6 with the tool axis 0, 0, 1";

/// Refuses an axis that is not 0, 0, 1.
pub(super) fn upright(at: usize, axis: Vector) -> Result<(), Fault> {
    let off = axis - Vector::z();
    // Also when it is no number.
    if off.iter().all(|c| c.abs() <= LEAN) {
        return Ok(());
    }
    let (i, j, k) = (axis.x, axis.y, axis.z);
    Err((at, ClProblem::FiveAxis { i, j, k }))
}

/// Refuses places that no machine reaches.
pub(super) fn within(at: usize, p: Point) -> Result<Point, Fault> {
    match p.iter().find(|c| !(-FAR..=FAR).contains(*c)) {
        None => Ok(p),
        Some(&value) => Err((at, ClProblem::TooFar { value })),
    }
}

impl State {
    /// Three numbers, or six with the tool axis; as written.
    fn place(&mut self, args: &mut Args, delta: bool) -> Result<[f64; 3], Fault> {
        let at = args.at();
        let ([x, y, z, i, j, k], count) = args.numbers::<6>(PLACE)?;
        args.end()?;
        match count {
            3 => Ok([x, y, z]),
            6 => upright(at, vector(&[i, j, k])).map(|()| [x, y, z]),
            // Along the tool axis.
            1 if delta => Ok([0.0, 0.0, x]),
            0 => Err(args.unexpected("a number")),
            found => {
                let (word, takes) = (args.word, PLACE);
                Err((at, ClProblem::Count { word, found, takes }))
            }
        }
    }

    pub(super) fn goto(&mut self, mut args: Args) -> Result<(), Fault> {
        let at = args.at();
        let v = self.place(&mut args, false)?;
        let to = point(&v, self.scale());
        let to = within(at, to)?;
        match self.arc {
            None => self.go(to),
            Some(_) => self.go_arc(to),
        }
        .map_err(|problem| (at, problem))
    }

    pub(super) fn godlta(&mut self, mut args: Args) -> Result<(), Fault> {
        let at = args.at();
        self.close_arc().map_err(|p| (0, p))?;
        let v = self.place(&mut args, true)?;
        let by = vector(&v) * self.scale();
        let Some(from) = self.at else {
            return Err((0, ClProblem::NoPlace { word: "GODLTA" }));
        };
        let to = within(at, from + by)?;
        self.go(to).map_err(|problem| (at, problem))
    }

    pub(super) fn start_place(&mut self, mut args: Args) -> Result<(), Fault> {
        let at = args.at();
        self.close_arc().map_err(|p| (0, p))?;
        let v = self.place(&mut args, false)?;
        let here = point(&v, self.scale());
        let here = within(at, here)?;
        let elsewhere = self.at.is_some_and(|a| (a - here).norm() > 1e-4);
        if self.moved && elsewhere && self.changed.is_none() {
            let word = "FROM".to_string();
            let why = "it names another place than the one the tool was moved to: write RAPID and GOTO instead";
            return Err((0, ClProblem::Refused { word, why }));
        }
        self.at = Some(here);
        Ok(())
    }

    pub(super) fn go_home(&mut self, args: Args) -> Result<(), Fault> {
        if args.is_empty() {
            let word = "GOHOME".to_string();
            let why = "home is the machine's and is not known here: write RAPID and GOTO with its coordinates";
            return Err((0, ClProblem::Refused { word, why }));
        }
        self.note(NoteKind::GoHome);
        self.close_arc().map_err(|p| (0, p))?;
        self.goto(args)
    }

    /// Straight to a place, in the manner that holds.
    pub(super) fn go(&mut self, to: Point) -> Result<(), ClProblem> {
        self.tool_is_in()?;
        if self.manner == Manner::Rapid {
            self.manner = Manner::Feed;
            self.push(Step::Rapid {
                to: [Some(to.x), Some(to.y), Some(to.z)],
            });
        } else {
            if self.at.is_none() {
                return Err(ClProblem::NoPlace { word: "GOTO" });
            }
            let feed = self.feed_now()?;
            if self.changed.is_some() {
                self.note(NoteKind::FeedAfterTool);
            }
            self.push(Step::Feed {
                to,
                bow: None,
                feed,
            });
        }
        self.arrive(to);
        Ok(())
    }

    /// Refuses to move behind a TOOLNO that no LOADTL followed.
    fn tool_is_in(&self) -> Result<(), ClProblem> {
        match self.named_tool {
            Some((number, line)) => Err(ClProblem::ToolNotLoaded { number, line }),
            None => Ok(()),
        }
    }

    /// The tool is there now.
    pub(super) fn arrive(&mut self, to: Point) {
        self.at = Some(to);
        self.moved = true;
        self.changed = None;
    }

    /// The feed of a cut that begins here; one that a RAPID with feed gave is used up by it.
    pub(super) fn feed_now(&mut self) -> Result<MmPerMin, ClProblem> {
        self.tool_is_in()?;
        if let Some(line) = self.stopped {
            return Err(ClProblem::SpindleStopped { line });
        }
        // A cut needs a start that steps know of, and FROM is none of them.
        if let (Some(a), false) = (self.at, self.moved) {
            self.note(NoteKind::FromFirst);
            self.push(Step::Rapid {
                to: [Some(a.x), Some(a.y), Some(a.z)],
            });
            self.moved = true;
        }
        if let Manner::Once(f) = std::mem::replace(&mut self.manner, Manner::Feed) {
            return Ok(MmPerMin(f));
        }
        match (self.feed, self.speed) {
            (None, _) => Err(ClProblem::FeedMissing),
            (Some(Feed::PerMinute(f)), _) => Ok(MmPerMin(f)),
            (Some(Feed::PerTurn(f, _)), Some(s)) if self.direction != 0 => Ok(MmPerMin(f * s)),
            (Some(Feed::PerTurn(_, line)), _) => Err(ClProblem::PerRevolution { line }),
        }
    }

    pub(super) fn rapid(&mut self, mut args: Args) -> Result<(), Fault> {
        self.close_arc().map_err(|p| (0, p))?;
        if args.is_empty() {
            self.manner = Manner::Rapid;
            return Ok(());
        }
        const TAKES: &str = "FEED and a feed, or nothing";
        let (at, feed) = match args.next()? {
            Some((_, Value::Word(w))) if w.eq_ignore_ascii_case(b"FEED") => {
                (args.at(), self.feed_values(args)?)
            }
            Some((at, Value::Word(w))) => return Err(args.minor(at, w, TAKES)),
            Some((at, _)) => {
                let (word, takes) = ("RAPID", TAKES);
                let found = 1;
                return Err((at, ClProblem::Count { word, found, takes }));
            }
            None => return Ok(()),
        };
        match feed {
            Feed::PerMinute(f) => self.manner = Manner::Once(f),
            Feed::PerTurn(f, _) => match (self.speed, self.direction) {
                (Some(s), d) if d != 0 => self.manner = Manner::Once(f * s),
                _ => return Err((at, ClProblem::PerRevolution { line: self.line })),
            },
        }
        self.note(NoteKind::RapidAtFeed);
        Ok(())
    }

    pub(super) fn fedrat(&mut self, args: Args) -> Result<(), Fault> {
        let feed = self.feed_values(args)?;
        if matches!(feed, Feed::PerTurn(..)) {
            self.note(NoteKind::PerRevolution);
        }
        self.feed = Some(feed);
        if self.manner != Manner::Feed {
            self.note(NoteKind::RapidTakenBack);
            self.manner = Manner::Feed;
        }
        Ok(())
    }

    /// A number and a unit in any order.
    fn feed_values(&mut self, mut args: Args) -> Result<Feed, Fault> {
        const TAKES: &str = "a number with MMPM, IPM, PERMIN, MMPR, IPR or PERREV, or without";
        let mut number = None;
        // mm per unit of length, where the unit says it, and whether it is per revolution.
        let mut unit: Option<(Option<f64>, bool)> = None;
        while let Some((at, value)) = args.next()? {
            match value {
                Value::Number(v) if number.is_none() => number = Some((at, v)),
                Value::Word(w) if unit.is_none() => {
                    unit = Some(match upper(w).as_str() {
                        "MMPM" => (Some(1.0), false),
                        "IPM" => (Some(25.4), false),
                        "PERMIN" => (None, false),
                        "MMPR" => (Some(1.0), true),
                        "IPR" => (Some(25.4), true),
                        "PERREV" => (None, true),
                        _ => return Err(args.minor(at, w, TAKES)),
                    });
                }
                Value::Word(w) => return Err(args.minor(at, w, TAKES)),
                _ => {
                    let word = args.word;
                    let (found, takes) = (2, "one");
                    return Err((at, ClProblem::Count { word, found, takes }));
                }
            }
        }
        let Some((at, v)) = number else {
            return Err(args.unexpected("a feed"));
        };
        let (scale, per_turn) = unit.unwrap_or((None, false));
        let mm = v * match scale {
            Some(s) => s,
            None => self.scale(),
        };
        if mm <= 0.0 || !(0.0..=FAR).contains(&mm) {
            return Err(args.value(at, v, "must be above zero and below 1000 m/min"));
        }
        Ok(match per_turn {
            true => Feed::PerTurn(mm, self.line),
            false => Feed::PerMinute(mm),
        })
    }

    /// `CLEARP/XYPLAN,z`: where RETRCT goes to.
    pub(super) fn clearance(&mut self, mut args: Args) -> Result<(), Fault> {
        const TAKES: &str = "XYPLAN and a height";
        let at = args.at();
        match args.next()? {
            Some((_, Value::Word(w))) if w.eq_ignore_ascii_case(b"XYPLAN") => {
                let at = args.at();
                let z = args.number("1 (the height)")? * self.scale();
                if !(-FAR..=FAR).contains(&z) {
                    return Err((at, ClProblem::TooFar { value: z }));
                }
                self.clearance = Some(z);
                Ok(())
            }
            Some((at, Value::Word(w))) => Err(args.minor(at, w, TAKES)),
            _ => {
                let why = "a clearance plane is read as XYPLAN,z only: write CLEARP/XYPLAN,z";
                let word = "CLEARP".to_string();
                Err((at, ClProblem::Refused { word, why }))
            }
        }
    }

    /// `RETRCT`: straight up to the clearance height.
    pub(super) fn retract(&mut self, args: Args) -> Result<(), Fault> {
        args.end()?;
        self.close_arc().map_err(|p| (0, p))?;
        let Some(z) = self.clearance else {
            let word = "RETRCT".to_string();
            let why = "the height to rise to is not known: write CLEARP/XYPLAN,z before it, or RAPID and GOTO";
            return Err((0, ClProblem::Refused { word, why }));
        };
        if self.at.is_some_and(|a| a.z >= z) {
            self.note(NoteKind::RetractNothing);
            return Ok(());
        }
        self.push(Step::Rapid {
            to: [None, None, Some(z)],
        });
        if let Some(a) = &mut self.at {
            a.z = z;
        }
        Ok(())
    }
}
