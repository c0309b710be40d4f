// is_host_name() and is_host_address() bound the texts of [hosts], which become file names and words for ssh.
#pragma once

#include <string_view>

namespace firn {

/// Returns true for 1 to 40 of a-z, 0-9, '_', '-'.
bool is_host_name(std::string_view name);

/// Returns true for an address, or a program there: not empty, no blank or control character, no option of
/// ssh.
bool is_host_address(std::string_view address);

}  // namespace firn
