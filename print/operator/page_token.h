// Makes the secret that a browser shows with every command to a print.
#pragma once

#include <string>

namespace firn {

/// Returns 32 hexadecimal digits of the kernel's random numbers. @throws std::runtime_error if there are none
std::string new_page_token();

}  // namespace firn
