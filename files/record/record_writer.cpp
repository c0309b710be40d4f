#include <sys/uio.h>

#include <array>

#include "files/record/record_layout.h"

namespace firn::record {
namespace {

constexpr std::size_t kMaxParts = 14;

iovec io(const void* data, std::size_t bytes) { return {const_cast<void*>(data), bytes}; }

}  // namespace

RecordWriter::RecordWriter(const std::filesystem::path& path, Mode mode, std::size_t buffer_bytes)
    : file_(path, mode), buffer_bytes_(buffer_bytes) {
  if (mode == Mode::kAppend && file_.position() > 0) {
    const MappedFile mapped(path);
    const auto bytes = mapped.bytes();
    RecordReader reader(bytes);
    while (reader.next()) {
    }
    const std::uint64_t end = reader.valid_end();
    const bool cut_header =
        bytes.size() < kFileHeader.size() && std::memcmp(bytes.data(), kFileHeader.data(), bytes.size()) == 0;
    if (end == 0 && !cut_header)
      throw std::runtime_error(path.string() + ": byte 0: not a record file of Firn");
    if (end < bytes.size()) {
      torn_path_ = save_torn_tail(path, bytes.subspan(end));
      file_.truncate(end);
    }
    next_index_ = reader.valid_next_index();
  }
  if (file_.position() == 0) {
    iovec header = io(kFileHeader.data(), kFileHeader.size());
    file_.write({&header, 1});
  }
}

RecordWriter::~RecordWriter() {
  try {
    flush();
  } catch (const std::exception&) {
  }
}

std::uint64_t RecordWriter::append(std::uint16_t kind, std::span<const std::span<const std::byte>> parts) {
  if (parts.size() > kMaxParts)
    throw std::invalid_argument(path().string() + ": a record has at most " + std::to_string(kMaxParts) +
                                " parts, not " + std::to_string(parts.size()));
  std::size_t length = 0;
  for (const auto& part : parts) length += part.size();
  if (length > kMaxRecordPayloadBytes)
    throw std::invalid_argument(path().string() + ": a record has at most " +
                                std::to_string(kMaxRecordPayloadBytes) + " bytes, not " +
                                std::to_string(length));

  RecordLayout header{kSyncMarker, kind, 0, std::uint32_t(length), next_index_, 0};
  header.check = header.expected_check();
  header.checksum = checksum64(header.covered(), parts);

  static constexpr std::array<unsigned char, 8> kZeros{};
  std::array<iovec, kMaxParts + 2> out;
  std::size_t n = 0;
  out[n++] = io(&header, sizeof header);
  for (const auto& part : parts) out[n++] = io(part.data(), part.size());
  out[n++] = io(kZeros.data(), padded(length) - length);

  if (buffer_bytes_ == 0) {
    write({out.data(), n});
    return next_index_++;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const auto* from = static_cast<const std::byte*>(out[i].iov_base);
    buffer_.insert(buffer_.end(), from, from + out[i].iov_len);
  }
  ++next_index_;
  if (buffer_.size() >= buffer_bytes_) flush();
  return next_index_ - 1;
}

void RecordWriter::write(std::span<iovec> parts) {
  const std::uint64_t start = file_.position();
  try {
    file_.write(parts);
  } catch (const FileError&) {
    if (file_.position() != start) file_.truncate(start);  // no half record stays behind
    throw;
  }
}

void RecordWriter::flush() {
  if (buffer_.empty()) return;
  iovec all = io(buffer_.data(), buffer_.size());
  write({&all, 1});
  buffer_.clear();
}

}  // namespace firn::record
