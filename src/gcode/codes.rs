//! The commands of a block by kind: which modal group they belong to, which of them use the axis words.

/// Which command of the block uses X, Y and Z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AxisUser {
    /// Nothing in the block claims them.
    Nobody,
    /// G0 to G3, G38.x.
    Motion,
    /// G10, G28, G30, G52, G92.
    NonModal,
    /// G43.1, G49.
    ToolLength,
}

/// Commands that act in their own block only (group 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NonModal {
    /// G4.
    Dwell,
    /// G10.
    SetOffset,
    /// G28.
    GoHome,
    /// G30.
    GoSecondHome,
    /// G28.1.
    StoreHome,
    /// G30.1.
    StoreSecondHome,
    /// G53.
    MachineCoordinates,
    /// G92.
    Shift,
    /// G92.1.
    ClearShift,
    /// G92.2.
    SuspendShift,
    /// G92.3.
    RestoreShift,
    /// G52.
    Local,
}

/// G43, G43.1, G49.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ToolLength {
    Cancel,
    Dynamic,
    Table,
}

/// G61, G61.1, G64.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Path {
    Exact,
    Stop,
    Blend,
}

/// M0, M1, M2, M30.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stop {
    Pause,
    OptionalPause,
    End,
}

/// M7, M8, M9.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coolant {
    Mist,
    Flood,
    Off,
}

/// Modal groups, by the bit that marks them as seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    NonModal,
    Motion,
    Plane,
    Distance,
    ArcDistance,
    FeedMode,
    Units,
    CutterRadius,
    ToolLength,
    WorkOffset,
    Path,
    Stop,
    ToolChange,
    Spindle,
    Coolant,
    Cycle,
    Retract,
    Scaling,
    Mirror,
    Rotation,
    Polar,
    Macro,
    ExactStop,
    Stroke,
    SpindleMode,
    Smoothing,
    Data,
    Override,
    Chips,
    Motors,
    Wait,
}

/// How many there are.
pub(super) const GROUPS: usize = 31;

impl Group {
    /// What the group sets, for messages.
    pub fn name(self) -> &'static str {
        match self {
            Group::NonModal => "commands for one line only",
            Group::Motion => "motion",
            Group::Plane => "plane",
            Group::Distance => "absolute or incremental",
            Group::ArcDistance => "arc centres",
            Group::FeedMode => "feed mode",
            Group::Units => "units",
            Group::CutterRadius => "cutter radius",
            Group::ToolLength => "tool length",
            Group::WorkOffset => "work offset",
            Group::Path => "path control",
            Group::Stop => "program stop",
            Group::ToolChange => "tool change",
            Group::Spindle => "spindle",
            Group::Coolant => "coolant",
            Group::Cycle => "drilling cycles",
            Group::Retract => "level behind a cycle",
            Group::Scaling => "scaling",
            Group::Mirror => "mirror image",
            Group::Rotation => "rotation",
            Group::Polar => "polar coordinates",
            Group::Macro => "macro calls",
            Group::ExactStop => "exact stop",
            Group::Stroke => "stroke check",
            Group::SpindleMode => "spindle mode",
            Group::Smoothing => "smoothing",
            Group::Data => "data input",
            Group::Override => "overrides",
            Group::Chips => "chip conveyor",
            Group::Motors => "motors",
            Group::Wait => "waiting",
        }
    }
}

/// A set of letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(super) struct Letters(u32);

impl Letters {
    pub const fn of(letters: &[u8]) -> Letters {
        let mut bits = 0;
        let mut i = 0;
        while i < letters.len() {
            bits |= 1 << (letters[i] - b'A');
            i += 1;
        }
        Letters(bits)
    }
    #[inline]
    pub fn add(&mut self, letter: u8) {
        self.0 |= 1 << (letter - b'A');
    }
    #[inline]
    pub fn has(self, letter: u8) -> bool {
        self.0 & (1 << (letter - b'A')) != 0
    }
    #[inline]
    pub fn and(self, other: Letters) -> Letters {
        Letters(self.0 & other.0)
    }
    #[inline]
    pub fn or(self, other: Letters) -> Letters {
        Letters(self.0 | other.0)
    }
    #[inline]
    pub fn without(self, other: Letters) -> Letters {
        Letters(self.0 & !other.0)
    }
    #[inline]
    pub fn any(self) -> bool {
        self.0 != 0
    }
    pub fn iter(self) -> impl Iterator<Item = u8> {
        (b'A'..=b'Z').filter(move |&l| self.has(l))
    }
}
