// RecordTail reads the messages that the nodes of a run have sent, from their write-ahead files, and goes on
// where these files have grown. It takes no part in the print: it sends nothing and holds no lock.
#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "files/record/file.h"
#include "replay/run_migration.h"

namespace firn::page {

/// Holds the place of a message in the plain bytes of a write-ahead file.
struct Place {
  std::size_t file = 0;
  std::uint64_t at = 0;
  std::uint32_t bytes = 0;
};

/// Holds the last bytes that crossed an instrument's port, as text with escapes.
struct Exchange {
  std::string node;
  std::string sent, received;

  std::string words() const;
};

class RecordTail {
 public:
  using Sink = std::function<void(std::string_view channel, std::span<const std::byte> message, Place place)>;

  /// @param run folder of a run; files that do not exist yet are read once they do
  /// @param wanted channels; others are passed over. None: instruments' files alone are read, for exchanges
  RecordTail(std::filesystem::path run, std::set<std::string, std::less<>> wanted);
  ~RecordTail();
  RecordTail(const RecordTail&) = delete;
  RecordTail& operator=(const RecordTail&) = delete;

  /// Hands over the messages that came since the last call, in order of their time; of one node in its order.
  /// Damaged records, messages beyond their limits and the torn end of a file are passed over. @returns true
  /// if any file has grown
  bool poll(const Sink& sink);

  /// Returns a message of today's type. @throws logfile::FileError; empty: the file has been cut
  std::vector<std::byte> read(const Place& place);

  /// Returns the last exchange of each instrument since the last call.
  std::vector<Exchange> take_exchanges();

 private:
  struct File {
    std::string name;  // relative to the run
    bool driver = false;
    struct ::stat seen {};
    std::unique_ptr<logfile::MappedFile> map;
    std::uint64_t from = 0, index = 0;  // of the next record
    std::string sent, received;         // of the instrument
    bool exchanged = false;
  };
  struct Found;
  bool folder_changed();
  bool changed(File& file) const;
  void map(File& file);
  void read_new(std::size_t number, std::vector<Found>& found);

  std::filesystem::path run_;
  std::set<std::string, std::less<>> wanted_;
  replay::RunMigration migration_;
  std::vector<File> files_;
  int folder_ = -1;  // RUN/nodes
  timespec folder_time_{};
};

}  // namespace firn::page
