//! A program's moves for judging: all of them in memory, or as many as matter to a few tiles, read anew for each few.

use super::material::Move;
use crate::sweep::ReachTiles;
use std::ops::Range;

/// Moves held at once (some 250 bytes each with all that sorts them).
pub const MOST_HELD: usize = 1 << 20;

/// Tells all moves, one by one.
pub type Tells<'a> = dyn Fn(&mut dyn FnMut(&Move)) + 'a;

/// Moves in program order, as often as they are asked for.
pub enum Moves<'a> {
    /// In memory.
    Held(&'a [Move]),
    /// Read anew each time.
    Read(&'a Tells<'a>),
}

impl Moves<'_> {
    /// All of them, one by one.
    pub fn each(&self, hear: &mut dyn FnMut(&Move)) {
        match self {
            Moves::Held(moves) => moves.iter().for_each(hear),
            Moves::Read(read) => read(hear),
        }
    }

    /// All of them, in pieces of up to `most`; a piece is one slice where they are in memory.
    pub fn pieces(&self, most: usize, hear: &mut dyn FnMut(&[Move])) {
        match self {
            Moves::Held(moves) => hear(moves),
            Moves::Read(read) => {
                let mut piece = Vec::new();
                read(&mut |m| {
                    piece.push(*m);
                    if piece.len() >= most {
                        hear(&piece);
                        piece.clear();
                    }
                });
                if !piece.is_empty() {
                    hear(&piece);
                }
            }
        }
    }

    /// Runs of tiles, each with no more than `most` moves (or a single tile): those within `room` mm of it.
    pub fn groups(&self, tiles: &ReachTiles, room: f64, most: usize) -> Vec<Range<usize>> {
        if matches!(self, Moves::Held(_)) {
            return std::iter::once(0..tiles.len()).collect();
        }
        let mut counts = vec![0usize; tiles.len()];
        self.each(&mut |m| {
            tiles.near(&m.segment, room, |k| {
                if let Some(n) = counts.get_mut(k) {
                    *n += 1;
                }
            });
        });
        let mut groups = Vec::new();
        let (mut first, mut sum) = (0, 0usize);
        for (k, n) in counts.iter().enumerate() {
            if k > first && sum + n > most {
                groups.push(first..k);
                (first, sum) = (k, 0);
            }
            sum += n;
        }
        groups.push(first..tiles.len());
        groups
    }

    /// The moves that pass within `room` mm of a run of tiles, and one more before and after each run of them, so that chains stay what
    /// they are; `held` is where they are put if they must be.
    pub fn near<'m>(
        &'m self,
        tiles: &ReachTiles,
        room: f64,
        which: &Range<usize>,
        held: &'m mut Vec<Move>,
    ) -> &'m [Move] {
        if let Moves::Held(moves) = self {
            return moves;
        }
        held.clear();
        // The move before, if it was left out.
        let mut left: Option<Move> = None;
        let mut after = false;
        self.each(&mut |m| {
            let mut near = false;
            tiles.near(&m.segment, room, |k| near |= which.contains(&k));
            if near {
                held.extend(left.take());
                held.push(*m);
            } else if after {
                held.push(*m);
                left = None;
            } else {
                left = Some(*m);
            }
            after = near;
        });
        held
    }
}
