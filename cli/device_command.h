// run_device speaks to one instrument of a lab alone: who it is, what it measures, and the orders of its
// kind.
#pragma once

#include <string>
#include <vector>

namespace firn {

class OptionSet;

struct DeviceCommandOptions {
  std::string lab;   ///< lab or experiment file
  std::string node;  ///< "stage", "lamp", ...
  std::string verb;
  std::vector<std::string> values;  ///< of the verb
  double within_s = 120.0;          ///< longest wait for the end of an order
  bool trace = false;               ///< each piece of bytes on stderr
  std::string record;               ///< file for the same as lines; empty: none
  std::string out;                  ///< .csv or .png of profiles, .png of pictures
  bool watch = false;               ///< status: until Ctrl-C
  bool dry_run = false;             ///< the bytes of the order, and no port opened
  bool unsafe = false;              ///< raw: bytes past driver, limits and stop
  bool far = false;                 ///< a jog beyond 5 mm and 10 mm/s
  bool json = false;
  std::vector<std::string> overrides;
};
/// @returns kOk; kFailed when the instrument refused or failed; kSafetyStop when the link gave no answer;
/// kInterrupted after Ctrl-C, with the instrument made safe. @throws UsageError: no such instrument or verb,
/// a value that is none
int run_device(const DeviceCommandOptions& options);

/// Declares the arguments.
void declare_device(OptionSet& options);

}  // namespace firn
