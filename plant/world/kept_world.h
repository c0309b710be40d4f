// KeptWorld holds a world on the disk so that kill -9 loses nothing that an instrument has told a host: the
// last saved state (RUN/world/state) and a journal of the inputs since then (RUN/world/inputs). An input is
// in the journal before the world computes it. After a kill the inputs are given again, which puts droplets,
// counters and times where they were, and then every instrument loses its power: what it holds only in memory
// is gone, its boot count has changed. A world that was closed in order goes on with its instruments as they
// were.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "plant/world/world.h"

namespace firn::record {
class RecordWriter;
}

namespace firn::plant {

class KeptWorld {
 public:
  /// Opens the world of a run folder, or begins it. Record: RUN/world.rec, in which each event stands once,
  /// whenever the kill came.
  /// @throws std::runtime_error: state damaged or of another configuration; as record::RecordWriter
  KeptWorld(const std::filesystem::path& run, const WorldConfig& config);
  ~KeptWorld();

  /// As World's.
  void connect(std::string_view port, std::int64_t now_us);
  void disconnect(std::string_view port, std::int64_t now_us);
  void receive(std::string_view port, std::span<const std::byte> bytes, std::int64_t now_us);
  void inject(const SimFault& fault, std::int64_t now_us);
  void advance(std::int64_t now_us, const World::SendFn& send);

  const World& world() const { return world_; }
  /// Returns the truth, and records its digest: the log's SIM_TRUTH is held against it.
  Truth tell_truth(std::int64_t now_us);
  bool lost_power() const { return lost_power_; }  ///< it was killed before
  void flush_record();

  /// Saves after each exposure or firing, and when the journal has grown long.
  void save_if_due();
  /// Saves and ends the journal: the next opening is no loss of power. No input may follow.
  void close();

 private:
  class Record;
  World open(const WorldConfig& config);
  void give_again(World& world);
  void save();
  void begin_journal();
  void note(std::uint16_t kind, std::string_view port, std::int64_t now_us, std::span<const std::byte> rest);

  std::filesystem::path state_, journal_path_, record_path_;
  std::unique_ptr<Record> record_;
  bool lost_power_ = false;
  World world_;
  std::uint32_t saved_exposures_ = 0;
  std::unique_ptr<record::RecordWriter> journal_;
};

}  // namespace firn::plant
