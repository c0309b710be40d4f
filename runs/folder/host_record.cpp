#include "runs/folder/host_record.h"

#include <algorithm>
#include <stdexcept>

#include "config/hosts.h"
#include "files/json.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "lcmtypes/channels.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;
constexpr const char* kEnding = ".json";

// The name becomes a part of file names, the address a word for ssh, the nodes files that the host may send.
void check(const HostRecord& r, const fs::path& file) {
  const auto require = [&](bool good, const std::string& member, const std::string& value) {
    if (!good)
      throw std::runtime_error(file.string() + ": " + member + " '" + value.substr(0, 100) + "' is none");
  };
  require(is_host_name(r.name) && file.stem() == r.name, "name", r.name);
  require(is_host_address(r.address), "address", r.address);
  require(is_host_address(r.program), "program", r.program);
  for (const std::string& node : r.nodes) require(find_node(node) != nullptr, "node", node);
}

}  // namespace

void write_host_record(const fs::path& run, const HostRecord& r) {
  fs::create_directories(RunPaths(run).hosts_path());
  const nlohmann::ordered_json j{{"name", r.name},
                                 {"address", r.address},
                                 {"program", r.program},
                                 {"nodes", r.nodes},
                                 {"complete", r.complete}};
  write_file_atomically(RunPaths(run).hosts_path() / (r.name + kEnding), j.dump(2) + "\n");
}

std::vector<HostRecord> host_records(const fs::path& run) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(RunPaths(run).hosts_path(), none))
    if (entry.path().extension() == kEnding) files.push_back(entry.path());
  std::ranges::sort(files);
  std::vector<HostRecord> records;
  for (const fs::path& file : files) try {
      const auto j = nlohmann::json::parse(read_file(file));
      HostRecord r;
      j.at("name").get_to(r.name);
      j.at("address").get_to(r.address);
      j.at("program").get_to(r.program);
      j.at("nodes").get_to(r.nodes);
      j.at("complete").get_to(r.complete);
      check(r, file);
      records.push_back(std::move(r));
    } catch (const nlohmann::json::exception& e) {
      throw std::runtime_error(file.string() + ": " + e.what());
    }
  return records;
}

std::string incomplete_text(const fs::path& run) {
  std::string text;
  for (const HostRecord& r : host_records(run)) {
    if (r.complete) continue;
    std::string nodes;
    for (const std::string& node : r.nodes) nodes += (nodes.empty() ? "" : ", ") + node;
    text += (text.empty() ? "incomplete: host " : ", host ") + r.name + " (" + nodes + ")";
  }
  return text;
}

}  // namespace firn::runs
