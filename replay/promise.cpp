#include "replay/promise.h"

namespace firn::replay {
namespace {

// "0.2" of "0.2.1".
std::string_view minor_of(std::string_view version) {
  const std::size_t first = version.find('.');
  return first == std::string_view::npos ? version : version.substr(0, version.find('.', first + 1));
}

}  // namespace

std::string beyond_promise(std::string_view recorded_version, std::string_view recorded_commit,
                           std::string_view version) {
  if (!recorded_version.empty() && minor_of(recorded_version) == minor_of(version)) return "";
  const std::string_view commit = recorded_commit.substr(0, recorded_commit.find("-dirty-"));
  std::string text = "version: recorded with ";
  text += recorded_version.empty() ? "a Firn before version 0.2" : "Firn " + std::string(recorded_version);
  text +=
      ", replayed with " + std::string(version) +
      "; equal bytes are promised within a minor version. The commit that recorded the run replays it: git "
      "checkout " +
      std::string(commit.empty() ? "COMMIT (the run names none)" : commit);
  if (commit.size() != recorded_commit.size()) text += " && git apply RUN/sources.diff";
  return text + " && ./firn replay RUN";
}

}  // namespace firn::replay
