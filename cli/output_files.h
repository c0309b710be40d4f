// check_output_files() refuses a command's outputs that would replace its inputs or each other;
// check_writable() those that cannot be written, check_ending() those that no command could read by their
// names.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

/// @param inputs files that the command reads
/// @param outputs files that it writes; empty ones are left out
/// @throws UsageError
void check_output_files(std::vector<std::filesystem::path> inputs,
                        std::initializer_list<std::string> outputs);

/// For a command whose work is long: it would end without its result. Empty names are left out.
/// @throws UsageError: no such folder, not writable, a folder itself
void check_writable(std::initializer_list<std::string> outputs);

/// @throws UsageError, naming the option, unless `file` is empty or ends in one of the endings, in small
/// letters or capitals
void check_ending(std::string_view option, const std::string& file,
                  std::span<const std::string_view> endings);

}  // namespace firn
