// LinkProbe holds a question that changes nothing, by which an instrument is known at a port.
#pragma once

#include <string>
#include <string_view>

namespace firn::drivers {

struct LinkProbe {
  std::string_view instrument;  ///< as messages call it: "an Aerotech stage"
  std::string question;
  bool (*answered)(std::string_view heard);
};

}  // namespace firn::drivers
