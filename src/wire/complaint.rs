//! The interpreter's complaints as GRBL's error numbers: what the controller answers, and what the host foretells before sending. The
//! only place in `wire` that knows a word of G-code.

use crate::gcode::Complaint;

/// The N of `error:N` that GRBL answers for this complaint. Complaints only other dialects make count as "unsupported".
pub fn error_number(complaint: &Complaint) -> u16 {
    match complaint {
        Complaint::ExpectedLetter { .. } | Complaint::DecimalComma => 1,
        Complaint::BadNumber { .. } => 2,
        Complaint::Negative { .. } => 4,
        Complaint::LineTooLong { .. } => 11,
        Complaint::JogWord => 16,
        Complaint::SameGroup { .. } => 21,
        Complaint::FeedMissing => 22,
        Complaint::Fraction { .. } => 23,
        Complaint::TwoAxisCommands { .. } => 24,
        Complaint::Repeated { .. } => 25,
        Complaint::AxisWordsMissing { .. } => 26,
        Complaint::LineNumber => 27,
        Complaint::ValueMissing { .. } => 28,
        Complaint::WorkOffset { .. } => 29,
        Complaint::MachineNeedsStraight => 30,
        Complaint::AxisWordsWithoutMotion => 31,
        Complaint::ArcAxisMissing { .. } => 32,
        Complaint::ArcNowhere | Complaint::ArcRadiiDiffer { .. } | Complaint::ProbeNowhere => 33,
        Complaint::ArcRadius { .. } | Complaint::ArcRadiusZero => 34,
        Complaint::ArcCenterMissing { .. } => 35,
        Complaint::Unused { .. } => 36,
        Complaint::ToolLengthAxis => 37,
        Complaint::ToolNumber { .. } => 38,
        Complaint::UnsupportedCode { .. }
        | Complaint::UnsupportedWord { .. }
        | Complaint::OffsetKind
        | Complaint::OffsetRotation
        | Complaint::CommentOpen
        | Complaint::CommentNested
        | Complaint::WholeNumber { .. }
        | Complaint::Flow(_)
        | Complaint::Expression(_)
        | Complaint::Rule(_)
        | Complaint::Heidenhain(_)
        | Complaint::Siemens(_) => 20,
    }
}
