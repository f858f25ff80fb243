//! What `mill` is told.

use crate::cli::args::{PartArgs, ToolArgs, parse};
use crate::cli::features::FunctionName;
use crate::cli::pictures;
use crate::machine::DEFAULT_MACHINE;
use crate::simulate::Stock;
use crate::toolpath::{DEFAULT_WALL_ANGLE, Strategy};
use std::path::PathBuf;

/// Arguments of `mill`.
#[derive(Clone, Debug, clap::Args)]
pub struct MillArgs {
    /// The part: STL or OBJ
    pub part: PathBuf,
    /// The program to write
    #[arg(short, long, value_name = "OUT.nc")]
    pub output: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub placing: PartArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub tool: ToolArgs,
    /// How passes are spaced
    #[arg(long, value_enum, default_value_t = StrategyName::Auto)]
    pub strategy: StrategyName,
    /// Direction of plane sections, degrees from X; a raster finds its own when left out, isoplanar features take 0
    #[arg(long, allow_negative_numbers = true, value_name = "DEGREES")]
    pub angle: Option<f64>,
    /// Machine: a name from `morsemill machines`, or a file
    #[arg(long, default_value = DEFAULT_MACHINE, value_name = "NAME|FILE")]
    pub machine: String,
    /// Settings of its firmware in place of the machine's figures: `$n=value` lines, or what a controller answers to $$
    #[arg(long, value_name = "FILE")]
    pub settings: Option<PathBuf>,
    /// Dialect: a name from `morsemill posts`, or a file; the machine's own if left out
    #[arg(long, value_name = "NAME|FILE")]
    pub post: Option<String>,
    /// Cutting feed, mm/min
    #[arg(
        long,
        default_value_t = 1500.0,
        allow_negative_numbers = true,
        value_name = "MM_PER_MIN"
    )]
    pub feed: f64,
    /// Plunge feed, mm/min
    #[arg(
        long,
        default_value_t = 500.0,
        allow_negative_numbers = true,
        value_name = "MM_PER_MIN"
    )]
    pub plunge: f64,
    /// Spindle speed; the machine's fastest, or 18000 if that is less, when left out. 0 leaves the spindle to you
    #[arg(long, allow_negative_numbers = true, value_name = "RPM")]
    pub speed: Option<f64>,
    /// What stands before the first cut: allowance:MM over the finished surface, or block
    #[arg(long, default_value = "allowance:0.5", value_parser = parse::<StockArg>)]
    pub stock: StockArg,
    /// Step of the tool-centre grid, mm; a fifth of the stepover if left out
    #[arg(long, allow_negative_numbers = true, value_name = "MM")]
    pub grid: Option<f64>,
    /// Morse function whose critical points features grow from
    #[arg(long, value_enum, default_value_t = FunctionName::Height)]
    pub function: FunctionName,
    /// Critical points whose values differ less than this are noise, mm (mean-curvature: 1/mm)
    #[arg(long, allow_negative_numbers = true, value_name = "MM")]
    pub persistence: Option<f64>,
    /// Ground steeper than this gets passes at constant height, degrees from the horizontal
    #[arg(long, default_value_t = DEFAULT_WALL_ANGLE, allow_negative_numbers = true, value_name = "DEGREES")]
    pub wall_angle: f64,
    /// The tip goes no lower than this beside a closed solid, mm; the part's lowest point if left out. Walls that the flutes do not
    /// reach down to it are a warning, and with this flag a failure
    #[arg(long, allow_negative_numbers = true, value_name = "Z")]
    pub floor: Option<f64>,
    /// Most memory that planning may take, MiB
    #[arg(long, default_value_t = 4096, value_name = "MIB")]
    pub memory: u64,
    /// Say runs of segments as arcs (G2, G3) where the dialect has them and the arc is proven as true as they were
    #[arg(long)]
    pub arcs: bool,
    /// Write the path as APT cutter-location data, too: the very path that is posted
    #[arg(long, value_name = "FILE.cl")]
    pub cl: Option<PathBuf>,
    /// Write report.json and pictures into this folder
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Width of the pictures, pixels
    #[arg(long, default_value_t = pictures::WIDTH, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(400..=4000))]
    pub picture_width: u32,
    /// Write the report as JSON to this file
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// The strategies by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum StrategyName {
    /// The quickest of the others
    Auto,
    /// Equal cusps everywhere
    IsoScallop,
    /// Equal distance on the part
    IsoPickFeed,
    /// Plane sections
    Isoplanar,
    /// The whole part as one feature, equal cusps everywhere
    Whole,
    /// The whole part in plane sections
    Raster,
}

impl StrategyName {
    /// With the angle of plane sections filled in.
    pub fn with_angle(self, angle: Option<f64>) -> Strategy {
        match self {
            StrategyName::Auto => Strategy::Auto,
            StrategyName::Whole => Strategy::Whole,
            StrategyName::Raster => Strategy::Raster(angle),
            StrategyName::IsoScallop => Strategy::IsoScallop,
            StrategyName::IsoPickFeed => Strategy::IsoPickFeed,
            StrategyName::Isoplanar => Strategy::Isoplanar(angle.unwrap_or(0.0)),
        }
    }
}

/// `allowance:MM` or `block`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StockArg {
    /// This much over the finished surface, mm.
    Allowance(f64),
    /// A block up to the part's top.
    Block,
}

impl std::str::FromStr for StockArg {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        if text == "block" {
            return Ok(StockArg::Block);
        }
        let mm = text
            .strip_prefix("allowance:")
            .and_then(|v| v.parse::<f64>().ok());
        match mm.filter(|v| v.is_finite() && (0.0..=1000.0).contains(v)) {
            Some(v) => Ok(StockArg::Allowance(v)),
            None => Err(format!(
                "stock \"{text}\" is not understood: write allowance:0.5 (mm over the finished surface) or block"
            )),
        }
    }
}

impl StockArg {
    /// As the dry run wants it, for a part with this top.
    pub fn stock(self, top_z: f64) -> Stock {
        match self {
            StockArg::Allowance(mm) => Stock::Allowance(mm),
            StockArg::Block => Stock::Block { top_z },
        }
    }
}
