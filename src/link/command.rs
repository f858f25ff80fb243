//! What the operator wants of a running session.

use crate::wire::Realtime;

/// A wish. Every one is safe to give at any time; one that makes no sense now is told by a note and otherwise ignored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Feed hold.
    Hold,
    /// Resume from a hold, a door (once closed), a prompt (M0, tool change). Sent again until the machine runs.
    Resume,
    /// Stop the job: hold, wait for standstill, reset. The position is kept.
    Stop,
    /// Reset at once, even in motion. The position is lost then.
    ResetNow,
    /// Safety door: hold, and spindle and coolant off. Resume brings them back (GRBL waits 4 s for the spindle, 1 s for coolant).
    Door,
    /// Feed override.
    Feed(Step),
    /// Rapid override.
    Rapid(RapidStep),
    /// Spindle override.
    Spindle(Step),
    /// Stop the spindle in a hold, or start it again there. A resume does the latter too, and waits for its speed.
    SpindleStop,
    /// Flood coolant on or off.
    Flood,
    /// Mist coolant on or off.
    Mist,
}

/// One step of the feed or spindle override, 10 to 200 %.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Back to 100 %.
    Normal,
    /// +10 %.
    Plus10,
    /// -10 %.
    Minus10,
    /// +1 %.
    Plus1,
    /// -1 %.
    Minus1,
}

/// The three speeds of rapids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RapidStep {
    /// 100 %.
    Full,
    /// 50 %.
    Half,
    /// 25 %.
    Quarter,
}

impl Command {
    /// The override byte, for the commands that are one.
    pub fn adjustment(self) -> Option<Realtime> {
        Some(match self {
            Command::Feed(Step::Normal) => Realtime::FeedNormal,
            Command::Feed(Step::Plus10) => Realtime::FeedPlus10,
            Command::Feed(Step::Minus10) => Realtime::FeedMinus10,
            Command::Feed(Step::Plus1) => Realtime::FeedPlus1,
            Command::Feed(Step::Minus1) => Realtime::FeedMinus1,
            Command::Rapid(RapidStep::Full) => Realtime::RapidFull,
            Command::Rapid(RapidStep::Half) => Realtime::RapidHalf,
            Command::Rapid(RapidStep::Quarter) => Realtime::RapidQuarter,
            Command::Spindle(Step::Normal) => Realtime::SpindleNormal,
            Command::Spindle(Step::Plus10) => Realtime::SpindlePlus10,
            Command::Spindle(Step::Minus10) => Realtime::SpindleMinus10,
            Command::Spindle(Step::Plus1) => Realtime::SpindlePlus1,
            Command::Spindle(Step::Minus1) => Realtime::SpindleMinus1,
            Command::Flood => Realtime::Flood,
            Command::Mist => Realtime::Mist,
            _ => return None,
        })
    }
}
