//! What goes wrong in a job, and what the operator wants meanwhile.

use crate::chance::Chance;
use morsemill::controller::{Deed, FaultPlan, Noise, When};
use morsemill::link::{Command, Ending, RapidStep, Step};

/// What befalls a job. The words before the colon are for the table of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Nothing; the operator holds, resumes and turns overrides.
    Sound,
    /// The operator stops it.
    Stop,
    /// The operator resets at once.
    ResetNow,
    /// The controller's reset button, in time.
    Reset,
    /// The same as a line arrives.
    ResetAtLine,
    PowerCycle,
    Unplug,
    /// Out and in again, soon.
    Replug,
    LoseOk,
    Limit,
    SoftLimit,
    DoorPin,
    /// A line arrives as one that is refused.
    Refused,
    /// The sender is killed; the journal ends where it was flushed, or inside what was about to be.
    Killed,
    /// Bytes dropped, doubled and turned, both ways.
    Noise,
    /// The host hears from its port that it is gone, in the middle of a write.
    Gone,
    /// The host loses its power: what its disk had of the journal is up to two seconds old, torn, or ends in zeros.
    PowerCut,
    /// The controller loses bytes that arrive while it writes its memory.
    Eeprom,
}

impl Class {
    /// So many of them there were when the first seeds were found that broke a law.
    pub const FIRST: usize = 15;
    pub const ALL: [Class; 18] = [
        Class::Sound,
        Class::Stop,
        Class::ResetNow,
        Class::Reset,
        Class::ResetAtLine,
        Class::PowerCycle,
        Class::Unplug,
        Class::Replug,
        Class::LoseOk,
        Class::Limit,
        Class::SoftLimit,
        Class::DoorPin,
        Class::Refused,
        Class::Killed,
        Class::Noise,
        Class::Gone,
        Class::PowerCut,
        Class::Eeprom,
    ];

    /// Bytes of lines arrive as they were sent, each once, as long as they arrive.
    pub fn is_clean(self) -> bool {
        !matches!(self, Class::Replug | Class::Noise)
    }

    /// The controller forgets where it stands.
    pub fn forgets(self) -> bool {
        matches!(self, Class::Reset | Class::ResetAtLine | Class::PowerCycle)
    }

    /// The journal ends without a word.
    pub fn kills_the_sender(self) -> bool {
        matches!(self, Class::Killed | Class::PowerCut)
    }

    /// Whether this ending names the true cause, if the fault struck at all.
    pub fn may_end(self, ending: &Ending) -> bool {
        match self {
            _ if *ending == Ending::Done => true,
            Class::Sound | Class::DoorPin | Class::Eeprom => false,
            Class::Stop => *ending == Ending::Stopped,
            Class::ResetNow => matches!(ending, Ending::Stopped | Ending::Aborted),
            Class::Reset | Class::ResetAtLine | Class::PowerCycle => {
                *ending == Ending::ControllerReset
            }
            Class::Unplug => matches!(ending, Ending::Silent { .. }),
            Class::LoseOk => matches!(ending, Ending::LostReply { .. }),
            Class::Limit => matches!(ending, Ending::Alarm { code: 1, .. }),
            Class::SoftLimit => matches!(ending, Ending::Alarm { code: 2, .. }),
            Class::Refused => matches!(ending, Ending::Refused { .. }),
            Class::Killed | Class::PowerCut => true,
            Class::Gone => matches!(ending, Ending::Broken(_)),
            // A line that arrives in part is anything.
            Class::Replug | Class::Noise => true,
        }
    }
}

/// A schedule. Times s since the session began.
#[derive(Clone, Debug)]
pub struct Schedule {
    pub class: Class,
    pub plan: FaultPlan,
    /// Text for [`morsemill::controller::Script`].
    pub script: String,
    pub wishes: Vec<(f64, Command)>,
    pub kill: Option<f64>,
    /// The port is gone from then on.
    pub gone: Option<f64>,
    /// The n-th piece of bytes with an axis word is damaged so that it is refused.
    pub refuse: Option<usize>,
    /// Most bytes the port takes at once.
    pub takes: usize,
}

impl Schedule {
    /// Nothing goes wrong and nobody wants anything.
    pub fn quiet() -> Schedule {
        Schedule {
            class: Class::Sound,
            plan: FaultPlan::default(),
            script: String::new(),
            wishes: Vec::new(),
            kill: None,
            gone: None,
            refuse: None,
            takes: usize::MAX,
        }
    }
}

/// A random one for a job that takes about `duration` seconds and has so many lines.
pub fn schedule(dice: &mut Chance, class: Class, duration: f64, lines: usize) -> Schedule {
    let at = 0.2 + dice.part() * duration;
    let line = 1 + dice.roll(lines);
    let mut plan = FaultPlan::default();
    let mut script = String::new();
    let mut wishes = Vec::new();
    if dice.roll(3) == 0 {
        plan.delay = dice.part() * 0.04;
    }
    for _ in 0..[0, 0, 2, 6][dice.roll(4)] {
        wishes.push((dice.part() * duration, wish(dice)));
    }
    match class {
        Class::Stop => wishes.push((at, Command::Stop)),
        Class::ResetNow => wishes.push((at, Command::ResetNow)),
        Class::Reset => plan.deeds.push((When::At(at), Deed::Reset)),
        Class::ResetAtLine => plan.deeds.push((When::Line(line), Deed::Reset)),
        Class::PowerCycle => plan.deeds.push((When::At(at), Deed::PowerCycle)),
        Class::Unplug => plan.deeds.push((When::At(at), Deed::Unplug)),
        Class::Replug => {
            plan.deeds.push((When::At(at), Deed::Unplug));
            plan.deeds
                .push((When::At(at + 0.01 + 3.0 * dice.part()), Deed::Plug));
        }
        Class::LoseOk => plan.lose_ok = 0.002 + 0.1 * dice.part() * dice.part(),
        Class::Limit => {
            script = format!(
                "{at:.4}s limit {} on\n{:.4}s limit x off\n",
                ["x", "y", "z"][dice.roll(3)],
                at + 0.05
            )
        }
        Class::DoorPin => {
            script = format!(
                "{at:.4}s door on\n{:.4}s door off\n",
                at + 0.2 + 2.0 * dice.part()
            )
        }
        Class::Noise => {
            let rate = 0.0005 + 0.004 * dice.part() * dice.part();
            let noise = Noise {
                drop: rate * dice.part(),
                duplicate: rate * dice.part(),
                flip: rate * dice.part(),
            };
            (plan.to_controller, plan.to_host) = (noise, noise);
        }
        Class::Eeprom => plan.eeprom_loss = true,
        Class::Sound
        | Class::SoftLimit
        | Class::Refused
        | Class::Killed
        | Class::PowerCut
        | Class::Gone => {}
    }
    wishes.sort_by(|a, b| a.0.total_cmp(&b.0));
    Schedule {
        class,
        plan,
        script,
        wishes,
        kill: class.kills_the_sender().then_some(at),
        gone: (class == Class::Gone).then_some(at),
        refuse: (class == Class::Refused).then_some(line),
        takes: [usize::MAX, 64, 17, 3][dice.roll(4)],
    }
}

fn wish(dice: &mut Chance) -> Command {
    match dice.roll(16) {
        0..=3 => Command::Hold,
        4 => Command::Resume,
        5 => Command::Door,
        6 => Command::Feed(Step::Plus10),
        7 | 8 => Command::Feed(Step::Minus10),
        9 => Command::Feed(Step::Minus1),
        10 => Command::Feed(Step::Normal),
        11 => Command::Rapid(RapidStep::Quarter),
        12 => Command::Rapid(RapidStep::Full),
        13 => Command::Spindle(Step::Plus10),
        14 => Command::SpindleStop,
        _ => Command::Flood,
    }
}
