#!/usr/bin/env bash
# Instructions of one call of a control cycle, in the worst of COUNT hostile cases of each row: the slowest are found by time and
# counted by callgrind.
#
#   cycle_cost.sh [COUNT]
set -euo pipefail
cd "$(dirname "$0")"
cargo build -q --release -p integration-tests --example cycle_cost
program=${CARGO_TARGET_DIR:-../target}/release/examples/cycle_cost
counts=$(mktemp -d)
trap 'rm -rf "$counts"' EXIT

# Instructions of the call in one case.
instructions() {
  valgrind --tool=callgrind --collect-atstart=no --toggle-collect='cycle_cost::measured*' \
    --callgrind-out-file="$counts/out" "$program" one "$1" "$2" >/dev/null 2>"$counts/log"
  sed -n 's/^summary: //p; s/^totals: //p' "$counts/out" | head -n 1
}

echo "| call | axes | a middling case | the costliest case | its seed |"
echo "|---|---|---|---|---|"
"$program" search "${1:-20000}" | while IFS=';' read -r row name axes seeds; do
  worst=0 seed=-
  for candidate in $seeds; do
    count=$(instructions "$row" "$candidate")
    if ((${count:-0} > worst)); then worst=$count seed=$candidate; fi
  done
  # The middle of the first five seeds that give a case.
  few=()
  for candidate in {1..999}; do
    count=$(instructions "$row" "$candidate")
    if ((${count:-0} > 0)); then few+=("$count"); fi
    if ((${#few[@]} == 5)); then break; fi
  done
  middle=$(printf '%s\n' "${few[@]}" | sort -n | sed -n 3p)
  echo "| $name | $axes | $middle | $worst | $seed |"
done
