#include "report/export/zip_file.h"

#include <zlib.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "files/text_file.h"

namespace firn::tables {
namespace {

constexpr int kZipLevel = 4;
constexpr std::size_t kBlock = 1 << 18;
constexpr std::uint32_t kAll32 = 0xffffffffu;
constexpr std::uint16_t kVersion = 45, kDeflated = 8, kUtf8Names = 1 << 11;

class Bytes {
 public:
  Bytes& u16(std::uint64_t v) { return put(v, 2); }
  Bytes& u32(std::uint64_t v) { return put(v, 4); }
  Bytes& u64(std::uint64_t v) { return put(v, 8); }
  Bytes& text(std::string_view s) {
    bytes_ += s;
    return *this;
  }
  const std::string& str() const { return bytes_; }

 private:
  Bytes& put(std::uint64_t v, int n) {
    for (int k = 0; k < n; ++k) bytes_ += char(v >> (8 * k) & 255);
    return *this;
  }
  std::string bytes_;
};

// Date and time are those of the format's first day: the same content gives the same file.
void put_common(Bytes& b, std::uint32_t crc) {
  b.u16(kVersion).u16(kUtf8Names).u16(kDeflated).u16(0).u16(0x21).u32(crc).u32(kAll32).u32(kAll32);
}

}  // namespace

ZipWriter::ZipWriter(const std::filesystem::path& file) : path_(file), file_(std::fopen(file.c_str(), "wb")) {
  if (!file_) throw WriteError(file.string() + ": cannot be written: " + std::strerror(errno));
}

ZipWriter::~ZipWriter() {
  if (file_) std::fclose(file_);
}

void ZipWriter::write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size())
    throw WriteError(path_.string() + ": byte " + std::to_string(at_) + ": " + std::strerror(errno));
  at_ += bytes.size();
}

void ZipWriter::deflate(Entry& entry, const std::function<void(const Put&)>& fill) {
  z_stream z{};
  if (deflateInit2(&z, kZipLevel, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw WriteError(path_.string() + ": no memory to deflate");
  struct End {
    z_stream* z;
    ~End() { deflateEnd(z); }
  } end{&z};
  std::string out(kBlock, '\0');
  const auto feed = [&](std::string_view bytes, int flush) {
    z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    z.avail_in = uInt(bytes.size());
    do {
      z.next_out = reinterpret_cast<Bytef*>(out.data());
      z.avail_out = uInt(out.size());
      ::deflate(&z, flush);
      write(std::string_view(out).substr(0, out.size() - z.avail_out));
    } while (z.avail_out == 0);
  };
  const std::uint64_t begin = at_;
  entry.crc = std::uint32_t(crc32(0, nullptr, 0));
  fill([&](std::string_view bytes) {
    for (; !bytes.empty(); bytes.remove_prefix(std::min(bytes.size(), kBlock))) {
      const std::string_view part = bytes.substr(0, kBlock);
      entry.crc =
          std::uint32_t(crc32(entry.crc, reinterpret_cast<const Bytef*>(part.data()), uInt(part.size())));
      entry.plain += part.size();
      feed(part, Z_NO_FLUSH);
    }
  });
  feed({}, Z_FINISH);
  entry.packed = at_ - begin;
}

void ZipWriter::add(const std::string& name, const std::function<void(const Put&)>& fill) {
  Entry e{name, at_, 0, 0, 0};
  const auto head = [&] {
    Bytes b;
    b.u32(0x04034b50);
    put_common(b, e.crc);
    b.u16(name.size()).u16(20).text(name).u16(1).u16(16).u64(e.plain).u64(e.packed);
    return b.str();
  };
  write(head());
  deflate(e, fill);
  // Sum and sizes are known only now.
  if (::fseeko(file_, off_t(e.offset), SEEK_SET) != 0)
    throw WriteError(path_.string() + ": " + std::strerror(errno));
  const std::uint64_t end = at_;
  write(head());
  at_ = end;
  if (::fseeko(file_, off_t(end), SEEK_SET) != 0)
    throw WriteError(path_.string() + ": " + std::strerror(errno));
  entries_.push_back(std::move(e));
}

void ZipWriter::close() {
  const std::uint64_t begin = at_;
  for (const Entry& e : entries_) {
    Bytes b;
    b.u32(0x02014b50).u16(kVersion);
    put_common(b, e.crc);
    b.u16(e.name.size()).u16(28).u16(0).u16(0).u16(0).u32(0).u32(kAll32).text(e.name);
    b.u16(1).u16(24).u64(e.plain).u64(e.packed).u64(e.offset);
    write(b.str());
  }
  const std::uint64_t end = at_, size = end - begin, count = entries_.size();
  Bytes b;
  b.u32(0x06064b50)
      .u64(44)
      .u16(kVersion)
      .u16(kVersion)
      .u32(0)
      .u32(0)
      .u64(count)
      .u64(count)
      .u64(size)
      .u64(begin);
  b.u32(0x07064b50).u32(0).u64(end).u32(1);
  b.u32(0x06054b50).u16(0).u16(0).u16(0xffff).u16(0xffff).u32(kAll32).u32(kAll32).u16(0);
  write(b.str());
  std::FILE* file = std::exchange(file_, nullptr);
  if (std::fclose(file) != 0) throw WriteError(path_.string() + ": " + std::strerror(errno));
}

}  // namespace firn::tables
