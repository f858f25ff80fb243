//! What people and scripts see: tables on stdout, and the serialised shapes of the JSON reports.

use crate::morse::{CriticalKind, CriticalPoint};
use crate::part::{Format, Loaded, Placement, Soundness};
use crate::post::Posted;
use crate::simulate::{DryRun, MotionFigures};
use crate::sweep::Rest;
use crate::tool::Tool;
use crate::toolpath::plan::Plan;
use crate::toolpath::wall::TooDeep;
use crate::toolpath::{MoveKind, PassKind, Stage};
use serde::Serialize;
use std::io::{self, Write};
use std::path::Path;

/// The part in a report.
#[derive(Clone, Debug, Serialize)]
pub struct PartJson {
    file: String,
    format: Format,
    triangles: usize,
    size_mm: [f64; 3],
    min_mm: [f64; 3],
    soundness: Soundness,
    frame: FrameJson,
    warnings: Vec<String>,
}

#[derive(Clone, Debug, Serialize)]
struct FrameJson {
    normal: [f64; 3],
    centroid_mm: [f64; 3],
    rectangle_mm: [f64; 2],
    angle_deg: f64,
    reachable_share: Vec<(&'static str, f64)>,
}

/// Critical points in a report.
#[derive(Clone, Debug, Serialize)]
pub struct CriticalJson {
    maxima: usize,
    minima: usize,
    saddles: usize,
    points: Vec<CriticalPointJson>,
}

#[derive(Clone, Debug, Serialize)]
struct CriticalPointJson {
    kind: &'static str,
    #[serde(rename = "where")]
    place: &'static str,
    contact_mm: [f64; 3],
    center_mm: [f64; 3],
    /// `null` for the last of its kind.
    persistence_mm: Option<f64>,
}

/// A feature in a report.
#[derive(Clone, Debug, Serialize)]
pub struct FeatureJson {
    /// From 1; 0 for a border no feature holds.
    pub id: usize,
    /// What it grew from.
    pub kind: &'static str,
    /// Surface, mm².
    pub area_mm2: f64,
    /// Passes, fills among them.
    pub passes: usize,
    /// Cutting length, links and plunges not counted.
    pub cut_mm: f64,
    /// Time on the machine, links and hops into it counted.
    pub time_s: f64,
}

/// A strategy in a report.
#[derive(Clone, Debug, Serialize)]
pub struct StrategyJson {
    /// Its name, and where it begins or runs.
    pub name: String,
    /// Length at cutting feed, links among it.
    pub cut_mm: f64,
    /// Time on the machine, without waiting for the spindle.
    pub time_s: f64,
    /// Of that, links along the surface.
    pub link_s: f64,
    /// Of that, moves through the air and straight up and down.
    pub air_s: f64,
    /// Cutting passes.
    pub passes: usize,
    /// Retracts.
    pub retracts: usize,
    /// Root of the mean square of the tool's vertical acceleration while it cuts.
    pub vertical_acceleration_rms_mm_s2: f64,
    /// Largest turn between consecutive cutting moves, but for corners of the part.
    pub largest_turn_deg: f64,
    /// Where it is: tool tip.
    pub largest_turn_at: Option<[f64; 3]>,
    /// Turns over 30 degrees that are no corners of the part.
    pub turns_over_30: usize,
    /// Turns over 30 degrees at corners of the part: a crease or an edge under the ball.
    pub part_corners: usize,
    /// The largest of those.
    pub largest_part_corner_deg: f64,
    /// The program is this one.
    pub chosen: bool,
}

/// The candidates of a plan for JSON: the chosen one among them, and both rasters.
pub fn strategies(plan: &Plan) -> Vec<StrategyJson> {
    plan.candidates
        .iter()
        .map(|c| StrategyJson {
            name: c.name.clone(),
            cut_mm: c.cut_mm,
            time_s: c.figures.time_s,
            link_s: c.figures.link_s,
            air_s: c.figures.air_s,
            passes: c.passes,
            retracts: c.retracts,
            vertical_acceleration_rms_mm_s2: c.figures.vertical_acceleration_rms,
            largest_turn_deg: c.figures.largest_turn_deg,
            largest_turn_at: c.figures.largest_turn_at.map(|p| [p.x, p.y, p.z]),
            turns_over_30: c.figures.sharp_turns,
            part_corners: c.figures.part_corners,
            largest_part_corner_deg: c.figures.largest_part_corner_deg,
            chosen: c.chosen,
        })
        .collect()
}

/// Name for JSON and words for the progress line.
pub fn stage_words(at: Stage) -> (&'static str, &'static str) {
    match at {
        Stage::Reach => ("reach", "dropping the ball on the part"),
        Stage::Morse => ("morse", "finding critical points"),
        Stage::Choose => ("choose", "choosing how to cut it"),
        Stage::Features => ("features", "growing features"),
        Stage::Passes => ("passes", "laying passes"),
        Stage::Reachable => ("reachable", "finding what this ball can reach"),
        Stage::Fill => ("fill", "filling where cusps stand over"),
        Stage::Link => ("link", "ordering and linking"),
    }
}

/// Warnings on stderr: what was tolerated in the file and decided for the user.
pub fn warn(loaded: &Loaded, placement: &Placement) {
    for w in loaded.warnings.iter().chain(&placement.notes) {
        super::output::say(&format!("note: {w}"));
    }
}

/// The part for JSON.
pub fn part_json(path: &Path, loaded: &Loaded, placement: &Placement) -> PartJson {
    let b = placement.mesh.bounds();
    let f = &placement.frame;
    PartJson {
        file: path
            .file_name()
            .map(|n| n.to_string_lossy().into_owned())
            .unwrap_or_default(),
        format: loaded.format,
        triangles: loaded.mesh.triangles.len(),
        size_mm: b.size().into(),
        min_mm: b.min.coords.into(),
        soundness: loaded.soundness.clone(),
        frame: FrameJson {
            normal: f.normal.into(),
            centroid_mm: f.centroid.coords.into(),
            rectangle_mm: f.rectangle,
            angle_deg: f.angle.to_degrees(),
            reachable_share: placement.reachable_share.to_vec(),
        },
        warnings: loaded
            .warnings
            .iter()
            .chain(&placement.notes)
            .cloned()
            .collect(),
    }
}

/// How many maxima, minima, saddles.
pub fn counts(points: &[CriticalPoint]) -> [usize; 3] {
    [
        CriticalKind::Maximum,
        CriticalKind::Minimum,
        CriticalKind::Saddle,
    ]
    .map(|k| points.iter().filter(|p| p.kind == k).count())
}

/// Critical points for JSON.
pub fn critical_json(points: &[CriticalPoint]) -> CriticalJson {
    let [maxima, minima, saddles] = counts(points);
    CriticalJson {
        maxima,
        minima,
        saddles,
        points: points
            .iter()
            .map(|p| CriticalPointJson {
                kind: match p.kind {
                    CriticalKind::Maximum => "max",
                    CriticalKind::Minimum => "min",
                    CriticalKind::Saddle => "saddle",
                },
                place: if p.boundary { "border" } else { "interior" },
                contact_mm: p.contact.coords.into(),
                center_mm: p.center.coords.into(),
                persistence_mm: p.persistence.is_finite().then_some(p.persistence),
            })
            .collect(),
    }
}

/// The features of a plan, with lengths from its moves and times from the posted program's lines.
pub fn features(plan: &Plan, posted: &Posted, line_seconds: &[f64]) -> Vec<FeatureJson> {
    let mut out: Vec<FeatureJson> = plan
        .regions
        .features
        .iter()
        .enumerate()
        .map(|(k, f)| FeatureJson {
            id: k + 1,
            kind: f.kind.name(),
            area_mm2: f.area_mm2,
            passes: 0,
            cut_mm: 0.0,
            time_s: 0.0,
        })
        .collect();
    let border = FeatureJson {
        id: 0,
        kind: "border",
        area_mm2: 0.0,
        passes: 0,
        cut_mm: 0.0,
        time_s: 0.0,
    };
    out.push(border);
    let slot = |f: Option<usize>| f.unwrap_or(plan.regions.features.len());
    for p in plan.passes.iter().filter(|p| p.kind != PassKind::Turn) {
        out[slot(p.feature)].passes += 1;
    }
    let moves = &plan.toolpath.moves;
    let mut line = 0;
    for (k, section) in plan.toolpath.sections.iter().enumerate() {
        let end = plan
            .toolpath
            .sections
            .get(k + 1)
            .map_or(moves.len(), |s| s.first_move);
        let row = &mut out[slot(plan.section_features.get(k).copied().flatten())];
        for i in section.first_move..end {
            if i > 0 && moves[i].kind == MoveKind::Cut {
                row.cut_mm += moves[i].length(&moves[i - 1].to);
            }
            let last = posted.line_of_move.get(i).copied().unwrap_or(line);
            row.time_s += line_seconds.get(line..last).map_or(0.0, |t| t.iter().sum());
            line = line.max(last);
        }
    }
    out.retain(|f| f.id > 0 || f.passes > 0);
    out
}

/// One paragraph about the part.
pub fn part(
    w: &mut dyn Write,
    path: &Path,
    loaded: &Loaded,
    placement: &Placement,
) -> io::Result<()> {
    let size = placement.mesh.bounds().size();
    let s = &loaded.soundness;
    writeln!(
        w,
        "part       {}: {} triangles, {:.3} x {:.3} x {:.3} mm, {:.0} mm2, {}",
        path.display(),
        s.triangles,
        size.x,
        size.y,
        size.z,
        s.area_mm2,
        if s.closed { "closed" } else { "open" }
    )?;
    if !s.is_clean() || (s.open_edges > 0 && s.shells > 1) {
        writeln!(
            w,
            "soundness  {} open edges, {} crowded edges, {} flipped, {} duplicate, {} degenerate triangles, {} shells{}",
            s.open_edges,
            s.crowded_edges,
            s.flipped_facets,
            s.duplicate_triangles,
            s.degenerate_triangles,
            s.shells,
            if s.inside_out { ", inside out" } else { "" }
        )?;
    }
    Ok(())
}

/// One line about the critical points.
pub fn critical(w: &mut dyn Write, points: &[CriticalPoint]) -> io::Result<()> {
    let [a, b, c] = counts(points);
    writeln!(w, "critical   {a} maxima, {b} minima, {c} saddles")
}

/// Hours, minutes, seconds.
pub fn clock(seconds: f64) -> String {
    let s = seconds.round().max(0.0) as u64;
    if s >= 3600 {
        format!("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
    } else {
        format!("{}:{:02}", s / 60, s % 60)
    }
}

/// The table of features.
pub fn feature_table(w: &mut dyn Write, rows: &[FeatureJson]) -> io::Result<()> {
    writeln!(w)?;
    writeln!(
        w,
        "{:>4}  {:<12} {:>11} {:>8} {:>10} {:>9}",
        "id", "feature", "area, mm2", "passes", "cut, mm", "time"
    )?;
    for f in rows {
        writeln!(
            w,
            "{:>4}  {:<12} {:>11.1} {:>8} {:>10.0} {:>9}",
            f.id,
            f.kind,
            f.area_mm2,
            f.passes,
            f.cut_mm,
            clock(f.time_s)
        )?;
    }
    let sum = |of: fn(&FeatureJson) -> f64| rows.iter().map(of).sum::<f64>();
    writeln!(
        w,
        "{:>4}  {:<12} {:>11.1} {:>8} {:>10.0} {:>9}",
        "",
        "all",
        sum(|f| f.area_mm2),
        rows.iter().map(|f| f.passes).sum::<usize>(),
        sum(|f| f.cut_mm),
        clock(sum(|f| f.time_s))
    )?;
    writeln!(w)
}

/// The table of what was laid and weighed, the plan that was chosen among it, with the rasters to compare with.
pub fn strategy_table(w: &mut dyn Write, plan: &Plan) -> io::Result<()> {
    let width = plan
        .candidates
        .iter()
        .map(|c| c.name.len())
        .fold("strategy".len(), usize::max);
    writeln!(
        w,
        "  {:width$} {:>9} {:>9} {:>9} {:>10} {:>8} {:>9}",
        "strategy", "time", "linking", "in air", "feed, mm", "passes", "retracts"
    )?;
    for c in &plan.candidates {
        let f = &c.figures;
        let share = |s: f64| format!("{:.1} %", 100.0 * s / f.time_s.max(f64::MIN_POSITIVE));
        writeln!(
            w,
            "{} {:width$} {:>9} {:>9} {:>9} {:>10.0} {:>8} {:>9}",
            if c.chosen { '*' } else { ' ' },
            c.name,
            clock(f.time_s),
            share(f.link_s),
            share(f.air_s),
            c.cut_mm,
            c.passes,
            c.retracts
        )?;
    }
    writeln!(w)
}

/// How well the machine is moved, in one line.
pub fn motion(m: &MotionFigures) -> String {
    let turns = match m.largest_turn_line {
        Some(line) => format!(
            "largest turn {:.1} deg (line {line}), {} over 30",
            m.largest_turn_deg, m.turns_over_30
        ),
        None => "no turns".into(),
    };
    let corners = match m.part_corners {
        0 => String::new(),
        n => format!(
            ", {n} corners of the part up to {:.1}",
            m.largest_part_corner_deg
        ),
    };
    format!(
        "vertical RMS {:.1} mm/s2 at {:.2} mm/s; {:.1} % off the surface; {turns}{corners}",
        m.vertical_acceleration_rms_mm_s2, m.vertical_speed_rms_mm_s, m.non_cutting_percent
    )
}

/// One line about what the program needs of the link.
pub fn link_line(w: &mut dyn Write, name: &str, d: &DryRun) -> io::Result<()> {
    let Some(l) = &d.link_demand else {
        return Ok(());
    };
    write!(
        w,
        "{name} {:.0} lines/s (p99 {:.0}), {:.1} kB/s at the busiest, {:.1} kB/s carried: ",
        l.lines_per_s_max,
        l.lines_per_s_p99,
        1e-3 * l.bytes_per_s_needed,
        1e-3 * l.bytes_per_s_link
    )?;
    // A burst may ask for more than the cable carries while the controller still has lines to run.
    if l.starved_s >= 0.05 {
        write!(w, "the machine waits {:.1} s for lines", l.starved_s)?;
    } else {
        write!(w, "the machine never waits for a line")?;
    }
    writeln!(w)
}

/// The dry run's figures and its verdict.
pub fn verdict(w: &mut dyn Write, d: &DryRun, scallop: f64) -> io::Result<()> {
    writeln!(
        w,
        "time       {} ({} cutting, {} in the air)",
        clock(d.time_s.total),
        clock(d.time_s.cutting),
        clock(d.time_s.air)
    )?;
    writeln!(
        w,
        "program    {} lines, {:.0} mm at feed, {:.0} mm rapid, {} retracts",
        d.program.lines, d.program.cut_mm, d.program.rapid_mm, d.program.retracts
    )?;
    writeln!(w, "motion     {}", motion(&d.motion))?;
    link_line(w, "link      ", d)?;
    if let Some(f) = &d.finish {
        let s = &f.scallop_um;
        writeln!(
            w,
            "cusps      p50 {:.1}  p95 {:.1}  p99 {:.1}  p99.9 {:.1}  max {:.1} um (asked {:.1}), {:.3} % of the area over",
            s.p50,
            s.p95,
            s.p99,
            s.p999,
            s.max,
            1e3 * scallop,
            f.over_scallop_area_percent
        )?;
        writeln!(
            w,
            "gouge      {:.2} um deepest; uncut {:.3} mm2; rest material {:.2} mm2 in plan",
            f.gouge_um_max, f.uncut_area_mm2, f.rest_area_mm2
        )?;
    }
    for p in &d.warnings {
        writeln!(w, "warning    {p}")?;
    }
    for p in &d.problems {
        writeln!(w, "problem    {p}")?;
    }
    writeln!(w, "verdict    {}", d.verdict)
}

/// One line on what the ball leaves.
pub fn rest(w: &mut dyn Write, rest: &Rest, tolerance: f64) -> io::Result<()> {
    let Some(most) = rest.spots.first() else {
        return writeln!(
            w,
            "rest material: none over {:.1} um, the ball goes everywhere",
            1e3 * tolerance
        );
    };
    let ball = most.largest_ball.map_or_else(
        || "a corner too sharp for any ball".to_string(),
        |r| format!("ball:{:.2} would reach it", (200.0 * r).floor() / 100.0),
    );
    writeln!(
        w,
        "rest material: {:.1} mm2 on the surface in {} place{}; the largest {:.1} mm2, {:.3} mm deep at X{:.2} Y{:.2} Z{:.2}: {ball}",
        rest.area,
        rest.count,
        if rest.count == 1 { "" } else { "s" },
        most.area,
        most.depth,
        most.place.x,
        most.place.y,
        most.place.z
    )
}

/// Walls that were left standing: how much, where, and what would cut them; `None` when there are none.
pub fn standing(uncut: f64, walls: &[TooDeep], tool: &Tool) -> Option<String> {
    let t = walls
        .iter()
        .reduce(|a, b| if b.needs > a.needs { b } else { a })?;
    let told = if tool.flute.is_some() {
        ""
    } else {
        " (three diameters, as --tool does not say)"
    };
    Some(format!(
        "{uncut:.1} mm2 of upright wall are not cut: the flutes are {:.1} mm long{told}, and at X{:.2} Y{:.2} it takes {:.1} mm \
         down to Z{:.2}. Write the tool's own flutes, e.g. --tool ball:{},flute:{:.0}, or end the walls higher with --floor",
        tool.flute_length(),
        t.place.x,
        t.place.y,
        t.needs,
        t.place.z - tool.radius,
        2.0 * tool.radius,
        t.needs.ceil()
    ))
}
