// device_verbs lists the orders that a person may give each instrument (`firn device LAB NAME VERB`).
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/experiment.h"
#include "print/device/device_order.h"

namespace firn {

struct DeviceVerb {
  std::string_view node;  ///< "" = every instrument
  std::string_view name;
  std::string_view values;  ///< "X Y Z [mm]"
  std::size_t count = 0;
  std::string_view meaning;
  /// nullptr: a question.
  DeviceOrder (*order)(const Experiment&, const std::vector<double>&, const OrderStamp&) = nullptr;
};

std::span<const DeviceVerb> device_verbs();

/// @throws UsageError naming the verbs that the instrument has
const DeviceVerb& device_verb(std::string_view node, std::string_view name);

/// @throws UsageError: another number of values than the verb takes, a text that is no number
std::vector<double> verb_values(const DeviceVerb& verb, const std::vector<std::string>& texts);

}  // namespace firn
