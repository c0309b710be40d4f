// output_target returns the file that an output of a given name replaces.
#pragma once

#include <filesystem>

namespace firn::record {

/// Follows symbolic links to a file that is regular or does not exist yet. A folder, a device or a pipe is
/// never replaced: a rename over /dev/null would remove the device from the whole machine. In a run folder a
/// link is not followed (files/record/open_file.h). @throws FileError (files/record/file.h)
std::filesystem::path output_target(const std::filesystem::path& file);

}  // namespace firn::record
