#!/bin/sh
# Attacks runs and their commands, by seed, and prints a table of tries and failures:
#   pairs     two commands at once on one run, the second after a random delay, every ordered pair
#   kills     a command that writes into a run, or the end of a print, is killed at a random moment
#   crafted   links, pipes, devices and bombs in each place that a run folder has
#   idle      a thousand silent connections to the operator's desk of a live print, and a stop
#   ./firn bench attack [--draws N | --sample N] [--seed S] [--only KIND] [--firn PROGRAM]
# Exit 1 if a try failed. Other attacks have benches of their own: forged datagrams and bytes of ports stop_latency, wire_faults;
# the page page_attack; full disks, stalls and kills of live prints random_kills, random_orders.
set -eu
exec python3 -B "$(dirname "$0")/attack.py" "$@"
