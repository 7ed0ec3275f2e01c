#!/usr/bin/env bash
# What a controller links: feedrate, sync and kinematics without standard library and heap.
set -euo pipefail
cd "$(dirname "$0")"
target=${CARGO_TARGET_DIR:-$PWD/target}

# For machines without an operating system, where rustup has the target.
for machine in thumbv7em-none-eabihf x86_64-unknown-none; do
  if [[ -d "$(rustc --print sysroot)/lib/rustlib/$machine" ]]; then
    for crate in feedrate kinematics sync; do
      RUSTFLAGS="-D warnings" cargo build -q --release --no-default-features --target "$machine" \
        --manifest-path "../../$crate/Cargo.toml" --target-dir "$target/$machine"
    done
    echo "builds for $machine"
  else
    echo "skipped: $machine (rustup target add $machine)"
  fi
done

# For this machine, as a program: no symbol of std, of alloc or of a function that allocates.
cargo build -q --release --locked
program="$target/release/arcfeed-bare"
symbols=$(nm "$program")
grep -q ' T main' <<<"$symbols" || { echo "the program has no symbols to look at"; exit 1; }
if grep -E '_ZN(3std|5alloc)|_R.*(3std|5alloc)|malloc|calloc|realloc|__rust_' <<<"$symbols"; then
  echo "the program links the standard library or a heap"
  exit 1
fi
"$program"
