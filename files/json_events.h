// read_json_events reads a JSON document from a stream as events, with one block in memory (grammar: RFC
// 8259; a byte order mark is skipped). On lists of numbers the reader is about five times as fast as
// nlohmann's events; tests/cli/json_events_test.cpp compares the two.
#pragma once

#include <cstdint>
#include <string>

#include "files/byte_blocks.h"

namespace firn {

/// Receives the events in the document's order. An exception ends the reading.
class JsonHandler {
 public:
  virtual ~JsonHandler() = default;
  virtual void null() = 0;
  virtual void boolean(bool value) = 0;
  virtual void integer(double value) = 0;  ///< a number without point and exponent
  virtual void number(double value) = 0;
  virtual void text(const std::string& value) = 0;
  virtual void start_object() = 0;
  virtual void key(const std::string& value) = 0;
  virtual void end_object() = 0;
  virtual void start_list() = 0;
  virtual void end_list() = 0;
};

/// A violation of the grammar: the byte, counted from 1, and the problem at that byte.
struct JsonMistake {
  std::uint64_t byte;
  std::string what;
};

/// @throws JsonMistake, and any exception of `to`
void read_json_events(ByteBlocks& in, JsonHandler& to);

}  // namespace firn
