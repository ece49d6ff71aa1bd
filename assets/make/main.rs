//! Makes every model of `assets/` again: `make assets`, or `cargo run --example assets`.
//!
//! The files are pure functions of this code: the same bytes on every machine, every time.

mod models;

fn main() -> std::io::Result<()> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    for (name, make) in models::ALL {
        let bytes = make();
        std::fs::write(folder.join(name), &bytes)?;
        eprintln!("assets/{name}: {} KiB", bytes.len().div_ceil(1024));
    }
    Ok(())
}
