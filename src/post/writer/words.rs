//! Motions in ISO words: `G1 X10 Y20 F500`.

use super::circle::Circle;
use super::page::Kind;
use super::scribe::Scribe;
use crate::post::definition::{Form, Numbers};
use crate::post::error::Refusal;
use std::io::Write;

impl<W: Write> Scribe<'_, W> {
    /// A rapid; axes that are `None` stay. Writes nothing when nothing would move.
    pub(super) fn rapid_words(&mut self, to: [Option<i64>; 3]) -> Result<(), Refusal> {
        if self.length_waits && to[2].is_some() {
            self.flat()?;
            return self.length_line(to);
        }
        self.straight(0, to, self.rapid_feed)
    }

    /// A straight cut.
    pub(super) fn feed_words(&mut self, to: [Option<i64>; 3], feed: i64) -> Result<(), Refusal> {
        self.straight(1, to, Some(feed))
    }

    fn straight(&mut self, g: u8, to: [Option<i64>; 3], feed: Option<i64>) -> Result<(), Refusal> {
        let moves = |axis: usize| to[axis].is_some() && to[axis] != self.at[axis];
        if !(moves(0) || moves(1) || moves(2)) {
            return Ok(());
        }
        self.page.begin(Kind::Words);
        self.motion_word(g);
        self.axes(to, self.post.modal.axes);
        if let Some(feed) = feed {
            self.feed_word(feed);
        }
        self.page.end()?;
        self.last_motion = self.page.lines;
        Ok(())
    }

    fn motion_word(&mut self, g: u8) {
        if !self.post.modal.motion || self.motion != Some(g) {
            self.page.word(match g {
                0 => "G0",
                1 => "G1",
                2 => "G2",
                _ => "G3",
            });
            self.motion = Some(g);
        }
    }

    /// A cut along an arc. The plane's two axes are always said: a controller takes an arc without them for a mistake.
    pub(super) fn arc_words(
        &mut self,
        circle: &Circle,
        to: [Option<i64>; 3],
        feed: i64,
    ) -> Result<(), Refusal> {
        self.plane_line(circle.plane)?;
        self.page.begin(Kind::Words);
        self.motion_word(if circle.sweep < 0.0 { 2 } else { 3 });
        let [u, v, w] = circle.plane.axes();
        let still = self.post.modal.axes && self.at[w] == to[w];
        if still {
            let mut flat = to;
            flat[w] = None;
            self.axes(flat, false);
        } else {
            self.axes(to, false);
        }
        self.circle_words(circle, u, v);
        self.feed_word(feed);
        self.page.end()?;
        self.last_motion = self.page.lines;
        Ok(())
    }

    fn circle_words(&mut self, circle: &Circle, u: usize, v: usize) {
        let manner = self.post.numbers;
        let letter = |axis: usize| ["I", "J", "K"].get(axis).copied().unwrap_or("I");
        let mut pairs = [
            (u, circle.center[0], circle.start[0]),
            (v, circle.center[1], circle.start[1]),
        ];
        // In the order X, Y, Z, as people read them: I before K in G18.
        pairs.sort_by_key(|(axis, ..)| *axis);
        match self.post.arcs.form {
            Form::Radius(word) => {
                let plain = Numbers {
                    plus: false,
                    ..manner
                };
                self.page.figure(word, circle.radius, self.decimals, plain);
            }
            Form::Absolute => {
                for (axis, center, _) in pairs {
                    self.page
                        .figure(letter(axis), center, self.decimals, manner);
                }
            }
            Form::FromStart => {
                for (axis, center, start) in pairs {
                    if center != start {
                        self.page
                            .figure(letter(axis), center - start, self.decimals, manner);
                    }
                }
            }
        }
    }
}
