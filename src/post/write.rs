//! A planned toolpath to text: its steps through one [`Writer`].

use super::definition::Post;
use super::error::{PostError, Refusal, Spot};
use super::number;
use super::options::Options;
use super::writer::Writer;
use crate::cldata::{Coolant, Job, steps};
use crate::toolpath::{MoveKind, Toolpath};

/// A program.
#[derive(Clone, Debug, PartialEq)]
pub struct Posted {
    /// The whole text, last line ended.
    pub text: String,
    /// For each move of the toolpath the line it caused, from 1: the last one if it caused several; the line before it if it
    /// rounds to nothing.
    pub line_of_move: Vec<usize>,
}

/// Writes a program with the post's own options. Deterministic: the same input gives the same bytes. Linear in the number of moves,
/// one string. Refuses a toolpath that does not begin with a rapid, and what [`Writer`] refuses.
pub fn write(toolpath: &Toolpath, job: &Job, post: &Post) -> Result<Posted, PostError> {
    let at = |spot, refusal| PostError {
        post: post.name.clone(),
        spot,
        refusal,
    };
    check(toolpath, job, post).map_err(|(spot, refusal)| at(spot, refusal))?;
    let options = Options {
        path_tolerance: job.path_tolerance,
        ..Options::default()
    };
    let text = Vec::with_capacity(1024 + 26 * toolpath.moves.len());
    let mut writer = Writer::new(post, options, text)?;
    let mut line_of_move = Vec::with_capacity(toolpath.moves.len());
    for (index, step) in steps(toolpath, job) {
        let line = writer.step(&step).map_err(|e| match index {
            Some(i) => at(Spot::Move(i), e.refusal),
            None => at(Spot::Job, e.refusal),
        })?;
        if index.is_some() {
            line_of_move.push(line);
        }
    }
    let text = String::from_utf8(writer.finish()?)
        .map_err(|e| at(Spot::Job, Refusal::Output(e.to_string())))?;
    Ok(Posted { text, line_of_move })
}

/// What only the toolpath and the job as a whole can show.
fn check(toolpath: &Toolpath, job: &Job, post: &Post) -> Result<(), (Spot, Refusal)> {
    let job_wide = |refusal| Err((Spot::Job, refusal));
    let Some(first) = toolpath.moves.first() else {
        return job_wide(Refusal::Empty);
    };
    if first.kind != MoveKind::Rapid {
        return Err((Spot::Move(0), Refusal::FirstMove(first.kind)));
    }
    let units = post.units;
    if number::round(toolpath.safe_z / units.mm(), post.coordinate_decimals()).is_none() {
        return job_wide(Refusal::SafeHeight(toolpath.safe_z));
    }
    let feed = post.feed_decimals();
    for (what, value, written, decimals, zero_too) in [
        (
            "the feed in mm/min",
            job.feed.0,
            job.feed.0 / units.mm(),
            feed,
            false,
        ),
        (
            "the plunge feed in mm/min",
            job.plunge.0,
            job.plunge.0 / units.mm(),
            feed,
            false,
        ),
        (
            "the spindle speed in rpm",
            job.speed.0,
            job.speed.0,
            post.decimals.speed,
            true,
        ),
        (
            "the spin-up time in s",
            job.spin_up.0,
            job.spin_up.0,
            post.decimals.seconds,
            true,
        ),
    ] {
        let count = number::round(written, decimals);
        if count.is_none_or(|c| c <= 0 && !(zero_too && value == 0.0)) {
            let must = if zero_too {
                "zero or above"
            } else {
                "above zero"
            };
            return job_wide(Refusal::Figure { what, value, must });
        }
    }
    if job.coolant != Coolant::Off {
        let lines = match job.coolant {
            Coolant::Mist => &post.coolant.mist,
            Coolant::Both => &post.coolant.both,
            _ => &post.coolant.flood,
        };
        if lines.is_empty() {
            return job_wide(Refusal::NoCoolant(job.coolant));
        }
    }
    for (i, m) in toolpath.moves.iter().enumerate() {
        let cuts = matches!(m.kind, MoveKind::Cut | MoveKind::Link);
        if m.turn.is_some() && !cuts {
            return Err((Spot::Move(i), Refusal::ArcKind(m.kind)));
        }
        // A feed that is no number would be taken for none of its own.
        if let Some(own) = m.feed.filter(|f| !f.0.is_finite()) {
            let refusal = Refusal::Figure {
                what: "its feed in mm/min",
                value: own.0,
                must: "above zero",
            };
            return Err((Spot::Move(i), refusal));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
