// check_output_files() refuses a command's outputs that would replace its inputs or each other.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <vector>

namespace firn {

/// @param inputs files that the command reads
/// @param outputs files that it writes; empty ones are left out
/// @throws UsageError
void check_output_files(std::vector<std::filesystem::path> inputs,
                        std::initializer_list<std::string> outputs);

}  // namespace firn
