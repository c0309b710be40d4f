// McapExport writes runs as one .mcap file, which Foxglove and PlotJuggler open: each channel once as JSON
// with its JSON schema, and once as LCM's bytes with the .lcm text; maps and events once more by Foxglove's
// own schemas, so that its panels draw and list them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "files/record/event_log.h"
#include "files/record/part_file.h"
#include "report/export/mcap_writer.h"

namespace firn::report {

class McapExport {
 public:
  /// @throws WriteError, record::FileError
  explicit McapExport(const std::filesystem::path& file);
  ~McapExport();

  /// Topics are "/CHANNEL", "/lcm/CHANNEL", "/foxglove/CHANNEL" of maps and "/foxglove/LOG"; experiment,
  /// provenance and result are attachments.
  /// @param prefix of the topics, "" or "RUN/" @returns the number of messages @throws as each_message
  std::uint64_t add(const std::filesystem::path& run, const std::string& prefix,
                    const std::function<void(double)>& progress);
  void finish();  ///< the file takes its name. @throws WriteError

 private:
  void known(std::string_view schema, const std::string& topic, const record::Event& event,
             std::uint64_t time_ns, const std::string& json);

  std::filesystem::path target_;
  record::PartFile part_;
  McapWriter writer_;
  std::map<std::string, std::uint16_t> known_schemas_, known_topics_;  // of Foxglove, by their names
  bool finished_ = false;
};

}  // namespace firn::report
