// device_verbs lists the orders that a person may give each instrument (`firn device LAB NAME VERB`).
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/experiment.h"
#include "print/device/device_order.h"

namespace firn {

/// A verb with its values, as the instrument `node` gets it.
struct DeviceCall {
  const Experiment& e;
  std::string_view node;
  std::string_view verb;
  std::vector<double> values;
  bool far = false;  ///< a jog beyond 5 mm and 10 mm/s
};
using MakeOrder = DeviceOrder (*)(const DeviceCall&, const OrderStamp&);

struct DeviceVerb {
  std::string_view node;  ///< "" = every instrument; "jet" also jet_b, "valve_a" also valve_b
  std::string_view name;
  std::string_view values;  ///< "X Y Z [mm]"
  std::size_t count = 0;
  std::string_view meaning;
  MakeOrder order = nullptr;  ///< nullptr: the connection alone answers it
  bool asks = false;          ///< moves, fires and lights nothing: a stage is not homed for it
  MakeOrder after = nullptr;  ///< ends the order when its time, the last value [s], is over
  bool repeats = false;       ///< the first value is how often `order` is given
};

/// Returns the verbs that the instrument has.
std::vector<const DeviceVerb*> verbs_of(std::string_view node);

/// @throws UsageError naming the verbs that the instrument has
const DeviceVerb& device_verb(std::string_view node, std::string_view name);

/// @throws UsageError: another number of values than the verb takes, a text that is no number
std::vector<double> verb_values(const DeviceVerb& verb, const std::vector<std::string>& texts);

}  // namespace firn
