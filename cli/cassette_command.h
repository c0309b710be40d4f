// run_cassette shows the record of an instrument's port, and holds it against the driver of today.
#pragma once

#include <string>

namespace firn {

class OptionSet;

struct CassetteOptions {
  std::string file;
  std::string keep;  ///< file of a transcript test that is written
  bool json = false;
};

/// @returns 0, or 1 where the driver of today sends something else than the tape has
int run_cassette(const CassetteOptions& options);

/// Declares the arguments.
void declare_cassette(OptionSet& options);

}  // namespace firn
