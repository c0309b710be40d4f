// layers_by_name() finds the layer of each file of a folder in the numbers of its name.
#pragma once

#include <filesystem>
#include <map>
#include <vector>

namespace firn {

/// Several numbers are told apart by the word before them ("layer003", "L3"), else by which one varies.
/// @param files not empty @param layer_number 1 = the first number of each name, -1 = the last, 0 = detect
/// @throws UsageError: no number, two files of a layer, or several numbers that could be the layer, with the
/// layers that each would give
std::map<int, std::filesystem::path> layers_by_name(const std::vector<std::filesystem::path>& files,
                                                    int layer_number);

}  // namespace firn
