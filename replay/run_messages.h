// RunMessages holds every message of a run, once, from all of its write-ahead files. It reads sent and
// delivered messages, so that no message is missing where a kill cut a file. Messages of earlier versions are
// held as today's types.
#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "replay/channel_index.h"
#include "replay/wal_file.h"

namespace firn::replay {

class RunMessages {
 public:
  /// @throws std::invalid_argument for a folder without nodes/, logfile::FileError
  explicit RunMessages(const std::filesystem::path& run);

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
  const std::vector<std::string>& damage() const { return damage_; }

 private:
  using Key = std::pair<std::int32_t, std::int64_t>;  // incarnation, seq

  void read(WalFile& file, const std::string& name);
  void keep(std::string_view channel, std::span<const std::byte> bytes);

  ChannelIndex channels_;
  std::vector<std::unique_ptr<WalFile>> files_;  // keep the bytes
  std::vector<std::map<Key, std::span<const std::byte>>> found_;
  std::vector<std::vector<std::span<const std::byte>>> by_channel_;
  std::deque<std::vector<std::byte>> migrated_;
  std::vector<std::int64_t> starts_;
  std::vector<std::string> damage_;
};

}  // namespace firn::replay
