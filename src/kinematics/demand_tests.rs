//! Demand and supply by hand, and the fold against all lines at once.

#![allow(clippy::unwrap_used)]
use super::*;
use proptest::prelude::*;

fn feed(bytes_per_s: f64) -> Feed {
    Feed {
        bytes_per_s,
        rx_bytes: 128,
        blocks: 15,
    }
}

#[test]
fn even_lines_by_hand() {
    // 1000 lines of 20 bytes, 10 ms each: 100 lines/s, 2000 bytes/s.
    let times = vec![0.01; 1000];
    let d = link_demand((0..1000).map(|_| 20), &times, &feed(11_520.0));
    assert!((d.lines_per_s_max - 100.0).abs() <= 1.0, "{d:?}");
    assert!((d.lines_per_s_p99 - 100.0).abs() <= 1.0, "{d:?}");
    assert!((d.bytes_per_s_needed - 2000.0).abs() < 1.0, "{d:?}");
    assert_eq!(d.starved_s, 0.0);
    // Half of what is needed: the machine waits as long as it moves, less what is in the buffers at the end.
    let d = link_demand((0..1000).map(|_| 20), &times, &feed(1000.0));
    assert!((d.starved_s - 10.0).abs() < 0.1, "{d:?}");
    assert!((d.starved_share - 1.0).abs() < 0.01);
}

#[test]
fn buffers_carry_a_short_burst_and_no_long_one() {
    // Slow lines, then a burst of fast ones, then slow again. 11.52 kB/s carries 576 lines of 20 bytes a second.
    let program = |burst: usize| -> Vec<f64> {
        let mut t = vec![0.1; 40];
        t.extend(vec![0.001; burst]);
        t.extend(vec![0.1; 40]);
        t
    };
    let run = |burst: usize| {
        let t = program(burst);
        link_demand(t.iter().map(|_| 20), &t, &feed(11_520.0))
    };
    assert_eq!(run(15).starved_s, 0.0);
    let d = run(400);
    assert!(
        d.starved_s > 0.2 && d.bytes_per_s_needed > 11_520.0,
        "{d:?}"
    );
}

#[test]
fn nothing_needs_nothing() {
    let d = link_demand(std::iter::empty(), &[], &feed(11_520.0));
    assert_eq!(
        (d.lines_per_s_max, d.bytes_per_s_needed, d.starved_s),
        (0.0, 0.0, 0.0)
    );
    // Comments take the way of the line behind them.
    let d = link_demand([60, 20].into_iter(), &[0.0, 2.0], &feed(11_520.0));
    assert_eq!((d.lines_per_s_max, d.bytes_per_s_needed), (1.0, 40.0));
}

/// The same figures from all lines at once, written down as the definitions say.
fn at_once(lines: &[(f64, usize)], feed: &Feed) -> [f64; 4] {
    let mut begins = vec![0.0];
    for l in lines {
        begins.push(begins[begins.len() - 1] + l.0);
    }
    let total = begins.pop().unwrap();
    let within = |start: f64| {
        let inside = |t: &&f64| **t >= start && **t < start + 1.0;
        begins.iter().filter(inside).count()
    };
    let max = begins.iter().map(|b| within(*b)).max().unwrap_or(0);
    let raster = (0u32..)
        .map(|k| f64::from(k) * WINDOW_STEP)
        .take_while(|start| start + 1.0 <= total);
    let mut counts: Vec<usize> = raster.map(within).collect();
    counts.sort_unstable();
    let p99 = counts.get(counts.len() * 99 / 100).copied().unwrap_or(max);
    let mut most: f64 = 0.0;
    for i in 0..lines.len() {
        let planned: usize = lines[i..].iter().take(feed.blocks).map(|l| l.1).sum();
        let (mut end, mut bytes) = (i, 0);
        while end < lines.len() && (end < i + feed.blocks || bytes <= planned + feed.rx_bytes) {
            bytes += lines[end].1;
            end += 1;
        }
        if end < lines.len() || i == 0 {
            let time: f64 = lines[i..end].iter().map(|l| l.0).sum();
            most = most.max(bytes as f64 / time);
        }
    }
    let (mut planned, mut ended): (Vec<f64>, Vec<f64>) = (vec![], vec![]);
    let (mut sent, mut starved) = (0.0_f64, 0.0);
    for (i, l) in lines.iter().enumerate() {
        // The first line that is not among the last ones that fit together with this one.
        let fits = |k: &usize| lines[*k..=i].iter().map(|l| l.1).sum::<usize>() <= feed.rx_bytes;
        let oldest = (0..=i).find(fits).unwrap_or(i);
        let free = oldest.checked_sub(1).map_or(0.0, |k| planned[k]);
        sent = sent.max(free) + l.1 as f64 / feed.bytes_per_s;
        let room = i.checked_sub(feed.blocks).map_or(0.0, |k| ended[k]);
        let before = i.checked_sub(1).map_or(0.0, |k| planned[k]);
        planned.push(sent.max(room).max(before));
        let last = i.checked_sub(1).map_or(planned[i], |k| ended[k]);
        starved += (planned[i] - last).max(0.0);
        ended.push(planned[i].max(last) + l.0);
    }
    [p99 as f64, max as f64, most, starved]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]
    /// Line by line or all at once, with pauses as long as hours between.
    #[test]
    fn line_by_line_is_all_at_once(
        t in proptest::collection::vec((prop_oneof![8 => 0.0005..0.3f64, 1 => 0.9..4.0f64, 1 => 20.0..50.0f64], 5usize..60), 1..100),
        speed in 500.0..20_000.0f64, blocks in 1usize..20, rx in 64usize..200,
    ) {
        let f = Feed { bytes_per_s: speed, rx_bytes: rx, blocks };
        let times: Vec<f64> = t.iter().map(|x| x.0).collect();
        let d = link_demand(t.iter().map(|x| x.1), &times, &f);
        let [p99, max, most, starved] = at_once(&t, &f);
        prop_assert_eq!([d.lines_per_s_p99, d.lines_per_s_max], [p99, max]);
        prop_assert!((d.bytes_per_s_needed / most - 1.0).abs() < 1e-6, "{} {}", d.bytes_per_s_needed, most);
        prop_assert!((d.starved_s - starved).abs() < 1e-9 * starved.max(1.0));
    }
}

/// What is held is what the buffers and one second hold, however long the program; and a pause of ages is no work.
#[test]
fn a_long_program_holds_no_more_than_a_short_one() {
    let mut d = Demand::new(&feed(11_520.0));
    let mut most = 0;
    for k in 0..200_000 {
        d.line(20, if k % 50_000 == 7 { 1e12 } else { 0.01 });
        let held = [&d.rate.open, &d.rate.begins].map(VecDeque::len);
        let held = held[0] + held[1] + d.busiest.lines.len();
        most = most.max(held + d.waiting.received.len() + d.waiting.ended.len());
    }
    assert!(most < 300, "{most}");
    assert!(d.rate.counts.len() < 200);
    let mut ages = Demand::new(&feed(11_520.0));
    for time in [f64::MAX, 1e300, f64::INFINITY, 1e17, 0.5, f64::NAN] {
        ages.line(20, time);
    }
    assert!(ages.finish().lines_per_s_max >= 1.0);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]
    /// A faster link never makes the machine wait longer, and one fast enough for every line by itself never at all.
    #[test]
    fn faster_is_never_worse(t in proptest::collection::vec((0.0005..0.05f64, 5usize..60), 1..300), speed in 500.0..20_000.0f64) {
        let times: Vec<f64> = t.iter().map(|x| x.0).collect();
        let bytes = || t.iter().map(|x| x.1);
        let slow = link_demand(bytes(), &times, &feed(speed));
        let fast = link_demand(bytes(), &times, &feed(1.5 * speed));
        prop_assert!(fast.starved_s <= slow.starved_s + 1e-9);
        prop_assert_eq!(fast.lines_per_s_max, slow.lines_per_s_max);
        let enough = t.iter().map(|x| x.1 as f64 / x.0).fold(0.0, f64::max);
        // The first line behind a stand must not come late either: as long as the link is never slower than the machine.
        prop_assert!(link_demand(bytes(), &times, &feed(60.0 / 0.0005 + enough)).starved_s < 1e-9);
    }
}
