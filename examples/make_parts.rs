//! Writes the shipped test parts into `examples/parts/`: `cargo run --release --example make_parts`.
#![allow(clippy::print_stdout, missing_docs)]

#[path = "parts/catalogue.rs"]
mod catalogue;

fn main() -> std::io::Result<()> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/parts");
    for file in catalogue::files() {
        println!("{:>9} bytes  {}", file.bytes.len(), file.name);
        std::fs::write(folder.join(&file.name), &file.bytes)?;
    }
    Ok(())
}
