#!/usr/bin/env bash
# Feeds one target of the arbitrary inputs to libFuzzer for some minutes, on a stable toolchain and with a C++ compiler:
#
#   integration-tests/libfuzzer/run.sh TARGET MINUTES [OPTION OF LIBFUZZER...]
#
# Inputs that reach new code are kept in target/corpus/TARGET, and an input that is a defect in target/found/. The exit code is then not 0.
set -euo pipefail
target=${1:?name a target, as of the example fuzz}
minutes=${2:?say for how many minutes}
shift 2
cd "$(dirname "$0")"

# What cargo-fuzz asks of the compiler, without a sanitizer, which needs nightly: a counter for each edge, and the values compared.
export RUSTFLAGS="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares -Clink-arg=-Wl,-z,nostart-stop-gc --cfg fuzzing"
host=$(rustc -vV | sed -n 's/^host: //p')
# With --target the flags are not those of build scripts.
cargo build -q --release --locked --target "$host"

mkdir -p "target/corpus/$target" target/found
kept=../corpus/$target
# The first folder takes what is new; the kept one is only read.
folders=("target/corpus/$target")
if [ -d "$kept" ]; then folders+=("$kept"); fi
ARCFEED_TARGET="$target" "target/$host/release/arcfeed-libfuzzer" "${folders[@]}" \
  -max_total_time=$((60 * minutes)) -max_len=20000 -timeout=60 -rss_limit_mb=2048 \
  -artifact_prefix="target/found/$target-" -print_final_stats=1 "$@"
