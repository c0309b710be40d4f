// write_generated writes a document that a command generates.
#pragma once

#include <string>

namespace firn {

/// Writes a generated document to `output` ("-" = stdout) and says so on stderr; with `json`, {"written": …}
/// or the document as a JSON string goes to stdout.
void write_generated(const std::string& output, const std::string& text, bool json);

}  // namespace firn
