// source_folder() is the checkout that the program was built from, whose experiments and documents it knows.
#pragma once

#include <filesystem>

namespace firn {

std::filesystem::path source_folder();

}  // namespace firn
