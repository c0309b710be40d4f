// A part's outcome as the text that a journal keeps, so that the parts of the papers are computed in shards,
// on other computers, and once.
#pragma once

#include <string>

#include "studies/reproduce/reproduce.h"

namespace firn {

/// Returns all of a result but its part: notes, rows, numbers beside, pictures, error; one JSON object.
std::string part_record(const PartResult& result);

/// Returns the result that part_record() wrote, the same to the last bit. @param part of it
/// @throws std::runtime_error naming the part and the fault: the text is no such record
PartResult part_of(const std::string& record, const ReproducePart& part);

}  // namespace firn
