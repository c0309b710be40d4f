// AnsweringNode is a driver's node that tells whether its instrument answers.
#pragma once

namespace firn {

class AnsweringNode {
 public:
  virtual ~AnsweringNode() = default;
  /// The instrument has given a good reply since its port was opened.
  virtual bool answered() const = 0;
};

}  // namespace firn
