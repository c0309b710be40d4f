#!/bin/sh
# Attacks runs and their commands, by seed, and prints a table of tries and failures:
#   pairs     two commands at once on one run, the second after a random delay, every ordered pair
#   kills     a command that writes into a run, or the end of a print, is killed at a random moment
#   crafted   links, pipes, devices and bombs in each place that a run folder has
#   idle      a thousand silent connections to the operator's desk of a live print, and a stop
#   live      each command before and while a live print goes on with the run
#   stalls    processes of a live print stand still
#   clocks    the wall clock steps, the clocks leap or drift; needs the tests' library: ninja -C build other_clock
#   disks     a print on a disk of some hundred to some thousand kB; needs a mount namespace
#   forged    datagrams of another program on the bus of a live print
#   floods    an instrument babbles, on each port of each lab, and the operator stops the print; with the most memory of a
#             process, the time until the stop was answered, and until the instrument was sent its last bytes; the greeting of a
#             new connection does not count
#   ./firn bench attack [--draws N | --sample N] [--seed S] [--only KIND] [--firn PROGRAM]
# Exit 1 if a try failed; times fail none. Other attacks have programs of their own: bytes of ports wire_faults, the page
# page_attack, live prints random_kills and random_orders, two prints of one name test_page.
set -eu
exec python3 -B "$(dirname "$0")/attack.py" "$@"
