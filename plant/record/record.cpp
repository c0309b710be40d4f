#include "plant/record/record.h"

#include <array>
#include <cstring>

#include "files/digest.h"
#include "files/record/record_file.h"

namespace firn::plant {
namespace {

using record::RecordReader;
using record::RecordWriter;

static_assert(sizeof(BeginRecord) == 24 && sizeof(ShotRecord) == 64 && sizeof(ScanRecord) == 24 &&
              sizeof(LampRecord) == 24 && sizeof(LinkRecord) == 16 && sizeof(DeviceRecord) == 24 &&
              sizeof(FiringRecord) == 56 && sizeof(TruthRecord) == 40);

class RecordFile : public WorldRecord {
 public:
  explicit RecordFile(const std::filesystem::path& path)
      : writer_(path,
                std::filesystem::exists(path) ? RecordWriter::Mode::kAppend : RecordWriter::Mode::kCreate) {}

  void append(RecordKind kind, std::span<const std::byte> payload) override {
    if (kind == RecordKind::kShot && payload.size() == sizeof(ShotRecord)) {
      std::memcpy(&shots_[count_++], payload.data(), payload.size());
      if (count_ == shots_.size()) flush();
      return;
    }
    flush();
    writer_.append(std::uint16_t(kind), payload);
  }
  void flush() override {
    if (count_ == 0) return;
    writer_.append(std::uint16_t(RecordKind::kShots), std::as_bytes(std::span(shots_).first(count_)));
    count_ = 0;
  }
  ~RecordFile() override {
    try {
      flush();
    } catch (const std::exception&) {  // a full disk was reported by an earlier append or flush
    }
  }

 private:
  RecordWriter writer_;
  std::array<ShotRecord, 256> shots_{};
  std::size_t count_ = 0;
};

template <class T>
bool take(std::span<const std::byte> payload, std::vector<T>& into) {
  if (payload.size() != sizeof(T)) return false;
  std::memcpy(&into.emplace_back(), payload.data(), sizeof(T));
  return true;
}

}  // namespace

std::array<std::byte, 32> truth_digest(std::int32_t layer, std::int64_t droplets, double volume_mm3,
                                       const GridSpec& grid, std::span<const float> height_mm) {
  Sha256 digest;
  const auto add = [&](const auto& value) { digest.add(std::as_bytes(std::span(&value, 1))); };
  add(layer);
  add(droplets);
  add(volume_mm3);
  add(std::int32_t(grid.nx));
  add(std::int32_t(grid.ny));
  for (const double v : {grid.pitch_x_mm, grid.pitch_y_mm, grid.origin_x_mm, grid.origin_y_mm}) add(v);
  digest.add(std::as_bytes(height_mm));
  return digest.bytes();
}

std::unique_ptr<WorldRecord> make_record_file(const std::filesystem::path& path) {
  return std::make_unique<RecordFile>(path);
}

bool decode(RecordKind kind, std::span<const std::byte> payload, WorldHistory& into) {
  switch (kind) {
    case RecordKind::kBegin:
      return take(payload, into.begins);
    case RecordKind::kShot:
      return take(payload, into.shots);
    case RecordKind::kScanTrigger:
      return take(payload, into.scans);
    case RecordKind::kLamp:
      return take(payload, into.lamp);
    case RecordKind::kLink:
      return take(payload, into.links);
    case RecordKind::kDevice:
      return take(payload, into.devices);
    case RecordKind::kFiring:
      return take(payload, into.firings);
    case RecordKind::kTruth:
      return take(payload, into.truths);
    case RecordKind::kShots: {
      if (payload.size() % sizeof(ShotRecord) != 0) return false;
      for (std::size_t at = 0; at < payload.size(); at += sizeof(ShotRecord))
        take(payload.subspan(at, sizeof(ShotRecord)), into.shots);
      return true;
    }
  }
  return false;
}

std::uint64_t count_events(const std::filesystem::path& path, std::uint64_t from) {
  const record::MappedFile file(path);
  RecordReader reader(file.bytes());
  std::uint64_t events = 0;
  while (const auto record = reader.next())
    if (!record->damaged && record->offset >= from && RecordKind(record->kind) != RecordKind::kTruth)
      events +=
          RecordKind(record->kind) == RecordKind::kShots ? record->payload.size() / sizeof(ShotRecord) : 1;
  return events;
}

WorldHistory read_history(const std::filesystem::path& path) {
  const record::MappedFile file(path);
  RecordReader reader(file.bytes());
  WorldHistory history;
  while (const auto record = reader.next()) {
    if (!record->damaged && !decode(RecordKind(record->kind), record->payload, history)) ++history.damaged;
    file.forget_before(record->offset);
  }
  history.damaged += reader.damage().count();
  return history;
}

}  // namespace firn::plant
