//! Nothing is answered: the cause has a name, and what only looks like a stall is none.

use super::bench::{Bench, SQUARE, told};
use morsemill::link::{Command, Ending, Progress, Stall};
use std::time::Duration;

#[test]
fn stalls_have_names() {
    // Door and hold.
    let mut bench = Bench::plain(SQUARE);
    bench.ticks(1500);
    bench.command(Command::Door);
    bench.until("Stall(Some(Door))");
    bench.ticks(1000);
    bench.command(Command::Resume);
    bench.until("Resumed");
    bench.command(Command::Hold);
    bench.until("Stall(Some(Hold))");
    bench.ticks(500);
    bench.command(Command::Resume);
    assert_eq!(bench.finish().ending, Ending::Done);
    // The program's own pause.
    let mut bench = Bench::plain("G0X1\nM0 (turn it)\nG0X2\n");
    bench.until("Stall(Some(Prompt))");
    bench.until("the program pauses at line 2 (turn it)");
    // A dwell.
    let mut bench = Bench::plain("G0X1\nG4P6\nG0X2\n");
    bench.until("Stall(Some(Waiting { line: 2 }))");
    assert_eq!(bench.finish().ending, Ending::Done);
    assert!(bench.heard("Stall(None)"));
    // Slow motion, planner full.
    let slow: String = (1..40).map(|i| format!("G1 X{i} F20\n")).collect();
    let mut bench = Bench::plain(&slow);
    bench.until("Stall(Some(PlannerFull");
    // The journal.
    let mut bench = Bench::plain(SQUARE);
    bench.session.allow_up_to(3);
    bench.until("Stall(Some(Permission))");
    assert_eq!(bench.session.next_index(), 3);
    bench.session.allow_up_to(usize::MAX);
    assert_eq!(bench.finish().ending, Ending::Done);
    // Restart.
    let mut bench = Bench::plain(SQUARE);
    bench.ticks(1500);
    bench.controller.power_cycle();
    bench.until("Stall(Some(ControllerReset))");
    // Dead link.
    let mut bench = Bench::plain(SQUARE);
    bench.ticks(1500);
    bench.back.delays = vec![100_000_000];
    bench.until("Stall(Some(LinkDead))");
}

#[test]
fn a_machine_that_says_run_and_does_not_is_stuck() {
    let (session, news) = told(
        "<Run|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000>\r\n",
        20,
    );
    let stuck = Progress::Stall(Some(Stall::Stuck { line: 1 }));
    assert!(news.contains(&stuck), "{news:?}");
    assert_eq!(session.outcome(), None);
}

#[test]
fn clocks_that_jump_are_told() {
    let mut bench = Bench::plain(SQUARE);
    bench.ticks(1500);
    let now = Duration::from_millis(bench.now);
    bench.session.wall_clock(Duration::from_secs(1000), now);
    bench
        .session
        .wall_clock(Duration::from_secs(1001), now + Duration::from_secs(1));
    bench.session.news();
    bench
        .session
        .wall_clock(Duration::from_secs(8201), now + Duration::from_secs(1));
    assert_eq!(bench.session.news(), [Progress::ClockJump { by_s: 7200.0 }]);
    // A host that was away for long does not take its own silence for the controller's.
    bench.now += 20_000;
    assert_eq!(bench.finish().ending, Ending::Done);
    assert!(bench.heard("this computer did not look at the port for 20.0 s"));
}
