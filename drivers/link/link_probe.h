// LinkProbe holds a question that changes nothing, by which an instrument is known at a port.
#pragma once

#include <string>
#include <string_view>

#include "drivers/link/line_cleaner.h"

namespace firn::drivers {

struct LinkProbe {
  std::string_view instrument;  ///< as messages call it: "an Aerotech stage"
  std::string question;
  bool (*answered)(std::string_view heard);  ///< of clean lines, where the protocol has lines
  char line_end = 0;                         ///< 0 = a binary protocol

  /// @param heard as it came, perhaps with an echo of the question before the answer
  bool answers(std::string_view heard) const {
    if (line_end == 0) return answered(heard);
    std::string text = cleaned(heard, line_end);
    if (const std::string echo = cleaned(question, line_end); text.starts_with(echo))
      text.erase(0, echo.size());
    return answered(text);
  }
};

}  // namespace firn::drivers
