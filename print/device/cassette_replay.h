// replay_cassette gives a cassette to a driver of today: the driver must send the bytes of the tape.
#pragma once

#include <string>

#include "files/cassette.h"
#include "print/labs/product.h"

namespace firn {

/// Makes the driver from the experiment on the tape and gives it the instrument's bytes and its orders at
/// their times. @returns the first line at which the driver does something else, with its bytes; empty: none
/// @throws std::invalid_argument: a tape of more than one incarnation, of no instrument, without its
/// experiment
std::string replay_cassette(const Product& product, const Cassette& cassette);

}  // namespace firn
