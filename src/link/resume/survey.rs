//! How high a program goes.

use super::refusal::Refusal;
use super::walk::Program;
use crate::gcode::Plane;

/// The highest place that a program goes to, machine coordinates, mm; `None` when it does not move.
///
/// # Errors
/// The program does not read.
pub fn highest(program: &Program) -> Result<Option<f64>, Refusal> {
    let mut walk = program.walk();
    let mut highest = f64::NEG_INFINITY;
    while let Some(step) = walk.step() {
        step.map_err(Refusal::Unreadable)?;
        let (motions, shift) = walk.motions();
        for m in motions {
            let mut top = m.to.z;
            if let Some(arc) = &m.arc
                && arc.plane != Plane::Xy
            {
                // An upright arc may rise above its ends, never above its circle.
                let [a, b, _] = arc.plane.axes();
                let radius = (m.from[a] - arc.center[a]).hypot(m.from[b] - arc.center[b]);
                top = top.max(arc.center.z + radius);
            }
            highest = highest.max(top + shift.z);
        }
    }
    Ok(highest.is_finite().then_some(highest))
}
