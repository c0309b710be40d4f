#include "files/path/layer_file.h"

namespace firn {

namespace fs = std::filesystem;
using record::Record;
using slice::LayerPaths;

namespace {

// Decoders report bytes of their payload; errors of a file name bytes of the file.
template <class Decode>
auto decoded(const Record& r, const Decode& decode) {
  try {
    return decode();
  } catch (const FormatError& e) {
    throw FormatError(r.offset + record::kRecordHeaderBytes + e.offset, e.problem);
  }
}

}  // namespace

LayerWriter::LayerWriter(const fs::path& file, const slice::PathFileHead& head) : out_(file) {
  out_.records().append(std::uint16_t(PathRecord::kHead), slice::encode(head));
}

void LayerWriter::add(std::span<const std::byte> encoded, const LayerPaths& layer,
                      const std::vector<slice::MaterialUse>& use) {
  out_.records().append(std::uint16_t(PathRecord::kLayer), encoded);
  ++totals_.layers;
  totals_.paths += std::int64_t(layer.lines.size());
  totals_.points += std::int64_t(layer.lines.points.size());
  if (use.size() > totals_.use.size()) totals_.use.resize(use.size());
  for (std::size_t m = 0; m < use.size(); ++m) {
    totals_.use[m].length_mm += use[m].length_mm;
    totals_.use[m].volume_mm3 += use[m].volume_mm3;
  }
}

void LayerWriter::finish() {
  out_.records().append(std::uint16_t(PathRecord::kTotals), slice::encode(totals_));
  out_.finish();
}

LayerReader::LayerReader(const fs::path& file) : mapped_(file), bytes_(mapped_->bytes()) { begin(); }

LayerReader::LayerReader(std::span<const std::byte> bytes) : bytes_(bytes) { begin(); }

void LayerReader::begin() {
  in_.emplace(bytes_);
  const auto first = record();
  if (!first || PathRecord(first->kind) != PathRecord::kHead)
    throw FormatError(0, "is no path file: it has no head");
  head_ = decoded(*first, [&] { return slice::decode_path_head(first->payload); });
}

// Damage anywhere makes the file unfit to print by: nothing is read past it.
std::optional<Record> LayerReader::record() {
  auto r = in_->next();
  if (in_->damage().count() > 0) {
    const record::Damage& first = in_->damage().list().front();
    throw FormatError(first.offset, "the file is damaged: " + std::string(first.reason));
  }
  return r;
}

double LayerReader::fraction() const {
  return bytes_.empty() ? 1.0 : double(in_->valid_end()) / double(bytes_.size());
}

void LayerReader::finish(const Record& r) {
  const slice::PathFileTotals totals = decoded(r, [&] { return slice::decode_path_totals(r.payload); });
  if (totals.layers != seen_.layers || totals.paths != seen_.paths || totals.points != seen_.points)
    throw FormatError(r.offset, "the totals differ from the layers before them");
  if (record()) throw FormatError(r.offset, "records behind the totals");
  seen_.use = totals.use;
  ended_ = true;
}

std::optional<LayerPaths> LayerReader::next() {
  if (ended_) return std::nullopt;
  const auto r = record();
  if (!r) throw FormatError(in_->valid_end(), "the file is incomplete: it has no totals");
  if (PathRecord(r->kind) == PathRecord::kTotals) {
    finish(*r);
    return std::nullopt;
  }
  if (PathRecord(r->kind) != PathRecord::kLayer)
    throw FormatError(r->offset, "a record of the unknown kind " + std::to_string(r->kind));
  LayerPaths layer = decoded(*r, [&] { return slice::decode_layer_paths(r->payload, head_); });
  if (layer.layer <= last_layer_)
    throw FormatError(
        r->offset, "layer " + std::to_string(layer.layer) + " behind layer " + std::to_string(last_layer_));
  last_layer_ = layer.layer;
  ++seen_.layers;
  seen_.paths += std::int64_t(layer.lines.size());
  seen_.points += std::int64_t(layer.lines.points.size());
  return layer;
}

}  // namespace firn
