#include "runtime/node.h"

#include <stdexcept>

namespace firn {

const Blob& blob(const Blobs& blobs, std::string_view role) {
  for (const Blob& b : blobs)
    if (b.role == role) return b;
  throw std::invalid_argument("the run has no input '" + std::string(role) + "'");
}

std::string without_plant(const std::string& config_toml) {
  std::string kept;
  bool plant = false;
  for (std::size_t at = 0; at < config_toml.size();) {
    const std::size_t end = std::min(config_toml.find('\n', at), config_toml.size() - 1) + 1;
    const std::string_view line = std::string_view(config_toml).substr(at, end - at);
    if (line.starts_with('[')) plant = line.starts_with("[plant]") || line.starts_with("[plant.");
    if (!plant && !line.starts_with("plant.")) kept += line;
    at = end;
  }
  return kept;
}

}  // namespace firn
