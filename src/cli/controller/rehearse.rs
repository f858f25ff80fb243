//! The part on the table of the simulated machine: what is driven over it is judged.

use super::ControllerArgs;
use crate::cli::Failure;
use crate::cli::output::say;
use crate::controller::Drive;
use crate::geom::Vector;
use crate::part::Mesh;
use crate::reach::DropCutter;
use crate::simulate::{
    DrivenMove, DryRunOptions, PartContext, Rehearsal, judge_driven, judging_step,
};
use crate::sweep::ReachTiles;
use std::io::{self, Write};
use std::path::Path;

/// The part, the ball, the stock.
pub(super) struct Bench {
    mesh: Mesh,
    drop: DropCutter,
    step: f64,
    options: DryRunOptions,
    judged: usize,
}

impl Bench {
    /// Lays the part on the table as `check` does, under a machine with so many motor steps a millimetre. A motor stands on its nearest
    /// step: by so much its way may differ from the program's without anything being wrong.
    pub fn lay(
        part: &Path,
        args: &ControllerArgs,
        steps_per_mm: &[f64; 3],
    ) -> Result<Bench, String> {
        let words = |e: Failure| match e {
            Failure::Rejected(text) | Failure::Failed(text) => text,
        };
        args.tool.check().map_err(words)?;
        let (_, placement) = args.placement.load(part).map_err(words)?;
        args.tool.check_against(&placement).map_err(words)?;
        let mesh = placement.mesh;
        let (bounds, radius) = (mesh.bounds(), args.tool.tool.radius);
        say(&format!(
            "part {}: {:.1} x {:.1} x {:.1} mm, {}; each program finds fresh stock",
            part.display(),
            bounds.size().x,
            bounds.size().y,
            bounds.size().z,
            args.tool.tool
        ));
        let rounding =
            Vector::from(steps_per_mm.map(|s| if s > 0.0 { 0.5 / s } else { 0.0 })).norm();
        let mut options = DryRunOptions::new(args.tool.scallop, args.stock.stock(bounds.max.z));
        options.gouge_limit_mm += rounding;
        options.collision_limit_mm += rounding;
        Ok(Bench {
            drop: DropCutter::new(&mesh, radius),
            step: judging_step(&bounds, radius, args.tool.scallop),
            options,
            mesh,
            judged: 0,
        })
    }

    /// Judges a way and prints the verdict. True when something was hit.
    pub fn judge(&mut self, drive: &Drive, ended: bool, out: &mut dyn Write) -> io::Result<bool> {
        self.judged += 1;
        let tiles = ReachTiles::new(&self.drop, self.step, 1);
        let part = PartContext {
            mesh: &self.mesh,
            drop: &self.drop,
            reachable: &tiles,
        };
        let moves = drive.pieces.iter().map(|d| DrivenMove {
            from: d.from,
            to: d.to,
            rapid: d.rapid,
            turning: d.turning,
            at: d.at,
        });
        let mut result = judge_driven(moves, &part, &self.options);
        if !ended {
            // That the surface is not finished says nothing about a way that is not a whole program.
            result.problems.retain(|p| p.kind.is_crash());
            result.finish = result.finish.filter(|_| result.cut_mm > 0.0);
        }
        self.print(&result, drive.cut_short, ended, out)?;
        Ok(result.crashed())
    }

    fn print(
        &self,
        r: &Rehearsal,
        cut_short: bool,
        ended: bool,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let what = if ended {
            "program"
        } else {
            "way without an M2 or M30"
        };
        writeln!(
            out,
            "rehearsal {}: {what}, {:.1} mm at feed, {:.1} mm rapid",
            self.judged, r.cut_mm, r.rapid_mm
        )?;
        if cut_short {
            writeln!(
                out,
                "not judged: what came behind the first ten million moves"
            )?;
        }
        if let Some(f) = &r.finish {
            let s = &f.scallop_um;
            writeln!(
                out,
                "cusp      p50 {:.2}  p99 {:.2}  max {:.2} um; gouge {:.2} um, uncut {:.3} mm2 of {:.1} mm2",
                s.p50, s.p99, s.max, f.gouge_um_max, f.uncut_area_mm2, f.judged_area_mm2
            )?;
        }
        for p in &r.problems {
            writeln!(out, "problem   {p}")?;
        }
        let verdict = match (r.crashed(), r.problems.is_empty(), ended) {
            (true, _, _) => "crash",
            (false, true, _) => "pass",
            (false, false, true) => "no crash, but the surface is not as asked for",
            (false, false, false) => "no crash so far",
        };
        writeln!(out, "verdict   {verdict}")?;
        out.flush()
    }
}
