// `firn doctor`: what this machine lacks for live prints, and the mend.
#pragma once

namespace firn {

struct DoctorOptions {
  bool json = false;
};

/// @returns kOk when nothing is wrong, else kFailed
int run_doctor(const DoctorOptions& options);

}  // namespace firn
