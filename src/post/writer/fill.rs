//! Words with figures, and template lines filled in.
//!
//! Crosses the border: figures in units of their last decimal in; words on the page out, and what the machine will remember of them.

use super::page::Kind;
use super::scribe::Scribe;
use crate::post::definition::Numbers;
use crate::post::error::Refusal;
use crate::post::template::{Piece, Slot, Template};
use std::io::Write;

impl<W: Write> Scribe<'_, W> {
    /// The axis words of a move, and where the axes are then; unchanged ones are left out if `modal`.
    pub fn axes(&mut self, to: [Option<i64>; 3], modal: bool) {
        let manner = self.post.numbers;
        for (axis, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
            let Some(count) = to[axis] else { continue };
            if modal && self.at[axis] == Some(count) {
                continue;
            }
            self.page.figure(letter, count, self.decimals, manner);
            self.at[axis] = Some(count);
        }
    }

    /// The F word, if it is not what it was.
    pub fn feed_word(&mut self, feed: i64) {
        if !self.post.modal.feed || self.feed != Some(feed) {
            let manner = Numbers {
                plus: false,
                ..self.post.numbers
            };
            self.page.figure("F", feed, self.feed_decimals, manner);
            self.feed = Some(feed);
        }
    }

    pub(super) fn each(&mut self, lines: &[Template], kind: Kind) -> Result<(), Refusal> {
        lines.iter().try_for_each(|t| self.template(t, kind, 0))
    }

    /// A template line; `value` fills the slot that is the line's own. Left out without a tolerance where it has one.
    pub(super) fn template(
        &mut self,
        template: &Template,
        kind: Kind,
        value: i64,
    ) -> Result<(), Refusal> {
        if template.has(Slot::Tolerance) && self.tolerance.is_none() {
            return Ok(());
        }
        self.page.begin(kind);
        for piece in &template.pieces {
            self.piece(piece, value);
        }
        // Whatever a template does to the motion mode (G80), the next motion says its own.
        self.motion = None;
        self.page.end()
    }

    pub(super) fn piece(&mut self, piece: &Piece, value: i64) {
        let post = self.post;
        let plain = Numbers::default();
        let real = Numbers {
            plus: false,
            ..post.numbers
        };
        let tool = i64::from(self.tool.unwrap_or(0));
        match piece {
            Piece::Text(text) => self.page.text(text),
            Piece::Slot(slot) => match slot {
                Slot::Comments | Slot::Axes => {}
                Slot::Units => self
                    .page
                    .text(post.unit_word(self.units).unwrap_or_default()),
                Slot::Name => {
                    let name = std::mem::take(&mut self.name);
                    self.page.text(&name);
                    self.name = name;
                }
                Slot::Number => self.page.number(i64::from(self.number), 0, plain),
                Slot::Tool => self.page.number(tool, 0, plain),
                Slot::Speed => self.page.number(value, post.decimals.speed, plain),
                Slot::Tolerance => {
                    let tolerance = self.tolerance.unwrap_or(0);
                    self.page.number(tolerance, self.decimals, real);
                }
                Slot::Seconds => self.page.number(value, post.decimals.seconds, real),
                Slot::Milliseconds | Slot::Offset => self.page.number(value, 0, plain),
            },
        }
    }

    /// Length compensation with the move that it waits for, in place of the move's own line.
    pub fn length_line(&mut self, to: [Option<i64>; 3]) -> Result<(), Refusal> {
        let post = self.post;
        self.page.begin(Kind::Words);
        for piece in post.tool.length.iter().flat_map(|t| &t.pieces) {
            match piece {
                Piece::Slot(Slot::Axes) => self.axes(to, false),
                piece => self.piece(piece, 0),
            }
        }
        self.length_waits = false;
        self.motion = None;
        self.page.end()?;
        self.last_motion = self.page.lines;
        Ok(())
    }
}
