// encode_job writes a print job as bytes, for a run's input "job".
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/path/print_job.h"

namespace firn {

std::vector<std::byte> encode_job(const PrintJob& job);
/// @throws FormatError naming the byte; also of a job without segments
PrintJob decode_job(std::span<const std::byte> bytes);

}  // namespace firn
