#include "files/record/packed.h"

#include <fcntl.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <utility>

#include "files/record/checksum.h"
#include "files/record/file.h"
#include "files/record/open_file.h"
#include "files/record/squeeze.h"

namespace firn::record {
namespace {

namespace fs = std::filesystem;

constexpr std::array<char, 8> kMagic{'F', 'I', 'R', 'N', 'P', 'A', 'C', '1'};
// A run of 100 layers has 142 MB (docs/measurements.md): level 1 makes 23.4 MB of them in 0.9 s, 3 makes
// 22.7 MB in 1.05 s, -1 makes 25.2 MB in 0.67 s; without any known text 1 makes 37.1 MB in 0.54 s.
constexpr int kLevel = 1;
// A file repeats the log in its long messages. Where few of its bytes are in such, the known text saves
// nothing, and reading it costs more than packing the file.
constexpr double kLongOfRepeating = 0.25;
// Level 1 finds nothing more in a larger window; a file with a known text needs one of its own size.
constexpr int kWindow = 22, kSmallestWindow = 20,
              kLargestWindow = 31;  // 2^n bytes; the last that of Firn 0.1
// Records pack to a sixth, repeated ones to a hundredth; a write-ahead file repeats its known file. A file
// that claims more is made to fill disk and memory.
constexpr std::uint64_t kFree_bytes = std::uint64_t(64) << 20, kMaxRatio = 200, kMaxOfKnown = 4;
constexpr std::size_t kPart_bytes = 1 << 20, kCounted_bytes = 1 << 16;

struct Header {
  std::array<char, 8> magic = kMagic;
  std::uint64_t plain = 0, squeezed = 0;  // bytes
  std::uint64_t checksum = 0, known_checksum = 0;
  std::uint32_t name = 0;  // bytes of the known file's name, which follows
  /// Of all bytes of the packed file, this field taken as 0. Files of Firn 0.1 have 0 here.
  std::uint32_t own_checksum = 0;
};
static_assert(sizeof(Header) == kHeaderBytes);

struct Free {
  void operator()(ZSTD_CCtx* c) const { ZSTD_freeCCtx(c); }
  void operator()(ZSTD_DCtx* c) const { ZSTD_freeDCtx(c); }
};

PackedError damaged(const fs::path& file, const std::string& what) {
  return PackedError(file.string() + ": packed file: " + what);
}

/// Reads the header and the name of the known file, empty: none. A foreign file names no other than a log
/// beside or above it: a name is no way out of the run's folder.
std::pair<Header, std::string> header_of(const fs::path& file, std::span<const std::byte> packed) {
  Header h;
  if (!is_packed(packed)) throw damaged(file, "no header");
  std::memcpy(&h, packed.data(), sizeof h);
  if (h.name > 255 || packed.size() < sizeof h + h.name) throw damaged(file, "byte 40: length of a name");
  std::string name(reinterpret_cast<const char*>(packed.data()) + sizeof h, h.name);
  if (!name.empty() && name != "log.lcm" && name != "../log.lcm")
    throw damaged(file, "byte 48: names another file than log.lcm or ../log.lcm");
  return {h, std::move(name)};
}

struct KnownFile {
  explicit KnownFile(const fs::path& path)
      : plain(path), checksum(checksum64_of_mapped(plain.bytes(), plain.of_file())) {}
  MappedFile plain;
  std::uint64_t checksum;
};

/// The known file of the packed file that was opened last: those of one run share it.
std::shared_ptr<const KnownFile> known_file(const fs::path& path) {
  static std::mutex mutex;
  static fs::path last_path;
  static fs::file_time_type last_time;
  static std::shared_ptr<const KnownFile> last;
  const std::lock_guard lock(mutex);
  std::error_code error;
  const auto time = fs::last_write_time(path, error);
  if (!last || path != last_path || time != last_time || error) {
    last.reset();
    const MappedFile stored(path, MappedFile::Packed::kAsIs);
    if (is_packed(stored.bytes()) && !header_of(path, stored.bytes()).second.empty())
      throw damaged(path, "it needs a known file, and is one");  // in a circle, perhaps
    last = std::make_shared<const KnownFile>(path);
    last_path = path;
    last_time = time;
  }
  return last;
}

// Restores plain bytes from a zstd frame.
class Unpacker {
 public:
  explicit Unpacker(std::span<const std::byte> known)
      : context_(ZSTD_createDCtx()), squeezed_(ZSTD_DStreamOutSize()) {
    ZSTD_DCtx_setParameter(context_.get(), ZSTD_d_windowLogMax, kLargestWindow);
    if (!known.empty()) ZSTD_DCtx_refPrefix(context_.get(), known.data(), known.size());
  }

  /// Takes some bytes from the front of `frame` and appends the plain bytes that they give, of 128 kB at
  /// most.
  /// @returns false: the bytes are no frame, or of no squeezed file, as trouble() says
  bool step(std::span<const std::byte>& frame, std::vector<std::byte>& plain) {
    made_ = 0;
    if (ended_) return frame.empty();
    ZSTD_inBuffer from{frame.data(), std::min(frame.size(), std::max<std::size_t>(wanted_, 1)), 0};
    ZSTD_outBuffer to{squeezed_.data(), squeezed_.size(), 0};
    const std::size_t left = ZSTD_decompressStream(context_.get(), &to, &from);
    if (ZSTD_isError(left)) {
      trouble_ = std::string(": ") + ZSTD_getErrorName(left);
      return false;
    }
    frame = frame.subspan(from.pos);
    wanted_ = left;
    ended_ = left == 0;
    made_ = to.pos;
    return restorer_.add(std::span(squeezed_).first(to.pos), plain);
  }
  bool ended() const { return ended_ && restorer_.whole(); }
  /// Returns the number of squeezed bytes that the last step made.
  std::size_t made() const { return made_; }
  const std::string& trouble() const { return trouble_; }

 private:
  std::unique_ptr<ZSTD_DCtx, Free> context_;
  std::vector<std::byte> squeezed_;
  Restorer restorer_;
  std::size_t wanted_ = 8, made_ = 0;  // zstd asks for a block at a time
  bool ended_ = false;
  std::string trouble_;
};

// Unpacks packed parts as they are made.
class PackingCheck {
 public:
  PackingCheck(std::span<const std::byte> plain, std::span<const std::byte> known)
      : left_(plain), unpacker_(known) {}

  void add(std::span<const std::byte> frame) {
    do {
      plain_.clear();
      if (!unpacker_.step(frame, plain_) || plain_.size() > left_.size() ||
          (!plain_.empty() && std::memcmp(plain_.data(), left_.data(), plain_.size()) != 0))
        fail();
      sum_.add(plain_);
      left_ = left_.subspan(plain_.size());
    } while (!frame.empty() || unpacker_.made() > 0);
  }
  /// Returns the checksum of the unpacked bytes.
  std::uint64_t end() const {
    if (!left_.empty() || !unpacker_.ended()) fail();
    return sum_.value();
  }

 private:
  [[noreturn]] static void fail() { throw std::runtime_error("does not unpack to the same bytes"); }

  std::span<const std::byte> left_;
  Unpacker unpacker_;
  std::vector<std::byte> plain_;
  Checksum64 sum_;
};

std::uint64_t checksum_of(std::span<const std::byte> known) { return known.empty() ? 0 : checksum64(known); }

// Two bytes are never zero, so that no single changed byte makes it the 0 of an older file.
std::uint32_t own_checksum(Header h, std::uint64_t of_the_rest) {
  h.own_checksum = 0;
  const std::array<std::uint64_t, 2> sums{checksum64(std::as_bytes(std::span(&h, 1))), of_the_rest};
  return std::uint32_t(checksum64(std::as_bytes(std::span(sums)))) | 0x80000080U;
}

bool within_bounds(std::uint64_t plain, std::uint64_t packed, std::uint64_t known) {
  return plain <= kFree_bytes || plain <= kFree_bytes + kMaxRatio * packed + kMaxOfKnown * known;
}

}  // namespace

bool is_packed(std::span<const std::byte> bytes) {
  return bytes.size() >= sizeof(Header) && std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0;
}

bool is_packed(const fs::path& file) {
  std::array<std::byte, sizeof(Header)> head{};
  const OpenedFile opened = open_file(file, O_RDONLY);
  if (opened.fd < 0) return false;
  const ssize_t n = ::pread(opened.fd, head.data(), head.size(), 0);
  ::close(opened.fd);
  return n == ssize_t(head.size()) && is_packed(head);
}

std::optional<std::uint64_t> declared_bytes(std::span<const std::byte> packed) {
  if (!is_packed(packed)) return std::nullopt;
  Header h;
  std::memcpy(&h, packed.data(), sizeof h);
  return h.plain;
}

std::optional<PackedHeader> pack(std::span<const std::byte> plain, std::span<const std::byte> known,
                                 const std::string& known_name,
                                 const std::function<void(std::span<const std::byte>)>& write,
                                 const std::function<bool(std::size_t)>& goes_on) {
  const auto ends = [&](std::size_t done) { return goes_on && !goes_on(done); };
  Header h;
  Checksum64 rest;
  Squeezer::Counted counted;
  for (Squeezer count(plain); count.count(counted, kCounted_bytes);)
    if (ends(count.done())) return {};
  h.squeezed = counted.squeezed;
  // zstd forgets it all where a window's bytes were packed.
  if (h.squeezed > kWindow_bytes || double(counted.of_long) < kLongOfRepeating * double(counted.squeezed))
    known = {};
  const std::string name = known.empty() ? "" : known_name;
  h.plain = plain.size();
  h.known_checksum = checksum_of(known);
  h.name = std::uint32_t(name.size());

  const std::unique_ptr<ZSTD_CCtx, Free> context(ZSTD_createCCtx());
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kLevel);
  ZSTD_CCtx_setParameter(
      context.get(), ZSTD_c_windowLog,
      known.empty() ? kWindow : std::max(kSmallestWindow, int(std::bit_width(h.squeezed))));
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_enableLongDistanceMatching, !known.empty());
  ZSTD_CCtx_setPledgedSrcSize(context.get(), h.squeezed);
  if (!known.empty()) ZSTD_CCtx_refPrefix(context.get(), known.data(), known.size());
  std::size_t size = sizeof h;
  const auto put = [&](std::span<const std::byte> bytes) {
    write(bytes);
    rest.add(bytes);
    size += bytes.size();
  };
  write(PackedHeader{});
  put(std::as_bytes(std::span(name)));
  PackingCheck check(plain, known);
  std::vector<std::byte> part;
  std::vector<std::byte> packed(ZSTD_CStreamOutSize());
  Squeezer squeezer(plain);
  for (bool more = true; more;) {
    part.clear();
    more = squeezer.more(part, kPart_bytes);
    ZSTD_inBuffer from{part.data(), part.size(), 0};
    for (std::size_t left = 1; more ? from.pos < from.size : left != 0;) {
      ZSTD_outBuffer to{packed.data(), packed.size(), 0};
      left = ZSTD_compressStream2(context.get(), &to, &from, more ? ZSTD_e_continue : ZSTD_e_end);
      if (ZSTD_isError(left)) throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(left));
      put(std::span(packed).first(to.pos));
      check.add(std::span(packed).first(to.pos));
    }
    if (ends(plain.size() + squeezer.done())) return {};
  }
  h.checksum = check.end();
  if (!within_bounds(std::max(h.plain, h.squeezed), size, known.size())) return {};
  h.own_checksum = own_checksum(h, rest.value());
  PackedHeader header;
  std::memcpy(header.data(), &h, sizeof h);
  return header;
}

std::vector<std::byte> pack(std::span<const std::byte> plain, std::span<const std::byte> known,
                            const std::string& known_name) {
  std::vector<std::byte> packed;
  const auto header = pack(plain, known, known_name, [&](std::span<const std::byte> bytes) {
    packed.insert(packed.end(), bytes.begin(), bytes.end());
  });
  if (!header) return {};
  std::ranges::copy(*header, packed.begin());
  return packed;
}

struct PackedReader::State {
  State(const fs::path& f, std::span<const std::byte> packed, const Header& head, const std::string& name)
      : file(f),
        h(head),
        frame(packed.subspan(sizeof h + h.name)),
        known(known_of(name)),
        unpacker(known ? known->plain.bytes() : std::span<const std::byte>{}) {}

  std::shared_ptr<const KnownFile> known_of(const std::string& name) const {
    if (name.empty()) return {};
    const fs::path path = (file.parent_path() / name).lexically_normal();
    auto log = known_file(path);
    if (log->checksum != h.known_checksum) throw damaged(file, path.string() + " is not as it was");
    return log;
  }
  [[noreturn]] void fail(const std::string& why) const {
    throw damaged(file, "its content is damaged" + why);
  }

  fs::path file;
  Header h;
  std::span<const std::byte> frame;  // what is left of it
  std::shared_ptr<const KnownFile> known;
  Unpacker unpacker;
  std::vector<std::byte> plain;
  Checksum64 sum;
  std::uint64_t done = 0, squeezed = 0, forgotten = 0;
};

PackedReader::PackedReader(const fs::path& file, std::span<const std::byte> packed) {
  const auto [h, name] = header_of(file, packed);
  if (h.own_checksum != 0 && own_checksum(h, checksum64(packed.subspan(sizeof h))) != h.own_checksum)
    throw damaged(file, "it is not as it was written");
  state_ = std::make_unique<State>(file, packed, h, name);
  // A damaged header must not fill the memory; the frame says how much it holds.
  const auto frame = state_->frame;
  if (ZSTD_getFrameContentSize(frame.data(), frame.size()) != h.squeezed || h.plain / 64 > h.squeezed)
    throw damaged(file, "byte 8: sizes");
  const std::uint64_t most = std::max(h.plain, h.squeezed);
  if (!within_bounds(most, packed.size(), state_->known ? state_->known->plain.bytes().size() : 0))
    throw damaged(file, "byte 8: " + std::to_string(most) + " bytes cannot come from a packed file of " +
                            std::to_string(packed.size()));
  const std::uint64_t memory =
      std::uint64_t(::sysconf(_SC_PHYS_PAGES)) * std::uint64_t(::sysconf(_SC_PAGESIZE));
  if (h.squeezed > memory || h.plain > memory - h.squeezed)
    throw damaged(file, "byte 8: " + std::to_string(h.plain) + " and " + std::to_string(h.squeezed) +
                            " bytes, the memory of this machine has " + std::to_string(memory));
}

PackedReader::~PackedReader() = default;

std::uint64_t PackedReader::plain_bytes() const { return state_->h.plain; }

std::span<const std::byte> PackedReader::next() {
  State& s = *state_;
  s.plain.clear();
  while (s.plain.empty() && (!s.unpacker.ended() || !s.frame.empty())) {
    const std::size_t before = s.frame.size();
    if (!s.unpacker.step(s.frame, s.plain)) s.fail(s.unpacker.trouble());
    if (s.frame.size() == before && s.unpacker.made() == 0 && !s.unpacker.ended()) s.fail("");
    s.squeezed += s.unpacker.made();
    s.done += s.plain.size();
    if (s.squeezed > s.h.squeezed || s.done > s.h.plain) s.fail("");
  }
  s.sum.add(s.plain);
  if (s.known && s.done >= s.forgotten + kPart_bytes * 16) {
    s.known->plain.forget();
    s.forgotten = s.done;
  }
  if (s.plain.empty() && (s.squeezed != s.h.squeezed || s.done != s.h.plain || s.sum.value() != s.h.checksum))
    throw damaged(s.file, "its content is not as it was");
  return s.plain;
}

Pages unpack(const fs::path& file, std::span<const std::byte> packed) {
  PackedReader reader(file, packed);
  try {
    return Pages(reader.plain_bytes(), [&] { return reader.next(); });
  } catch (const std::bad_alloc&) {
    throw damaged(file, "no memory for " + std::to_string(reader.plain_bytes()) + " bytes");
  }
}

}  // namespace firn::record
