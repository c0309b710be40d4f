// Where outputs go.
#pragma once

#include <filesystem>

namespace firn::logfile {

/// Where an output of this name goes: through symbolic links, to a file that is regular or is not there yet.
/// A folder, a device or a pipe is never replaced: a rename over /dev/null takes it away from the whole
/// machine. @throws FileError (logfile/file.h)
std::filesystem::path output_target(const std::filesystem::path& file);

}  // namespace firn::logfile
