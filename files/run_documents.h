// ProvenanceDocument and ResultDocument hold the JSON documents of a run folder, read with every type
// checked.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace firn {

/// provenance.json. Keys that an older program did not write are empty.
struct ProvenanceDocument {
  std::optional<std::int64_t> run_id;
  std::vector<std::pair<std::string, std::string>>
      texts;  ///< keys with a text, a number or an object, as text
  std::vector<std::string> command_line;
  bool has_inputs = false;
  std::vector<std::pair<std::string, std::string>> inputs;  ///< role, SHA-256

  std::string text(std::string_view key) const;  ///< "" = not there
};

/// result.json
struct ResultDocument {
  std::string outcome, reason;
  int status = 0, layers = 0;
};

/// @param name of the file, for errors
/// @throws std::invalid_argument naming file and byte, or file, key and what must stand there: no JSON, a
/// value of another type or beyond its limits, an input whose digest is not 64 hexadecimal digits
ProvenanceDocument parse_provenance(std::string_view text, const std::string& name);
/// @throws std::invalid_argument as above; all four keys are required
ResultDocument parse_result(std::string_view text, const std::string& name);

}  // namespace firn
