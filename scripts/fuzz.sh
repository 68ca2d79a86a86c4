#!/usr/bin/env bash
# Fuzzes the readers of user input, for the given number of seconds per target (default 60): scripts/fuzz.sh [seconds] [target ...]
# Findings are in build-fuzz/tests/crash-*, timeout-* and so on; add them to tests/corpus/<target>.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
seconds=${1:-60}
shift || true
targets=("$@")
[[ ${#targets[@]} -gt 0 ]] || targets=(config_xml cell_xml mesh pos state command_line)
cmake --preset fuzz
cmake --build build-fuzz --target "${targets[@]/#/fuzz_}"
cd build-fuzz/tests
for target in "${targets[@]}"; do
  mkdir -p "found/$target"
  ../bin/fuzz_"$target" -max_total_time="$seconds" -timeout=30 -rss_limit_mb=3000 "found/$target" "../../tests/corpus/$target"
done
