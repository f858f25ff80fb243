//! What a file says about units, frames, axes and cutters.

use super::super::cutter::Cutter;
use super::super::error::{ClProblem, Fault};
use super::super::note::NoteKind;
use super::args::{Args, Value, upper, vector};
use super::motion::upright;
use super::{Lengths, State};

impl State {
    pub(super) fn units(&mut self, mut args: Args) -> Result<(), Fault> {
        const TAKES: &str = "MM, INCH or INCHES";
        let units = match args.next()? {
            Some((at, Value::Word(w))) => match upper(w).as_str() {
                "MM" => Lengths::Mm,
                "INCH" | "INCHES" | "IN" => Lengths::Inch,
                _ => return Err(args.minor(at, w, TAKES)),
            },
            _ => return Err(args.unexpected(TAKES)),
        };
        args.end()?;
        self.scale = Some(units.mm());
        Ok(())
    }

    pub(super) fn multax(&mut self, mut args: Args) -> Result<(), Fault> {
        // Alone it is on: ISO 4343 5.32.
        let on = match args.next()? {
            None => true,
            Some((_, Value::Word(w))) if w.eq_ignore_ascii_case(b"ON") => true,
            Some((_, Value::Word(w))) if w.eq_ignore_ascii_case(b"OFF") => false,
            Some((at, Value::Word(w))) => return Err(args.minor(at, w, "ON or OFF")),
            _ => return Err(args.unexpected("ON or OFF")),
        };
        args.end()?;
        if on {
            self.note(NoteKind::MultiAxis);
        }
        Ok(())
    }

    pub(super) fn tool_axis(&mut self, mut args: Args) -> Result<(), Fault> {
        let at = args.at();
        let (v, found) = args.numbers::<3>("3 (i, j, k)")?;
        args.end()?;
        if found != 3 {
            let (word, takes) = ("TLAXIS", "3 (i, j, k)");
            return Err((at, ClProblem::Count { word, found, takes }));
        }
        upright(at, vector(&v))
    }

    pub(super) fn mode(&mut self, mut args: Args) -> Result<(), Fault> {
        const TAKES: &str = "MILL";
        match args.next()? {
            None => {}
            Some((_, Value::Word(w))) if w.eq_ignore_ascii_case(b"MILL") => {}
            Some((at, Value::Word(w))) => return Err(args.minor(at, w, TAKES)),
            Some(_) => return Err(args.unexpected(TAKES)),
        }
        args.end()?;
        self.note(NoteKind::Harmless("MODE"));
        Ok(())
    }

    /// ORIGIN and TRANS, which move all points: only by nothing.
    pub(super) fn no_shift(&mut self, mut args: Args) -> Result<(), Fault> {
        const TAKES: &str = "3 (x, y, z)";
        let at = args.at();
        let (v, found) = args.numbers::<3>(TAKES)?;
        args.end()?;
        let word = args.word;
        if found != 3 {
            return Err((
                at,
                ClProblem::Count {
                    word,
                    found,
                    takes: TAKES,
                },
            ));
        }
        if v.iter().any(|c| *c != 0.0) {
            let why = "it shifts all points, and systems differ in which way: output them in the machining system, with 0, 0, 0";
            let word = word.to_string();
            return Err((0, ClProblem::Refused { word, why }));
        }
        self.note(NoteKind::Harmless(word));
        Ok(())
    }

    pub(super) fn tracut(&mut self, mut args: Args) -> Result<(), Fault> {
        match args.next()? {
            Some((_, Value::Word(w))) if w.eq_ignore_ascii_case(b"NOMORE") => {
                args.end()?;
                self.note(NoteKind::Harmless("TRACUT"));
                Ok(())
            }
            _ => {
                let word = "TRACUT".to_string();
                let why =
                    "it transforms all points and needs an APT processor: output them transformed";
                Err((0, ClProblem::Refused { word, why }))
            }
        }
    }

    /// NX: where the machining system lies in the part's. Points are in the machining system already.
    pub(super) fn msys(&mut self, mut args: Args) -> Result<(), Fault> {
        const TAKES: &str = "9 (origin, X axis, Y axis)";
        let at = args.at();
        let (v, found) = args.numbers::<9>(TAKES)?;
        args.end()?;
        if found != 9 {
            let (word, takes) = ("MSYS", TAKES);
            return Err((at, ClProblem::Count { word, found, takes }));
        }
        let differs = |f: [f64; 9]| f.iter().zip(&v).any(|(a, b)| (a - b).abs() > 1e-6);
        if self.frame.is_some_and(differs) {
            return Err((0, ClProblem::Frame));
        }
        self.frame = Some(v);
        self.note(NoteKind::Harmless("MSYS"));
        Ok(())
    }

    /// Statements of which only OFF can be posted.
    pub(super) fn only_off(&mut self, mut args: Args, why: &'static str) -> Result<(), Fault> {
        match args.next()? {
            Some((_, Value::Word(w)))
                if ["OFF", "NOMORE"]
                    .iter()
                    .any(|o| w.eq_ignore_ascii_case(o.as_bytes())) =>
            {
                args.end()?;
                self.note(NoteKind::Harmless(match args.word {
                    "CUTCOM" => "CUTCOM/OFF",
                    "CYCLE" => "CYCLE/OFF",
                    _ => "OPSKIP/OFF",
                }));
                Ok(())
            }
            other => {
                let word = match other {
                    Some((_, Value::Word(w))) => format!("{}/{}", args.word, upper(w)),
                    _ => args.word.to_string(),
                };
                Err((0, ClProblem::Refused { word, why }))
            }
        }
    }

    /// NX: `TLDATA/MILL,d,r,length,angle,angle`; other kinds tell a name and their numbers.
    pub(super) fn tldata(&mut self, mut args: Args) -> Result<(), Fault> {
        let scale = self.scale();
        let mut numbers = [0.0; 5];
        let mut count = 0;
        while let Some((at, value)) = args.next()? {
            match value {
                Value::Number(v) => {
                    if let Some(place) = numbers.get_mut(count) {
                        *place = v;
                        count += 1;
                    }
                }
                Value::Word(w) => self.tip(at, w)?,
                Value::Text => {}
            }
        }
        let [d, r, length, a, b] = numbers;
        if count < 2 {
            return Err(args.unexpected("the cutter's diameter and corner radius"));
        }
        self.about.cutter = Some(Cutter {
            diameter: d * scale,
            corner_radius: r * scale,
            corner_at: None,
            angles: (count == 5).then_some([a, b]),
            length: (count >= 3).then_some(length * scale),
        });
        Ok(())
    }

    /// APT: `CUTTER/d,r,e,f,a,b,h`; the first alone, or the first two, are enough.
    pub(super) fn cutter(&mut self, mut args: Args) -> Result<(), Fault> {
        const TAKES: &str = "1 to 7 (d, r, e, f, a, b, h)";
        if let Some((at, Value::Word(w))) = args.clone().next()? {
            self.tip(at, w)?;
            return Err(args.minor(at, w, "1 to 7 numbers (d, r, e, f, a, b, h)"));
        }
        let scale = self.scale();
        let (v, count) = args.numbers::<7>(TAKES)?;
        if let Some((at, Value::Word(w))) = args.clone().next()? {
            self.tip(at, w)?;
        }
        args.end()?;
        let [d, r, e, f, a, b, h] = v;
        if count == 0 {
            return Err(args.unexpected("the cutter's diameter"));
        }
        self.about.cutter = Some(Cutter {
            diameter: d * scale,
            corner_radius: r * scale,
            corner_at: (count >= 4).then_some([e * scale, f * scale]),
            angles: (count >= 6).then_some([a, b]),
            length: (count == 7).then_some(h * scale),
        });
        Ok(())
    }

    /// Refuses the word that says the points are the centre's.
    fn tip(&self, at: usize, w: &[u8]) -> Result<(), Fault> {
        match ["CENTER", "CENTRE"]
            .iter()
            .any(|c| w.eq_ignore_ascii_case(c.as_bytes()))
        {
            true => Err((at, ClProblem::ToolCenter)),
            false => Ok(()),
        }
    }
}
