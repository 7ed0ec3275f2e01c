#!/usr/bin/env bash
# Builds the library, the examples and the tests in C and C++, runs them, and runs them again under valgrind.
#
#   run_examples.sh [FOLDER]     keeps the files of the examples in FOLDER
set -euo pipefail
kept=${1:+$(realpath -m "$1")}
cd "$(dirname "$0")"
target=${CARGO_TARGET_DIR:-$PWD/target}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
files=${kept:-$out}
mkdir -p "$files"

cargo build -q --release
library="$target/release/libarcfeed.a"
warnings="-O2 -g -Wall -Wextra -Wpedantic -Werror -Iinclude"
system="-lpthread -ldl -lm"
wrap="-Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=posix_memalign"

# shellcheck disable=SC2086
{
  gcc -std=c11 $warnings examples/control_loop.c "$library" $system -o "$out/control_loop"
  gcc -std=c11 $warnings examples/pass_and_follow.c "$library" $system -o "$out/pass_and_follow"
  gcc -std=c11 $warnings tests/refusals.c "$library" $system -o "$out/refusals"
  gcc -std=c11 $warnings tests/refusals_routes.c "$library" $system -o "$out/refusals_routes"
  gcc -std=c11 $warnings $wrap tests/no_heap.c "$library" $system -o "$out/no_heap"
  gcc -std=c11 $warnings tests/stack.c "$library" $system -o "$out/stack"
  g++ -std=c++17 $warnings examples/moves.cpp "$library" $system -o "$out/moves"
  # The shared library, found beside the program.
  gcc -std=c11 $warnings examples/control_loop.c -L"$target/release" -larcfeed -Wl,-rpath,"$target/release" -lm -o "$out/shared"
}

run() {
  "$@"
  if command -v valgrind >/dev/null; then
    valgrind -q --error-exitcode=9 --leak-check=full --show-leak-kinds=definite,indirect,possible \
      --errors-for-leak-kinds=definite,indirect,possible "$@" >/dev/null
  fi
}

run "$out/refusals"
run "$out/refusals_routes"
run "$out/no_heap"
# Its own painting of stacks is what it measures by: not under valgrind.
"$out/stack"
run "$out/control_loop" --fast "$files"
run "$out/pass_and_follow"
run "$out/moves" examples/data/there_and_back.json examples/data/arm.urdf
"$out/shared" --fast "$out" >/dev/null
command -v valgrind >/dev/null || echo "valgrind is not installed: memory was not checked"
