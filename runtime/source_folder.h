// source_folder() is the folder whose experiments, labs and documents the program knows.
#pragma once

#include <filesystem>

namespace firn {

/// Returns PREFIX/share/firn of a program that lies in PREFIX/lib/firn/bin, wherever PREFIX is; else the
/// checkout that the program was built from.
std::filesystem::path source_folder();

}  // namespace firn
