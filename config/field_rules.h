// FieldRules checks rules between the keys of one file and reports a broken one with file, line, key and
// value.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "config/checks.h"
#include "config/fields.h"

namespace firn {

class FieldRules {
 public:
  FieldRules(std::vector<Field> table, const Origins& origins, const std::string& file)
      : table_(std::move(table)), origins_(origins), file_(file) {}

  /// @throws ConfigError unless ok: "<key> = <value>: <problem>", at the line that gave the key
  void require(bool ok, const std::string& key, const std::string& problem) const;

 private:
  std::vector<Field> table_;
  const Origins& origins_;
  const std::string& file_;
};

}  // namespace firn
