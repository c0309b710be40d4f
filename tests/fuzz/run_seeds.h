// seed_runs writes the seeds of fuzz targets that read what a run leaves: records, states, documents,
// pictures.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>

namespace firn::fuzz {

/// @param seed receives target, name and bytes
void seed_runs(const std::function<void(const char*, const std::string&, std::span<const std::byte>)>& seed);

}  // namespace firn::fuzz
