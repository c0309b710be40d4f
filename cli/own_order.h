// own_order speaks to a running print for a program of the lab's own.
#pragma once

#include <string>

#include "print/operator/operator_client.h"

namespace firn {

/// Returns `as`, or where it is empty the name of the account in the letters that a program's name may have.
std::string own_speaker(const std::string& as);

/// Sends "key NAME" or "say NAME CHANNEL JSON". @returns the print's answer without its "ok"
/// @throws UsageError if the print refuses; std::runtime_error if it is gone
std::string own_order(OperatorClient& client, const std::string& run, const std::string& order);

}  // namespace firn
