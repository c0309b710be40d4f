// RunMessages holds the messages of some channels of a run that nobody prints, each once, as today's types:
// from its log where that can stand for the write-ahead files (whole_log.h), else from these.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runs/read/run_reader.h"
#include "runs/read/whole_log.h"

namespace firn::runs {

class RunMessages {
 public:
  using Channels = std::set<std::string, std::less<>>;

  /// @throws UsageError: no run folder; record::FileError
  RunMessages(const std::filesystem::path& run, const Channels& wanted);

  /// Returns true if the log is read, of which the messages' places are in memory alone.
  bool reads_log() const { return log_.has_value(); }

  /// Returns the messages of a channel in the order of (incarnation, seq). @throws std::logic_error: the
  /// channel is none of the wanted ones
  const std::vector<std::span<const std::byte>>& on(std::string_view channel) const;

  /// Calls `use` with each decoded message of a channel. @throws as on()
  template <class Message, class Use>
  void each(std::string_view channel, Use use) const {
    Passed passed(*this);
    for (const auto bytes : on(channel)) {
      Message m{};  // a new one: LCM does not clear an array that is empty in the message
      if (m.decode(bytes.data(), 0, int(bytes.size())) == int(bytes.size()))
        use(static_cast<const Message&>(m));
      passed.message(bytes);
    }
  }

  /// Returns the number of incarnations that began.
  int incarnations() const;

 private:
  // Gives the log's pages back that lie behind.
  class Passed {
   public:
    explicit Passed(const RunMessages& of) : file_(of.log_ ? &of.log_->file : nullptr) {}
    void message(std::span<const std::byte> bytes);

   private:
    const record::MappedFile* file_;
    std::uint64_t from_ = 0;
  };

  Channels wanted_;
  std::optional<WholeLog> log_;
  std::vector<std::vector<std::span<const std::byte>>> by_channel_;  // as of channel_table()
  std::unique_ptr<RunReader> files_;
};

}  // namespace firn::runs
