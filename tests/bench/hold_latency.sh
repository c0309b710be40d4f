#!/usr/bin/env bash
# tests/bench/hold_latency.sh [STOPS] [OTHER_FIRN]: the time from the end of a hold of the page's stop button, in chromium,
# until SAFE_STOP is heard on the bus, hop by hop on one clock; a live print each. Another program takes turns.
set -euo pipefail
cd "$(dirname "$0")/../.."
python3 -B tests/web/web_test.py . install
exec node web/test/hold_latency.mjs "${1:-100}" "$PWD/build/bin/firn" "${@:2}"
