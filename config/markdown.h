// configuration_markdown returns the text of docs/configuration.md, from the table of fields.
#pragma once

#include <string>

namespace firn {

std::string configuration_markdown();

}  // namespace firn
