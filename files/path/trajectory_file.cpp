#include "files/path/trajectory_file.h"

namespace firn {

namespace fs = std::filesystem;
using record::Record;

TrajectoryWriter::TrajectoryWriter(const fs::path& file, const TrajectoryHead& head) : out_(file) {
  out_.records().append(std::uint16_t(TrajectoryRecord::kHead), encode(head));
}

void TrajectoryWriter::add(std::span<const std::byte> encoded, std::size_t samples, double duration_s) {
  out_.records().append(std::uint16_t(TrajectoryRecord::kPath), encoded);
  ++totals_.paths;
  totals_.samples += std::int64_t(samples);
  totals_.duration_s += duration_s;
}

void TrajectoryWriter::finish() {
  out_.records().append(std::uint16_t(TrajectoryRecord::kTotals), encode(totals_));
  out_.finish();
}

TrajectoryReader::TrajectoryReader(const fs::path& file) : mapped_(file) {
  in_.emplace(mapped_->bytes());
  begin();
}

TrajectoryReader::TrajectoryReader(std::span<const std::byte> bytes) : in_(bytes) { begin(); }

void TrajectoryReader::begin() {
  const auto first = record();
  if (!first || TrajectoryRecord(first->kind) != TrajectoryRecord::kHead)
    throw TrajectoryFormatError(0, "is no trajectory file: it has no head");
  head_ = decode_trajectory_head(first->payload);
}

// Damage anywhere makes the file unfit to move a machine by: nothing is read past it.
std::optional<Record> TrajectoryReader::record() {
  auto r = in_->next();
  if (in_->damage().count() > 0) {
    const record::Damage& first = in_->damage().list().front();
    throw TrajectoryFormatError(first.offset, "the file is damaged: " + std::string(first.reason));
  }
  return r;
}

std::optional<PlannedPath> TrajectoryReader::next() {
  if (ended_) return std::nullopt;
  const auto r = record();
  if (!r) throw TrajectoryFormatError(in_->valid_end(), "the file is incomplete: it has no totals");
  const auto place = [&](const TrajectoryFormatError& e) {
    return TrajectoryFormatError(r->offset + record::kRecordHeaderBytes + e.offset, e.problem);
  };
  switch (TrajectoryRecord(r->kind)) {
    case TrajectoryRecord::kPath:
      try {
        PlannedPath path = decode_trajectory(r->payload, head_);
        ++seen_.paths;
        seen_.samples += std::int64_t(path.trajectory.samples());
        seen_.duration_s += path.trajectory.certificate.duration_s;
        return path;
      } catch (const TrajectoryFormatError& e) {
        throw place(e);
      }
    case TrajectoryRecord::kTotals: {
      const TrajectoryTotals totals = decode_trajectory_totals(r->payload);
      if (!(totals == seen_))
        throw TrajectoryFormatError(r->offset, "the totals differ from the trajectories before them");
      if (record()) throw TrajectoryFormatError(r->offset, "records behind the totals");
      ended_ = true;
      return std::nullopt;
    }
    default:
      throw TrajectoryFormatError(r->offset, "a record of the unknown kind " + std::to_string(r->kind));
  }
}

}  // namespace firn
