// ScriptOptions name the class in Python that drives an instrument.
#pragma once

#include <string>

namespace firn::drivers {

struct ScriptOptions {
  std::string node;             ///< "lamp", as messages call the instrument
  std::string file;             ///< "psu.py", without its folder
  std::string class_name;       ///< of the file
  std::string arguments;        ///< of its construction: "max_a=3"; empty: none
  bool own_port = false;        ///< the class opens its instrument itself: no bytes pass here
  double host_latency_s = 0.0;  ///< that the host itself may need for an answer
};

}  // namespace firn::drivers
