// LineDialect frames lines that end with one character: each is damaged, an answer, or none.
#pragma once

#include <optional>
#include <string_view>

#include "drivers/link/dialect.h"

namespace firn::drivers {

class LineDialect : public Dialect {
 public:
  char line_end() const override { return end_; }
  Frame frame(std::span<const std::byte> buffer, const Request* awaited) const final;

 protected:
  /// @param longest bytes of a line with its end
  LineDialect(char end, std::size_t longest) : end_(end), longest_(longest) {}

  /// The text of a whole line without its end and checksum; nothing: damaged.
  virtual std::optional<std::string_view> body(std::string_view line) const {
    return line.substr(0, line.size() - 1);
  }
  virtual bool answers(std::string_view body, const Request& asked) const = 0;

 private:
  char end_;
  std::size_t longest_;
};

}  // namespace firn::drivers
