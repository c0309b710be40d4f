#!/usr/bin/env bash
# tests/bench/first_paint.sh RUN [ROUNDS]: the time from the address to the painted surface of a run in chromium, each
# round by a page that has opened no run yet, then again by one that has; processor time beside. RUN "live": a print
# that runs meanwhile, begun here.
set -euo pipefail
cd "$(dirname "$0")/../.."
run=${1:?a run folder, or live}
rounds=${2:-5}
python3 -B tests/web/web_test.py . install
exec node web/test/first_paint.mjs "$PWD/build/bin/firn" "$run" "$rounds"
