//! The header in the repository is what cbindgen makes of the sources.

use std::fs;
use std::path::Path;

/// With `ARCFEED_WRITE_HEADER=1` the header is written.
#[test]
fn the_header_is_current() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let file = package.join("include/arcfeed.h");
    let config = cbindgen::Config::from_file(package.join("cbindgen.toml")).expect("a configuration");
    let builder = cbindgen::Builder::new().with_config(config).with_src(package.join("src/lib.rs"));
    let mut made = Vec::new();
    builder.generate().expect("a header").write(&mut made);
    // What a Rust reader needs as a heading is one more sentence in C.
    let made = String::from_utf8(made).expect("text").replace("// # Safety\n", "");
    if std::env::var_os("ARCFEED_WRITE_HEADER").is_some() {
        fs::write(&file, &made).expect("the header is written");
    }
    let kept = fs::read_to_string(&file).unwrap_or_default();
    assert!(kept == made, "include/arcfeed.h is old: ARCFEED_WRITE_HEADER=1 cargo test --test header");
}
