#include "plant/world/kept_world.h"

#include <array>
#include <cstring>
#include <stdexcept>

#include "files/record/record_file.h"
#include "files/run_paths.h"

namespace firn::plant {
namespace {

constexpr std::uint64_t kLongJournal_bytes = 8 << 20;

enum Kind : std::uint16_t { kHead = 1, kConnect = 2, kDisconnect = 3, kBytes = 4, kFault = 5, kAdvance = 6 };

/// Ties a journal to the state that it follows and to the place of the record at that time.
struct Head {
  std::uint64_t state_sum = 0;  ///< last 8 bytes of the state's file; 0: a new world
  std::uint64_t record_bytes = 0;
};
struct Input {
  std::int64_t now_us = 0;
  std::uint64_t port = 0;  ///< index in World::ports()
};
struct Fault {
  std::int64_t count = 0, delay_us = 0;
  std::uint64_t kind = 0;
};

template <class T>
std::span<const std::byte> bytes_of(const T& value) {
  return std::as_bytes(std::span(&value, 1));
}

template <class T>
T take(std::span<const std::byte> payload, std::size_t at, const std::filesystem::path& path) {
  T value;
  if (payload.size() < at + sizeof value)
    throw std::runtime_error("world inputs: " + path.string() + " has a record that is cut short");
  std::memcpy(&value, payload.data() + at, sizeof value);
  return value;
}

std::uint64_t sum_of(const std::filesystem::path& state) {
  std::uint64_t sum = 0;
  if (!std::filesystem::exists(state)) return 0;
  const record::MappedFile file(state);
  if (file.bytes().size() >= sizeof sum)
    std::memcpy(&sum, file.bytes().data() + file.bytes().size() - sizeof sum, sizeof sum);
  return sum;
}

}  // namespace

/// Passes events on to the file, except while they are computed a second time.
class KeptWorld::Record : public WorldRecord {
 public:
  explicit Record(const std::filesystem::path& path) : file_(make_record_file(path)) {}
  void append(RecordKind kind, std::span<const std::byte> payload) override {
    if (silent) return;
    if (skip > 0) {
      --skip;
      return;
    }
    file_->append(kind, payload);
  }
  void flush() override { file_->flush(); }

  bool silent = false;
  std::uint64_t skip = 0;  ///< events that the file holds already

 private:
  std::unique_ptr<WorldRecord> file_;
};

KeptWorld::KeptWorld(const std::filesystem::path& run, const WorldConfig& config)
    : state_(RunPaths(run).world_state_path()),
      journal_path_(RunPaths(run).world_journal_path()),
      record_path_(RunPaths(run).world_record_path()),
      record_(std::make_unique<Record>(record_path_)),
      lost_power_(std::filesystem::exists(journal_path_)),
      world_(open(config)) {
  std::filesystem::create_directories(state_.parent_path());
  if (lost_power_) {
    give_again(world_);
    world_.lose_power();
    save();
  } else {
    saved_exposures_ = world_.exposures();
    begin_journal();
  }
}

KeptWorld::~KeptWorld() = default;

World KeptWorld::open(const WorldConfig& config) {
  record_->silent = lost_power_;  // it goes on where the inputs end, not at the state
  World world = std::filesystem::exists(state_) ? World::restore(state_, config, record_.get(), lost_power_)
                                                : World(config, record_.get());
  record_->silent = false;
  return world;
}

// A journal of an older state is left over when the kill came between the new state and its journal.
void KeptWorld::give_again(World& world) {
  const record::MappedFile mapped(journal_path_);
  record::RecordReader reader(mapped.bytes());
  const auto first = reader.next();
  if (!first || first->damaged || first->kind != kHead) return;
  const Head head = take<Head>(first->payload, 0, journal_path_);
  if (head.state_sum != sum_of(state_)) return;
  record_->skip = count_events(record_path_, head.record_bytes);
  while (const auto r = reader.next()) {
    if (r->damaged) break;
    const Input in = take<Input>(r->payload, 0, journal_path_);
    if (r->kind == kAdvance) {
      world.advance(in.now_us, [](const World::Sent&) {});
      continue;
    }
    if (in.port >= world.ports().size())
      throw std::runtime_error("world inputs: " + journal_path_.string() + " names port " +
                               std::to_string(in.port));
    const std::string_view port = world.ports()[in.port];
    if (r->kind == kConnect) world.connect(port, in.now_us);
    if (r->kind == kDisconnect) world.disconnect(port, in.now_us);
    if (r->kind == kBytes) world.receive(port, r->payload.subspan(sizeof in), in.now_us);
    if (r->kind == kFault) {
      const Fault f = take<Fault>(r->payload, sizeof in, journal_path_);
      world.inject({std::string(port), FaultKind(f.kind), f.count, f.delay_us}, in.now_us);
    }
  }
  record_->skip = 0;
}

void KeptWorld::begin_journal() {
  journal_.reset();
  std::filesystem::remove(journal_path_);
  record_->flush();
  journal_ = std::make_unique<record::RecordWriter>(journal_path_, record::RecordWriter::Mode::kCreate);
  const Head head{sum_of(state_), std::filesystem::file_size(record_path_)};
  journal_->append(kHead, bytes_of(head));
}

void KeptWorld::save() {
  world_.save(state_);
  saved_exposures_ = world_.exposures();
  begin_journal();
}

void KeptWorld::save_if_due() {
  if (world_.exposures() != saved_exposures_ || journal_->bytes() > kLongJournal_bytes) save();
}

Truth KeptWorld::tell_truth(std::int64_t now_us) {
  Truth truth = world_.truth();
  const std::vector<float> height(truth.height.cells.begin(), truth.height.cells.end());
  const TruthRecord r{now_us, truth_digest(std::int32_t(truth.exposures), truth.droplets_fired,
                                           truth.volume_mm3, truth.height.spec, height)};
  record_->append(RecordKind::kTruth, std::as_bytes(std::span(&r, 1)));
  return truth;
}

void KeptWorld::flush_record() { record_->flush(); }

void KeptWorld::close() {
  world_.save(state_);
  journal_.reset();
  std::filesystem::remove(journal_path_);
}

void KeptWorld::note(std::uint16_t kind, std::string_view port, std::int64_t now_us,
                     std::span<const std::byte> rest) {
  Input in{now_us, 0};
  while (!port.empty() && in.port < world_.ports().size() && world_.ports()[in.port] != port) ++in.port;
  if (in.port == world_.ports().size()) return;  // the world refuses it
  const std::array<std::span<const std::byte>, 2> parts{bytes_of(in), rest};
  journal_->append(kind, parts);
}

void KeptWorld::connect(std::string_view port, std::int64_t now_us) {
  note(kConnect, port, now_us, {});
  world_.connect(port, now_us);
}

void KeptWorld::disconnect(std::string_view port, std::int64_t now_us) {
  note(kDisconnect, port, now_us, {});
  world_.disconnect(port, now_us);
}

void KeptWorld::receive(std::string_view port, std::span<const std::byte> bytes, std::int64_t now_us) {
  note(kBytes, port, now_us, bytes);
  world_.receive(port, bytes, now_us);
}

void KeptWorld::inject(const SimFault& fault, std::int64_t now_us) {
  const Fault f{fault.count, fault.delay_us, std::uint64_t(fault.kind)};
  note(kFault, fault.port, now_us, bytes_of(f));
  world_.inject(fault, now_us);
}

void KeptWorld::advance(std::int64_t now_us, const World::SendFn& send) {
  note(kAdvance, {}, now_us, {});
  world_.advance(now_us, send);
}

}  // namespace firn::plant
