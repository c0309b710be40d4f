// McapWriter writes an .mcap file: chunks of messages, deflated with zstd, with their indices and a summary.
// Format: https://mcap.dev/spec (version 0).
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace firn::report {

class McapWriter {
 public:
  explicit McapWriter(const std::filesystem::path& file);  ///< @throws WriteError
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// @param encoding of `data`: "jsonschema", "lcm" @returns its number
  std::uint16_t add_schema(const std::string& name, const std::string& encoding, const std::string& data);
  /// @param encoding of messages: "json", "lcm" @returns its number
  std::uint16_t add_channel(std::uint16_t schema, const std::string& topic, const std::string& encoding,
                            const std::map<std::string, std::string>& metadata);
  void message(std::uint16_t channel, std::uint32_t sequence, std::uint64_t time_ns, std::string_view data);
  void attachment(const std::string& name, const std::string& media_type, std::string_view data);
  void close();  ///< writes summary and footer. @throws WriteError

 private:
  struct ChunkIndex {
    std::uint64_t first_ns = 0, last_ns = 0, at = 0, bytes = 0, plain = 0, packed = 0, index_bytes = 0;
    std::map<std::uint16_t, std::uint64_t> indices;  // channel, place of its message index
  };
  struct AttachmentIndex {
    std::uint64_t at = 0, bytes = 0, size = 0;
    std::string name, media_type;
  };
  void write(std::string_view bytes);
  void end_chunk();

  std::filesystem::path path_;
  std::FILE* file_ = nullptr;
  std::uint64_t at_ = 0;
  std::string chunk_;
  std::uint64_t chunk_first_ns_ = 0, chunk_last_ns_ = 0;
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> chunk_messages_;
  std::vector<std::string> schemas_, channels_;  // whole records, repeated in the summary
  std::vector<ChunkIndex> chunks_;
  std::vector<AttachmentIndex> attachments_;
  std::map<std::uint16_t, std::uint64_t> counts_;
  std::uint64_t messages_ = 0, first_ns_ = 0, last_ns_ = 0;
};

}  // namespace firn::report
