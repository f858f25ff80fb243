//! Steps to text, one at a time.

mod circle;
mod fill;
mod heidenhain;
mod page;
mod scribe;
mod words;

use super::adapt::Adapter;
use super::definition::Post;
use super::error::{PostError, Refusal, Spot};
use super::options::Options;
use crate::cldata::Step;
use crate::units::Mm;
use scribe::Scribe;
use std::io::Write;

/// Writes a program, step by step, in constant memory. Deterministic: the same steps give the same bytes.
///
/// A step that the post's controller cannot carry out is refused by name and number; after that the writer takes no more, and what
/// it has put out so far is no program: throw it away.
///
/// Each step passes through an [`Adapter`] of the writer's own first. Where the tool is must be told: an axis that no step has
/// named is never written, and a cut is refused before every axis is known.
pub struct Writer<'a, W: Write> {
    adapter: Adapter<'a>,
    scribe: Scribe<'a, W>,
    steps: usize,
    broken: bool,
}

impl<'a, W: Write> Writer<'a, W> {
    /// A writer for one program. Refuses options that this post cannot follow.
    pub fn new(post: &'a Post, options: Options, out: W) -> Result<Self, PostError> {
        let scribe = Scribe::new(post, &options, out).map_err(|r| refused(post, Spot::Job, r))?;
        Ok(Writer {
            adapter: Adapter::new(post, options.rewrite),
            scribe,
            steps: 0,
            broken: false,
        })
    }

    /// Writes the next step. Returns the line, from 1, that the step ended on: for a move the line of the last motion, which is an
    /// earlier one when the move rounds to nothing.
    pub fn step(&mut self, step: &Step) -> Result<usize, PostError> {
        self.steps += 1;
        let outcome = match (self.broken, self.scribe.over()) {
            (true, _) => Err(Refusal::Broken),
            (_, true) => Err(Refusal::AfterEnd),
            _ => {
                let scribe = &mut self.scribe;
                self.adapter.step(step, &mut |s: &Step| scribe.step(s))
            }
        };
        self.broken |= outcome.is_err();
        outcome.map_err(|r| refused(self.scribe.post, Spot::Step(self.steps), r))?;
        Ok(match step {
            Step::Rapid { .. } | Step::MachineRapid { .. } | Step::Feed { .. } => {
                self.scribe.last_motion
            }
            _ => self.scribe.page.lines,
        })
    }

    /// The furthest that any rewritten step so far leaves the path that was meant; rounding comes on top.
    pub fn deviation(&self) -> Mm {
        self.adapter.deviation()
    }

    /// The output back. Refuses a program without its end, and one of which a step was refused.
    pub fn finish(self) -> Result<W, PostError> {
        let post = self.scribe.post;
        let outcome = match (self.broken, self.scribe.over()) {
            (true, _) => Err(Refusal::Broken),
            (_, false) => Err(Refusal::NoEnd),
            _ => self.scribe.page.finish(),
        };
        outcome.map_err(|r| refused(post, Spot::Job, r))
    }
}

fn refused(post: &Post, spot: Spot, refusal: Refusal) -> PostError {
    PostError {
        post: post.name.clone(),
        spot,
        refusal,
    }
}

#[cfg(test)]
mod tests;
#[cfg(test)]
pub(in crate::post) use tests::{any_step, posts};
