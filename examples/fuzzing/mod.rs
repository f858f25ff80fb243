//! A mutation fuzzer without coverage feedback, in plain stable Rust: `examples/fuzz.rs` runs it for minutes, `tests/it/fuzz.rs` for
//! seconds. Case `i` of seed `s` is always the same input, so every finding can be had again from two numbers.

pub mod corpus;
pub mod journal;
pub mod mutate;
pub mod random;
pub mod talk;
pub mod targets;

use random::Random;
use std::cell::RefCell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::{Once, OnceLock};
use std::time::{Duration, Instant};
use targets::Target;

/// An input that takes longer is a finding.
pub const SLOW: Duration = Duration::from_secs(2);

/// What came of one input.
pub enum Outcome {
    /// Read.
    Accepted,
    /// Refused with a message.
    Refused,
    /// Something to mend: what happened.
    Finding(String),
}

thread_local! {
    static PANIC: RefCell<Option<String>> = const { RefCell::new(None) };
    static QUIET: RefCell<bool> = const { RefCell::new(false) };
}

/// Notes panics of this thread instead of printing them.
fn listen() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if QUIET.with(|q| *q.borrow()) {
                PANIC.with(|p| *p.borrow_mut() = Some(info.to_string()));
            } else {
                usual(info);
            }
        }));
    });
}

/// The input of a case.
pub fn input(target: &Target, seeds: &[Vec<u8>], seed: u64, case: u64) -> Vec<u8> {
    mutate::spoilt(&mut Random::of_case(seed, case), seeds, target.words)
}

/// Time this thread has computed, where the system tells (Linux's scheduler does): a busy neighbour makes no reader slow. Elsewhere time
/// that has passed.
fn now() -> Duration {
    static START: OnceLock<Instant> = OnceLock::new();
    let computed = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = computed.and_then(|s| s.split(' ').next()?.parse().ok());
    nanoseconds.map_or_else(
        || START.get_or_init(Instant::now).elapsed(),
        Duration::from_nanos,
    )
}

/// Reads one input and watches over it.
pub fn try_input(target: &Target, bytes: &[u8]) -> Outcome {
    listen();
    QUIET.with(|q| *q.borrow_mut() = true);
    let start = now();
    let result = panic::catch_unwind(AssertUnwindSafe(|| (target.read)(bytes)));
    let taken = now().saturating_sub(start);
    QUIET.with(|q| *q.borrow_mut() = false);
    match result {
        Err(_) => {
            let said = PANIC.with(|p| p.borrow_mut().take());
            Outcome::Finding(format!("panic: {}", said.unwrap_or_default()))
        }
        Ok(Err(said)) => Outcome::Finding(said),
        Ok(_) if taken > SLOW => Outcome::Finding(format!("slow: {:.1} s", taken.as_secs_f64())),
        Ok(Ok(true)) => Outcome::Accepted,
        Ok(Ok(false)) => Outcome::Refused,
    }
}
