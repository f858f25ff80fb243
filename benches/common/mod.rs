//! What the benches share: parts of any size, CPU time, and a table of ratios at the end of a run.
//!
//! Times in the tables are CPU seconds of this process, its threads and its children: on a machine that others use, too, they say
//! more than the clock on the wall (which `divan` shows above them). Every ratio is between figures of one run.
#![allow(
    dead_code,
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "each bench uses its share; a bench that fails should say where; its table is for the terminal"
)]

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use morsemill::geom::Point;
use morsemill::part::Mesh;
use std::sync::Mutex;
use std::time::Instant;

/// Side of the parts, mm.
pub const SIDE: f64 = 65.0;
/// Radius of the ball, mm.
pub const RADIUS: f64 = 3.0;

/// A surface over the square from 0 to [`SIDE`].
pub type Height = fn(f64, f64) -> f64;

/// Two peaks on a dome; slopes to 45 degrees.
pub fn gentle(x: f64, y: f64) -> f64 {
    let bell = |a: f64, b: f64, height: f64, wide: f64| {
        height * (-((x - a).powi(2) + (y - b).powi(2)) / (2.0 * wide * wide)).exp()
    };
    bell(22.0, 24.0, 10.0, 9.0) + bell(44.0, 42.0, 13.0, 10.0)
        - 0.002 * ((x - 32.0).powi(2) + (y - 32.0).powi(2))
}

/// An egg box with slopes to 68 degrees; its bottoms are narrower than the ball in one direction.
pub fn steep(x: f64, y: f64) -> f64 {
    let k = std::f64::consts::TAU / 32.0;
    12.6 * (k * x).sin() * (k * y).cos()
}

/// About so many triangles over a surface, coordinates as an STL holds them.
pub fn relief(triangles: usize, height: Height) -> Mesh {
    let n = ((triangles as f64 / 2.0).sqrt().round() as usize).max(1);
    let step = SIDE / n as f64;
    let stl = |v: f64| f64::from(v as f32);
    let p = |i: usize, j: usize| {
        let (x, y) = (i as f64 * step, j as f64 * step);
        Point::new(stl(x), stl(y), stl(height(x, y)))
    };
    let mut out = Mesh::default();
    for j in 0..n {
        for i in 0..n {
            let [a, b, c, d] = [p(i, j), p(i + 1, j), p(i + 1, j + 1), p(i, j + 1)];
            out.triangles.push([a, b, c]);
            out.triangles.push([a, c, d]);
        }
    }
    out
}

/// A mesh as a binary STL.
pub fn stl(mesh: &Mesh) -> Vec<u8> {
    let mut out = vec![0; 80];
    out.extend((mesh.triangles.len() as u32).to_le_bytes());
    for t in &mesh.triangles {
        out.extend([0; 12]);
        for v in t.iter().flat_map(|p| [p.x, p.y, p.z]) {
            out.extend((v as f32).to_le_bytes());
        }
        out.extend([0; 2]);
    }
    out
}

/// Places anywhere over the part, the same in every run.
pub fn places(n: usize) -> Vec<(f64, f64)> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        SIDE * (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..n).map(|_| (next(), next())).collect()
}

/// CPU seconds of this process, its threads and its finished children; the clock where the system does not tell (not Linux).
fn cpu() -> f64 {
    static START: Mutex<Option<Instant>> = Mutex::new(None);
    let told = || {
        let text = std::fs::read_to_string("/proc/self/stat").ok()?;
        // Behind the name in brackets: state is field 3, utime, stime, cutime, cstime are 14 to 17, in hundredths.
        let fields: Vec<&str> = text.rsplit(')').next()?.split_whitespace().collect();
        let ticks: Option<f64> = (11..15).map(|i| fields.get(i)?.parse::<f64>().ok()).sum();
        Some(ticks? / 100.0)
    };
    told().unwrap_or_else(|| {
        START
            .lock()
            .unwrap()
            .get_or_insert_with(Instant::now)
            .elapsed()
            .as_secs_f64()
    })
}

/// What was booked for one size.
struct Cost {
    size: usize,
    seconds: f64,
    items: f64,
}

struct Row {
    name: &'static str,
    costs: Vec<Cost>,
}

static ROWS: Mutex<Vec<Row>> = Mutex::new(Vec::new());

/// Runs `work` on `items` things again and again, as `divan` decides, and books the CPU time of each run under a row and a size.
/// The system counts in hundredths of a second, so all runs of a size together should take some tenths.
pub fn measure<T>(
    bencher: Bencher,
    row: &'static str,
    size: usize,
    items: usize,
    mut work: impl FnMut() -> T,
) {
    bencher.counter(ItemsCount::new(items)).bench_local(|| {
        let begin = cpu();
        let out = black_box(work());
        book(row, size, cpu() - begin, items as f64);
        out
    });
}

fn book(name: &'static str, size: usize, seconds: f64, items: f64) {
    let mut rows = ROWS.lock().unwrap();
    let row = match rows.iter_mut().position(|r| r.name == name) {
        Some(i) => &mut rows[i],
        None => {
            rows.push(Row {
                name,
                costs: vec![],
            });
            rows.last_mut().unwrap()
        }
    };
    match row.costs.iter_mut().find(|c| c.size == size) {
        Some(c) => {
            c.seconds += seconds;
            c.items += items;
        }
        None => row.costs.push(Cost {
            size,
            seconds,
            items,
        }),
    }
}

/// Prints what was booked: for each row and size the cost per item and its ratio to the size before.
pub fn table(what: &str, sizes: &str) {
    let mut rows = ROWS.lock().unwrap();
    if rows.is_empty() {
        return;
    }
    println!("\n{what}: CPU time per item, and how it grows from one size to the next ({sizes})");
    for row in rows.iter_mut() {
        row.costs.sort_by_key(|c| c.size);
        print!("{:<34}", row.name);
        let mut before: Option<f64> = None;
        for c in &row.costs {
            let (size, cost) = (c.size, c.seconds / c.items);
            let (scale, unit) = if cost < 1e-4 { (1e6, "us") } else { (1.0, "s") };
            print!("  {}: {:.3} {unit}", short(size), cost * scale);
            if cost < 1e-4 {
                print!(" ({:.0} k/s)", 1e-3 / cost);
            }
            if let Some(b) = before {
                print!(" = {:.2} x", cost / b);
            }
            before = Some(cost);
        }
        println!();
    }
}

fn short(n: usize) -> String {
    match n {
        1_000_000.. => format!("{:.3} M", n as f64 / 1e6),
        10_000.. => format!("{} k", (n + 500) / 1000),
        _ => n.to_string(),
    }
}
