#include "report/export/mcap_writer.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <tuple>
#include <utility>

#include "files/text_file.h"

namespace firn::report {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::size_t kChunk_bytes = 1 << 20;
constexpr int kLevel = 3;

enum Opcode : unsigned char {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0a,
  kStatistics = 0x0b,
  kSummaryOffset = 0x0e,
  kDataEnd = 0x0f,
};

// Little-endian content of one record.
class Content {
 public:
  Content& u16(std::uint64_t v) { return number(v, 2); }
  Content& u32(std::uint64_t v) { return number(v, 4); }
  Content& u64(std::uint64_t v) { return number(v, 8); }
  Content& text(std::string_view s) { return u32(s.size()).raw(s); }
  Content& raw(std::string_view s) {
    bytes_ += s;
    return *this;
  }
  const std::string& bytes() const { return bytes_; }
  std::string record(Opcode code) const {
    return Content().raw(std::string(1, char(code))).u64(bytes_.size()).raw(bytes_).bytes();
  }

 private:
  Content& number(std::uint64_t v, int n) {
    for (int k = 0; k < n; ++k) bytes_ += char(v >> (8 * k) & 255);
    return *this;
  }
  std::string bytes_;
};

// A message as its record, written where it stays: most bytes of a file are in these.
void append_message(std::string& to, std::uint16_t channel, std::uint32_t sequence, std::uint64_t time_ns,
                    std::string_view data) {
  constexpr std::size_t kHead_bytes = 2 + 4 + 8 + 8;
  std::array<char, 1 + 8 + kHead_bytes> head{char(kMessage)};
  std::size_t at = 1;
  const auto put = [&](std::uint64_t v, int bytes) {
    for (int k = 0; k < bytes; ++k) head[at++] = char(v >> (8 * k) & 255);
  };
  put(kHead_bytes + data.size(), 8);
  put(channel, 2);
  put(sequence, 4);
  put(time_ns, 8);
  put(time_ns, 8);
  to.append(head.data(), head.size()).append(data);
}

std::uint32_t checksum(std::string_view bytes) {
  return std::uint32_t(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& file)
    : path_(file), file_(std::fopen(file.c_str(), "wb")) {
  if (!file_) throw WriteError(file.string() + ": cannot be written: " + std::strerror(errno));
  write(kMagic);
  write(Content().text("").text("firn").record(kHeader));
}

McapWriter::~McapWriter() {
  if (file_) std::fclose(file_);
}

void McapWriter::write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size())
    throw WriteError(path_.string() + ": byte " + std::to_string(at_) + ": " + std::strerror(errno));
  at_ += bytes.size();
}

std::uint16_t McapWriter::add_schema(const std::string& name, const std::string& encoding,
                                     const std::string& data) {
  const auto id = std::uint16_t(schemas_.size() + 1);  // 0 means none
  schemas_.push_back(Content().u16(id).text(name).text(encoding).text(data).record(kSchema));
  chunk_ += schemas_.back();
  return id;
}

std::uint16_t McapWriter::add_channel(std::uint16_t schema, const std::string& topic,
                                      const std::string& encoding,
                                      const std::map<std::string, std::string>& metadata) {
  const auto id = std::uint16_t(channels_.size());
  Content pairs;
  for (const auto& [key, value] : metadata) pairs.text(key).text(value);
  channels_.push_back(
      Content().u16(id).u16(schema).text(topic).text(encoding).text(pairs.bytes()).record(kChannel));
  chunk_ += channels_.back();
  return id;
}

void McapWriter::message(std::uint16_t channel, std::uint32_t sequence, std::uint64_t time_ns,
                         std::string_view data) {
  if (chunk_messages_.empty()) chunk_first_ns_ = chunk_last_ns_ = time_ns;
  if (messages_ == 0) first_ns_ = last_ns_ = time_ns;
  chunk_first_ns_ = std::min(chunk_first_ns_, time_ns);
  chunk_last_ns_ = std::max(chunk_last_ns_, time_ns);
  first_ns_ = std::min(first_ns_, time_ns);
  last_ns_ = std::max(last_ns_, time_ns);
  chunk_messages_[channel].emplace_back(time_ns, chunk_.size());
  append_message(chunk_, channel, sequence, time_ns, data);
  ++messages_;
  ++counts_[channel];
  if (chunk_.size() >= kChunk_bytes) end_chunk();
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) return;
  std::string packed(ZSTD_compressBound(chunk_.size()), '\0');
  const std::size_t n = ZSTD_compress(packed.data(), packed.size(), chunk_.data(), chunk_.size(), kLevel);
  if (ZSTD_isError(n)) throw WriteError(path_.string() + ": zstd: " + ZSTD_getErrorName(n));
  packed.resize(n);
  ChunkIndex index{chunk_first_ns_, chunk_last_ns_, at_, 0, chunk_.size(), packed.size(), 0, {}};
  write(Content()
            .u64(chunk_first_ns_)
            .u64(chunk_last_ns_)
            .u64(chunk_.size())
            .u32(checksum(chunk_))
            .text("zstd")
            .u64(packed.size())
            .raw(packed)
            .record(kChunk));
  index.bytes = at_ - index.at;
  const std::uint64_t begin = at_;
  for (const auto& [channel, messages] : chunk_messages_) {
    index.indices[channel] = at_;
    Content places;
    for (const auto& [time_ns, place] : messages) places.u64(time_ns).u64(place);
    write(Content().u16(channel).text(places.bytes()).record(kMessageIndex));
  }
  index.index_bytes = at_ - begin;
  chunks_.push_back(std::move(index));
  chunk_.clear();
  chunk_messages_.clear();
  chunk_first_ns_ = chunk_last_ns_ = 0;
}

void McapWriter::attachment(const std::string& name, const std::string& media_type, std::string_view data) {
  const std::string content =
      Content().u64(0).u64(0).text(name).text(media_type).u64(data.size()).raw(data).bytes();
  AttachmentIndex index{at_, 0, data.size(), name, media_type};
  write(Content().raw(content).u32(checksum(content)).record(kAttachment));
  index.bytes = at_ - index.at;
  attachments_.push_back(std::move(index));
}

void McapWriter::close() {
  end_chunk();
  write(Content().u32(0).record(kDataEnd));
  const std::uint64_t summary = at_;
  std::vector<std::tuple<Opcode, std::uint64_t, std::uint64_t>> groups;
  std::uint64_t begin = at_;
  const auto end_group = [&](Opcode code) {
    if (at_ > begin) groups.emplace_back(code, begin, at_ - begin);
    begin = at_;
  };
  for (const std::string& record : schemas_) write(record);
  end_group(kSchema);
  for (const std::string& record : channels_) write(record);
  end_group(kChannel);
  Content counts;
  for (const auto& [channel, count] : counts_) counts.u16(channel).u64(count);
  write(Content()
            .u64(messages_)
            .u16(schemas_.size())
            .u32(channels_.size())
            .u32(attachments_.size())
            .u32(0)
            .u32(chunks_.size())
            .u64(first_ns_)
            .u64(last_ns_)
            .text(counts.bytes())
            .record(kStatistics));
  end_group(kStatistics);
  for (const ChunkIndex& c : chunks_) {
    Content indices;
    for (const auto& [channel, place] : c.indices) indices.u16(channel).u64(place);
    write(Content()
              .u64(c.first_ns)
              .u64(c.last_ns)
              .u64(c.at)
              .u64(c.bytes)
              .text(indices.bytes())
              .u64(c.index_bytes)
              .text("zstd")
              .u64(c.packed)
              .u64(c.plain)
              .record(kChunkIndex));
  }
  end_group(kChunkIndex);
  for (const AttachmentIndex& a : attachments_)
    write(Content()
              .u64(a.at)
              .u64(a.bytes)
              .u64(0)
              .u64(0)
              .u64(a.size)
              .text(a.name)
              .text(a.media_type)
              .record(kAttachmentIndex));
  end_group(kAttachmentIndex);
  const std::uint64_t offsets = at_;
  for (const auto& [code, from, size] : groups)
    write(Content().raw(std::string(1, char(code))).u64(from).u64(size).record(kSummaryOffset));
  write(Content().u64(summary).u64(offsets).u32(0).record(kFooter));
  write(kMagic);
  std::FILE* file = std::exchange(file_, nullptr);
  if (std::fclose(file) != 0) throw WriteError(path_.string() + ": " + std::strerror(errno));
}

}  // namespace firn::report
