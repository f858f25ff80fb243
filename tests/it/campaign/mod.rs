//! The fault campaign: random jobs and random faults in virtual time, the real session, journal and resume against the simulated controller.
//!
//! The laws, each by its letter in a failure's text:
//! - (a) no motion after an interruption but the stop itself, and nothing queued runs later;
//! - (b) the way really driven is a beginning of the program's way, passed in order: no line twice, none left out;
//! - (c) the place of the stop lies in the journal's middle zone, which is no larger than planner, receive buffer and flush gap can hold;
//! - (d) what is resumed drives the rest, whole and nothing else, from a place that the first run had reached; of a sample, the height
//!   map of the part is that of the whole run;
//! - (e) the session ends, and names the cause; it never says done when the way driven is another;
//! - (f) the receive ring never overflows.
//!
//! Bytes that arrive damaged can make a legal, wrong line that no acknowledgement betrays; for those classes ([`faults::Class::is_clean`])
//! (b), (c) and (d) hold only as long as the way was kept and no answer was made up, and the campaign counts how often it was not (`astray`),
//! and of these, how often the session or a resume noticed (`noticed`).
#![allow(clippy::unwrap_used)]

pub mod again;
pub mod bench;
pub mod case;
pub mod faults;
pub mod follow;
pub mod jobs;
pub mod laws;
pub mod material;

#[cfg(test)]
use case::first_case;
use case::{Verdict, case};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The seed of case `index` of a campaign.
pub fn seed_of(campaign: u64, index: u64) -> u64 {
    crate::chance::Chance(campaign.wrapping_mul(0x1_0000_0001).wrapping_add(index)).next()
}

/// Runs so many cases. What became of them, and the failures with their seeds.
pub fn run(campaign: u64, jobs: u64) -> (Vec<Verdict>, Vec<(u64, String)>) {
    let results: Vec<(u64, Result<Verdict, String>)> = (0..jobs)
        .into_par_iter()
        .map(|i| {
            let seed = seed_of(campaign, i);
            (
                seed,
                std::panic::catch_unwind(|| case(seed, false))
                    .unwrap_or_else(|_| Err("panic".to_string())),
            )
        })
        .collect();
    let (mut good, mut bad) = (Vec::new(), Vec::new());
    for (seed, result) in results {
        match result {
            Ok(v) => good.push(v),
            Err(e) => bad.push((seed, e)),
        }
    }
    (good, bad)
}

/// Cases by class and ending.
pub fn table(verdicts: &[Verdict]) -> String {
    let mut rows: BTreeMap<(String, String), [usize; 5]> = BTreeMap::new();
    for v in verdicts {
        let ending = v
            .ending
            .split(" at line")
            .next()
            .unwrap_or_default()
            .to_string();
        let row = rows.entry((format!("{:?}", v.class), ending)).or_default();
        row[0] += 1;
        row[1] += usize::from(v.resumed);
        row[2] += usize::from(v.compared);
        row[3] += usize::from(v.astray);
        row[4] += usize::from(v.astray && v.noticed);
    }
    let mut out = format!(
        "{:<12} {:<28} {:>7} {:>8} {:>8} {:>7} {:>8}\n",
        "fault", "ended", "cases", "resumed", "compared", "astray", "noticed"
    );
    for ((class, ending), [n, resumed, compared, astray, noticed]) in rows {
        out.push_str(&format!(
            "{class:<12} {ending:<28} {n:>7} {resumed:>8} {compared:>8} {astray:>7} {noticed:>8}\n"
        ));
    }
    let hours = verdicts.iter().map(|v| v.seconds).sum::<f64>() / 3600.0;
    out.push_str(&format!("{hours:.1} h of machine time\n"));
    out
}

#[test]
fn the_laws_hold_in_random_disasters() {
    let jobs = if cfg!(debug_assertions) { 200 } else { 600 };
    let (good, bad) = run(1, jobs);
    let told: Vec<String> = bad
        .iter()
        .take(5)
        .map(|(seed, why)| format!("seed {seed}: {why}"))
        .collect();
    assert!(
        bad.is_empty(),
        "{} of {jobs} cases; replay with `cargo run --release --example campaign -- --only SEED`\n{}",
        bad.len(),
        told.join("\n\n")
    );
    assert!(
        good.iter().filter(|v| v.resumed).count() as u64 > jobs / 4,
        "{}",
        table(&good)
    );
}

#[test]
fn what_once_broke_a_law_does_so_no_more() {
    // Cases, and what was wrong then.
    const ONCE_BROKEN: [(u64, &str); 9] = [
        (
            13364010994322286964,
            "M2 goes back to G54, and the end was called the wrong place",
        ),
        (
            610949188362932516,
            "a stop while a door was being left let the machine go on",
        ),
        (
            17460060349499947576,
            "M8 behind a coolant key waited for nothing, and the zone began too late",
        ),
        (14131850218129347928, "the zone began behind a refused line"),
        (878992059340715739, "a refused M4 counted as a standstill"),
        (
            5703964608085267980,
            "a hold lost on the way to an Idle machine stopped the job for ever",
        ),
        (
            16862809967883981630,
            "a second resume behind a door stopped the job for ever",
        ),
        (
            4066784798285553754,
            "a hold right behind a resume was never told",
        ),
        (
            11761650116272117321,
            "a feed in inch had more digits in mm than are read",
        ),
    ];
    for (seed, why) in ONCE_BROKEN {
        if let Err(e) = first_case(seed, false) {
            panic!("seed {seed} ({why}): {e}");
        }
    }
}
