// RunReader reads the messages of a run, each once, as today's types: of a run that is over or crashed all at
// once, of one that prints as its files grow, in order of time. It takes no part in the print: it sends
// nothing and holds no lock. In memory are places of messages, of a poll its own alone; the messages stay in
// mapped files, whose pages are given back once they are read.
#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "files/record/file.h"
#include "lcmtypes/channels.h"
#include "runs/migrate/run_migration.h"
#include "runs/read/channel_index.h"

namespace firn::runs {

/// Holds the place of a message in the plain bytes of a file that its reader reads.
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

class RunReader {
 public:
  using Channels = std::set<std::string, std::less<>>;
  using Sink = std::function<void(std::string_view channel, std::span<const std::byte> message, Place place)>;

  enum class Source {
    /// The write-ahead files of the nodes that publish the wanted channels, as far as they have grown.
    kFiles,
    /// log.lcm, or the write-ahead files if the log cannot stand for them (whole_log.h).
    kLog,
  };

  /// @param run folder of a run; files that do not exist yet are read once they do
  /// @param wanted channels; others are passed over. None: instruments' files alone are read, for exchanges
  RunReader(std::filesystem::path run, Channels wanted, Source source = Source::kFiles);

  /// Reads all messages of the write-ahead files, sent and delivered ones, so that none is missing where a
  /// kill cut a file, and compares delivered ones with the file of their sender. on(), each(), starts(),
  /// damage() and forged() are of such a reader. @throws UsageError: no run folder; record::FileError
  explicit RunReader(const std::filesystem::path& run);
  ~RunReader();
  RunReader(const RunReader&) = delete;
  RunReader& operator=(const RunReader&) = delete;

  /// Returns true if the log is read.
  bool reads_log() const { return reads_log_; }

  /// Hands over the messages that came since the last call, in order of their time; of one node in its order.
  /// Damaged records, messages beyond their limits and the torn end of a file are passed over. @returns true
  /// if any file has grown
  bool poll(const Sink& sink);

  /// Returns a message of today's type. @throws record::FileError; empty: the file has been cut
  std::vector<std::byte> read(const Place& place);

  /// Returns the last exchange of each instrument since the last call.
  std::vector<Exchange> take_exchanges();

  /// Returns the configuration that the nodes began with, of the log; empty: it is not read or holds none.
  const std::string& config() const { return config_; }

  /// Returns the messages of a channel in the order of (incarnation, seq).
  const std::vector<std::span<const std::byte>>& on(std::string_view channel) const;

  /// Calls `use` with each decoded message of a channel.
  template <class Message, class Use>
  void each(std::string_view channel, Use use) const {
    for (const auto bytes : on(channel)) {
      Message m{};  // a new one: LCM does not clear an array that is empty in the message
      if (m.decode(bytes.data(), 0, int(bytes.size())) == int(bytes.size()))
        use(static_cast<const Message&>(m));
    }
  }

  /// Returns the times of the start events, one for each incarnation, by the node that started first [us].
  const std::vector<std::int64_t>& starts() const { return starts_; }
  /// Returns a line for each damaged place: "nodes/jet.wal, byte 12: checksum does not hold".
  const std::vector<std::string>& damage() const { return damage_; }
  /// Returns a line for each message that a node received and its publisher did not send: "LAYER_PLAN 5 of
  /// incarnation 0, received by stage: controller sent other bytes". Every publisher counts whose file is
  /// there.
  const std::vector<std::string>& forged() const { return forged_; }

 private:
  struct File {
    std::string name;  // relative to the run
    bool driver = false;
    struct ::stat seen {};
    std::unique_ptr<record::MappedFile> map;
    std::uint64_t from = 0, index = 0;  // of the next record
    std::string sent, received;         // of the instrument
    bool exchanged = false;
    std::vector<std::int64_t> starts;  // by incarnation
    std::vector<std::string> damage;

    std::string node() const { return std::filesystem::path(name).stem().string(); }
  };
  enum class Copy : std::uint8_t {
    kSent,
    kReceived,
    kDoubtful,  // of a damaged record
  };
  struct Found {
    Stamp stamp;
    std::size_t rank = 0;  // among messages of one time: the publisher's, or the file's
    const ChannelInfo* channel = nullptr;
    std::span<const std::byte> message;
    std::size_t file = 0;
    Copy copy = Copy::kSent;
  };
  using Key = std::tuple<const ChannelInfo*, std::int32_t, std::int64_t>;  // channel, incarnation, seq
  static Key key_of(const Found& f) { return {f.channel, f.stamp.incarnation, f.stamp.seq}; }
  class Scan;
  class PagesBehind;
  bool open_log();
  void name_files();
  bool folder_changed();
  bool changed(File& file) const;
  void map(File& file);
  bool find_new(std::vector<Found>& found);
  void take_all();
  void forget_files() const;
  void compare_received(const std::vector<Found>& found, const std::vector<const Found*>& best);

  std::filesystem::path run_;
  Channels wanted_;
  RunMigration migration_;
  bool reads_log_ = false, reads_all_ = false;
  std::string config_;
  std::vector<File> files_;
  std::vector<Found> logged_;  // until the first poll
  int folder_ = -1;            // RUN/nodes
  timespec folder_time_{};
  std::vector<std::vector<std::span<const std::byte>>> by_channel_;  // as of channel_table()
  std::deque<std::vector<std::byte>> migrated_;
  std::vector<std::int64_t> starts_;
  std::vector<std::string> damage_, forged_;
};

}  // namespace firn::runs
