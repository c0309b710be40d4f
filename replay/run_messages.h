// RunMessages holds every message of a run, once, from all of its write-ahead files. It reads sent and
// delivered messages, so that no message is missing where a kill cut a file. Messages of earlier versions are
// held as today's types.
#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
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
  /// Returns a line for each message that a node received and its publisher did not send: "LAYER_PLAN 5 of
  /// incarnation 0, received by stage: controller sent other bytes". Every publisher counts whose file is
  /// there.
  const std::vector<std::string>& forged() const { return forged_; }

 private:
  using Key = std::pair<std::int32_t, std::int64_t>;  // incarnation, seq
  struct Found {
    std::span<const std::byte> bytes;
    bool sent = false;  // as the publisher's file has it, not only a receiver's
  };
  struct Received {
    int channel = 0;
    Key key;
    std::span<const std::byte> bytes;
    std::string_view by;
  };

  void read(WalFile& file, const std::string& name, std::string_view node);
  void keep_sent(std::string_view channel, std::span<const std::byte> bytes);
  /// @param by node that received it; empty: from a damaged record, nothing to compare
  void keep_received(std::string_view channel, std::span<const std::byte> bytes, std::string_view by);
  bool may_lack(const ChannelInfo& channel) const;  ///< the publisher's file, a message that was sent
  void compare_received();

  ChannelIndex channels_;
  std::vector<std::unique_ptr<WalFile>> files_;  // keep the bytes
  std::vector<std::map<Key, Found>> found_;
  std::vector<Received> received_;  // of channels that nodes, launcher or recorder publish
  std::vector<std::vector<std::span<const std::byte>>> by_channel_;
  std::deque<std::vector<std::byte>> migrated_;
  std::vector<std::int64_t> starts_;
  std::vector<std::string> damage_, forged_;
  std::set<std::string_view> senders_, damaged_senders_;  // whose file was read; and has lost something
};

}  // namespace firn::replay
