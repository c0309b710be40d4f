// Tags name the purpose of a request to the robot, by which its reply is understood.
#pragma once

#include <cstdint>

namespace firn::drivers::robot_tag {

enum Tag : std::uint16_t {
  kPlain,
  kHello,
  kStat,
  kWhere,
  kBeat,
  kSpeed,
  kMove,
  kRunPath,
  kBegin,  ///< of the upload of a path, as are the next two
  kPoints,
  kEnd,
  kDropSlot,
  kClear,
  kHarmless  ///< it may be refused
};

}  // namespace firn::drivers::robot_tag
