//! The file as written. Every key here is in `posts/schema.json`, with what it means; a test compares the two.
//!
//! What a file leaves out its controller cannot do: no table of arcs, no arcs.

use serde::Deserialize;
use toml::Spanned;

/// A number with its place.
pub(super) type Figure = Spanned<f64>;
/// A word with its place.
pub(super) type Word = Spanned<String>;
/// Lines with their places.
pub(super) type Lines = Spanned<Vec<Word>>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub title: Word,
    pub reader: Word,
    pub spelling: Option<Word>,
    pub units: Word,
    pub unit_words: Option<UnitWordsTable>,
    pub arcs: Option<ArcsTable>,
    pub decimals: DecimalsTable,
    pub numbers: Option<NumbersTable>,
    pub lines: LinesTable,
    pub comments: CommentsTable,
    pub modal: ModalTable,
    pub rapid: Option<RapidTable>,
    pub tool: Option<ToolTable>,
    pub work_offsets: Option<WorkOffsetsTable>,
    pub spindle: SpindleTable,
    pub coolant: Option<CoolantTable>,
    pub dwell: Option<Lines>,
    pub pause: Option<Lines>,
    pub optional_pause: Option<Lines>,
    pub pause_stops_spindle: Option<bool>,
    pub program: ProgramTable,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct UnitWordsTable {
    pub mm: Option<String>,
    pub inch: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ArcsTable {
    pub planes: Spanned<Vec<Word>>,
    pub form: Option<Word>,
    pub full_circles: bool,
    pub helices: bool,
    pub smallest_radius_mm: Option<Figure>,
    pub largest_radius_mm: Option<Figure>,
    pub shortest_chord_mm: Option<Figure>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DecimalsTable {
    pub mm: Figure,
    pub inch: Figure,
    pub feed_mm: Figure,
    pub feed_inch: Figure,
    pub speed: Figure,
    pub seconds: Figure,
    pub angle: Option<Figure>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NumbersTable {
    #[serde(default)]
    pub point: bool,
    #[serde(default)]
    pub trailing_zeros: bool,
    #[serde(default)]
    pub plus: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LinesTable {
    pub end: Word,
    pub longest: Figure,
    pub separator: Option<Word>,
    pub number_step: Figure,
    pub number_start: Option<Figure>,
    pub number_highest: Option<Figure>,
    pub number_prefix: Option<Word>,
    pub numbered: Option<Word>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CommentsTable {
    pub style: Word,
    pub charset: Word,
    pub longest: Option<Figure>,
    pub forbidden: Word,
    pub active: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ModalTable {
    pub motion: bool,
    pub axes: bool,
    pub feed: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RapidTable {
    pub feed_mm_min: Option<Figure>,
    pub machine: Option<Lines>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ToolTable {
    pub change: Lines,
    pub length: Option<Word>,
    pub most: Figure,
    pub retract_z_mm: Option<Figure>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WorkOffsetsTable {
    pub words: Spanned<Vec<Word>>,
    pub further: Option<Word>,
    pub most: Option<Figure>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SpindleTable {
    pub cw: Lines,
    pub ccw: Option<Lines>,
    pub off: Lines,
    pub waits: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CoolantTable {
    pub flood: Option<Lines>,
    pub mist: Option<Lines>,
    pub both: Option<Lines>,
    pub off: Lines,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProgramTable {
    pub first: Option<Lines>,
    pub start: Lines,
    pub end: Lines,
    pub last: Option<Lines>,
    pub ends_with: Word,
    pub lowest_number: Option<Figure>,
    pub highest_number: Option<Figure>,
    pub retract_z_mm: Option<Figure>,
    pub path_tolerance_mm: Option<Figure>,
}
