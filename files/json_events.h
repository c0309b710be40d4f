// A JSON document as events, from a stream, with a block of it in memory (grammar: RFC 8259; a byte order
// mark is passed over). Some five times as fast on lists of numbers as nlohmann's events, which
// tests/cli/json_events_test.cpp holds it to.
#pragma once

#include <cstdint>
#include <string>

#include "files/byte_blocks.h"

namespace firn {

/// Takes the events in the document's order. An exception ends the reading.
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

/// What a document breaks the grammar with: the byte, counted from 1, and what is wrong there.
struct JsonMistake {
  std::uint64_t byte;
  std::string what;
};

/// @throws JsonMistake, and what `to` throws
void read_json_events(ByteBlocks& in, JsonHandler& to);

}  // namespace firn
