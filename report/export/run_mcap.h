// McapExport writes runs as one .mcap file, which Foxglove and PlotJuggler open: each channel once as JSON
// with its JSON schema, and once as LCM's bytes with the .lcm text.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "files/record/part_file.h"
#include "report/export/mcap_writer.h"

namespace firn::report {

class McapExport {
 public:
  /// @throws WriteError, record::FileError
  explicit McapExport(const std::filesystem::path& file);
  ~McapExport();

  /// Topics are "/CHANNEL" and "/lcm/CHANNEL"; experiment, provenance and result are attachments.
  /// @param prefix of the topics, "" or "RUN/" @returns the number of messages @throws as each_message
  std::uint64_t add(const std::filesystem::path& run, const std::string& prefix,
                    const std::function<void(double)>& progress);
  void finish();  ///< the file takes its name. @throws WriteError

 private:
  std::filesystem::path target_;
  record::PartFile part_;
  McapWriter writer_;
  bool finished_ = false;
};

}  // namespace firn::report
