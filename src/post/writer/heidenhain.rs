//! Motions in Heidenhain's conversational language: `L X+10 Y+20 R0 FMAX`, `CC` and `C`, helices as `CP`.

use super::page::Kind;
use super::scribe::{Circle, Scribe};
use crate::post::definition::Numbers;
use crate::post::error::Refusal;
use crate::post::number;
use std::io::Write;

impl<W: Write> Scribe<'_, W> {
    /// A straight move, a rapid without a feed. FMAX acts in its block only: the last F holds again after it.
    pub(super) fn line_block(
        &mut self,
        to: [Option<i64>; 3],
        feed: Option<i64>,
    ) -> Result<(), Refusal> {
        let moves = |axis: usize| to[axis].is_some() && to[axis] != self.at[axis];
        if !(moves(0) || moves(1) || moves(2)) {
            return Ok(());
        }
        self.page.begin(Kind::Words);
        self.page.word("L");
        self.axes(to, self.post.modal.axes);
        match feed {
            None => {
                self.page.word("R0");
                self.page.word("FMAX");
            }
            Some(feed) => self.feed_word(feed),
        }
        self.page.end()?;
        self.last_motion = self.page.lines;
        Ok(())
    }

    /// A circle's centre, where it is not the last one, and the arc; with a change of height as a polar helix. Circles lie in the
    /// XY plane: the post allows no other.
    pub(super) fn arc_blocks(
        &mut self,
        circle: &Circle,
        to: [Option<i64>; 3],
        feed: i64,
    ) -> Result<(), Refusal> {
        let manner = self.post.numbers;
        let way = if circle.sweep < 0.0 { "DR-" } else { "DR+" };
        if self.pole != Some(circle.center) {
            self.page.begin(Kind::Words);
            self.page.word("CC");
            self.page
                .figure("X", circle.center[0], self.decimals, manner);
            self.page
                .figure("Y", circle.center[1], self.decimals, manner);
            self.page.end()?;
            self.pole = Some(circle.center);
        }
        let climb = self.at[2].zip(to[2]).map_or(0, |(from, to)| to - from);
        self.page.begin(Kind::Words);
        if climb == 0 {
            self.page.word("C");
            self.axes([to[0], to[1], None], false);
        } else {
            let turn = number::round(circle.sweep.to_degrees(), self.post.decimals.angle);
            let turn = turn.ok_or(Refusal::Cannot {
                what: "helix of so many turns",
                remedy: "let it be split into arcs",
            })?;
            let signed = Numbers {
                plus: true,
                ..manner
            };
            self.page.word("CP");
            self.page
                .figure("IPA", turn, self.post.decimals.angle, signed);
            self.page.figure("IZ", climb, self.decimals, manner);
            self.at = to;
        }
        self.page.word(way);
        self.feed_word(feed);
        self.page.end()?;
        self.last_motion = self.page.lines;
        Ok(())
    }
}
