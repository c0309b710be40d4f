// run_doctor reports the requirements of live prints that this machine does not meet, each with its remedy.
#pragma once

#include <string>
#include <vector>

namespace firn {

class OptionSet;

struct DoctorOptions {
  std::string lab;                     ///< lab file; empty: the machine alone
  std::vector<std::string> overrides;  ///< --set KEY=VALUE
  bool json = false;
};

/// @returns kOk when nothing is wrong, else kFailed
int run_doctor(const DoctorOptions& options);

/// Declares the arguments.
void declare_doctor(OptionSet& options);

}  // namespace firn
