// replay_cassette gives a cassette to a driver of today: what the driver sends must be what the tape has.
#pragma once

#include <string>

#include "files/cassette.h"

namespace firn {

/// Makes the driver from the experiment on the tape and gives it what the instrument said and what it was
/// told, at their times. @returns the first line at which the driver does something else, and what; empty:
/// none
/// @throws std::invalid_argument: a tape of more than one incarnation, of no instrument, without its
/// experiment
std::string replay_cassette(const Cassette& cassette);

}  // namespace firn
