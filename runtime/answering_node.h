// AnsweringNode is a driver's node that tells whether its instrument answers.
#pragma once

#include <string>

namespace firn {

class AnsweringNode {
 public:
  virtual ~AnsweringNode() = default;
  /// The instrument has given a good reply since its port was opened.
  virtual bool answered() const = 0;
  /// The last line that came for an answer and was not understood, shown; empty: none.
  virtual const std::string& last_not_understood() const = 0;
};

}  // namespace firn
