#!/usr/bin/env bash
# tests/bench/hold_latency.sh [STOPS]: the time from the end of a hold of the page's stop button, in chromium, to the
# answer that SAFE_STOP is on the bus; a live print each.
set -euo pipefail
cd "$(dirname "$0")/../.."
python3 -B tests/web/web_test.py . install
exec node web/test/hold_latency.mjs "$PWD/build/bin/firn" "${1:-25}"
