#include "tests/replay/damage.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "files/record/record_file.h"

namespace firn::test {

Records read_records(const std::filesystem::path& file) {
  const record::MappedFile map(file);
  record::RecordReader reader(map.bytes());
  Records records;
  while (const auto r = reader.next()) records.push_back({r->kind, {r->payload.begin(), r->payload.end()}});
  return records;
}

void write_records(const std::filesystem::path& file, const Records& records) {
  std::filesystem::remove(file);
  record::RecordWriter writer(file, record::RecordWriter::Mode::kCreate);
  for (const RawRecord& r : records) writer.append(r.kind, r.payload);
  writer.close();
}

void edit_records(const std::filesystem::path& file, const std::function<void(Records&)>& edit) {
  Records records = read_records(file);
  edit(records);
  write_records(file, records);
}

std::size_t find_record(const Records& records, std::uint16_t kind, std::string_view text, int n) {
  for (std::size_t k = 0; k < records.size(); ++k) {
    const std::string_view payload(reinterpret_cast<const char*>(records[k].payload.data()),
                                   records[k].payload.size());
    if (records[k].kind == kind && payload.find(text) != payload.npos && n-- == 0) return k;
  }
  throw std::runtime_error("no such record: " + std::string(text));
}

void write_bytes(const std::filesystem::path& file, const std::vector<std::byte>& bytes) {
  std::ofstream(file, std::ios::binary | std::ios::trunc)
      .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

void flip(std::vector<std::byte>& bytes, std::size_t at, int bit) { bytes.at(at) ^= std::byte(1 << bit); }

std::size_t find_bytes(const std::vector<std::byte>& bytes, const std::vector<std::byte>& needle,
                       std::size_t from) {
  const auto it =
      std::search(bytes.begin() + std::ptrdiff_t(from), bytes.end(), needle.begin(), needle.end());
  if (it == bytes.end()) throw std::runtime_error("no such bytes");
  return std::size_t(it - bytes.begin());
}

void renumber(RawRecord& record, std::int64_t by) {
  std::uint64_t step = 0;
  std::memcpy(&step, record.payload.data(), sizeof step);
  step += std::uint64_t(by);
  std::memcpy(record.payload.data(), &step, sizeof step);
}

}  // namespace firn::test
