#include "files/record/packed.h"

#include <unistd.h>
#define ZSTD_STATIC_LINKING_ONLY  // ZSTD_d_stableOutBuffer
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <utility>

#include "files/record/checksum.h"
#include "files/record/file.h"

namespace firn::logfile {
namespace {

namespace fs = std::filesystem;

constexpr std::array<char, 8> kMagic{'F', 'I', 'R', 'N', 'P', 'A', 'C', '1'};
constexpr int kLevel = 3;  // level 9 takes three times as long for 3 % less
constexpr int kSmallestWindow = 20, kLargestWindow = 31;

struct Header {
  std::array<char, 8> magic = kMagic;
  std::uint64_t plain = 0, squeezed = 0;  // bytes
  std::uint64_t checksum = 0, known_checksum = 0;
  std::uint32_t name = 0;  // bytes of the known file's name, which follows
  std::uint32_t zero = 0;
};
static_assert(sizeof(Header) == 48);

struct Free {
  void operator()(ZSTD_CCtx* c) const { ZSTD_freeCCtx(c); }
  void operator()(ZSTD_DCtx* c) const { ZSTD_freeDCtx(c); }
};

std::runtime_error damaged(const fs::path& file, const std::string& what) {
  return std::runtime_error(file.string() + ": packed file: " + what);
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

/// The known file of the packed file that was opened last: those of one run share it.
std::shared_ptr<const MappedFile> known_file(const fs::path& path) {
  static std::mutex mutex;
  static fs::path last_path;
  static fs::file_time_type last_time;
  static std::shared_ptr<const MappedFile> last;
  const std::lock_guard lock(mutex);
  std::error_code error;
  const auto time = fs::last_write_time(path, error);
  if (!last || path != last_path || time != last_time || error) {
    last.reset();
    const MappedFile stored(path, MappedFile::Packed::kAsIs);
    if (is_packed(stored.bytes()) && !header_of(path, stored.bytes()).second.empty())
      throw damaged(path, "it needs a known file, and is one");  // in a circle, perhaps
    last = std::make_shared<const MappedFile>(path);
    last_path = path;
    last_time = time;
  }
  return last;
}

/// Decompresses a frame into pages of its size, from byte `begin` of them on. The output is zstd's window:
/// nothing is copied, and the process forgets the pages that it does not need at the moment.
void decompress(const fs::path& file, std::span<const std::byte> frame, const MappedFile* known,
                const Pages& out, std::size_t begin) {
  constexpr std::size_t kHeld_bytes = 16 << 20;
  const auto fail = [&](const std::string& why) { throw damaged(file, "its content is damaged" + why); };
  const std::unique_ptr<ZSTD_DCtx, Free> context(ZSTD_createDCtx());
  ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, kLargestWindow);
  ZSTD_DCtx_setParameter(context.get(), ZSTD_d_stableOutBuffer, 1);
  if (known) ZSTD_DCtx_refPrefix(context.get(), known->bytes().data(), known->bytes().size());
  const std::span<std::byte> into = out.span().subspan(begin);
  ZSTD_outBuffer to{into.data(), into.size(), 0};
  std::size_t at = 0, wanted = 8,
              forgotten = 0;  // bytes of input: zstd asks for a block, which makes 128 kB at most
  while (wanted != 0 && at < frame.size()) {
    ZSTD_inBuffer from{frame.data() + at, std::min(wanted, frame.size() - at), 0};
    const std::size_t made = to.pos;
    wanted = ZSTD_decompressStream(context.get(), &to, &from);
    if (ZSTD_isError(wanted)) fail(std::string(": ") + ZSTD_getErrorName(wanted));
    if (wanted != 0 && from.pos == 0 && to.pos == made) fail("");
    at += from.pos;
    if (to.pos < forgotten + kHeld_bytes) continue;
    out.forget(0, begin + to.pos);
    if (known) known->forget();
    forgotten = to.pos;
  }
  if (wanted != 0 || at != frame.size() || to.pos != into.size()) fail("");
  out.forget(0, begin + to.pos);
}

std::uint64_t checksum_of(std::span<const std::byte> known) { return known.empty() ? 0 : checksum64(known); }

}  // namespace

bool is_packed(std::span<const std::byte> bytes) {
  return bytes.size() >= sizeof(Header) && std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0;
}

bool is_packed(const fs::path& file) {
  std::array<std::byte, sizeof(Header)> head{};
  std::ifstream in(file, std::ios::binary);
  in.read(reinterpret_cast<char*>(head.data()), head.size());
  return in.gcount() == std::streamsize(head.size()) && is_packed(head);
}

std::vector<std::byte> pack(std::span<const std::byte> plain, std::span<const std::byte> known,
                            const std::string& known_name) {
  const std::vector<std::byte> squeezed = squeeze_records(plain);
  Header h;
  h.plain = plain.size();
  h.squeezed = squeezed.size();
  h.checksum = checksum64(plain);
  h.known_checksum = checksum_of(known);
  h.name = std::uint32_t(known_name.size());
  const std::unique_ptr<ZSTD_CCtx, Free> context(ZSTD_createCCtx());
  const int window =
      std::clamp(int(std::bit_width(known.size() + squeezed.size())), kSmallestWindow, kLargestWindow);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kLevel);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_windowLog, window);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_enableLongDistanceMatching, 1);
  if (!known.empty()) ZSTD_CCtx_refPrefix(context.get(), known.data(), known.size());
  const std::size_t front = sizeof h + known_name.size();
  std::vector<std::byte> packed(front + ZSTD_compressBound(squeezed.size()));
  std::memcpy(packed.data(), &h, sizeof h);
  std::memcpy(packed.data() + sizeof h, known_name.data(), known_name.size());
  const std::size_t n = ZSTD_compress2(context.get(), packed.data() + front, packed.size() - front,
                                       squeezed.data(), squeezed.size());
  if (ZSTD_isError(n)) throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(n));
  packed.resize(front + n);
  return packed;
}

Pages unpack(const fs::path& file, std::span<const std::byte> packed) {
  const auto header = header_of(file, packed);
  const auto& h = header.first;
  const std::string& name = header.second;
  const auto frame = packed.subspan(sizeof h + h.name);
  std::shared_ptr<const MappedFile> known;
  if (!name.empty()) {
    known = known_file((file.parent_path() / name).lexically_normal());
    if (checksum64_of_mapped(known->bytes(), known->of_file()) != h.known_checksum)
      throw damaged(file, (file.parent_path() / name).lexically_normal().string() + " is not as it was");
  }
  // A damaged header must not fill the memory; the frame says how much it holds.
  if (ZSTD_getFrameContentSize(frame.data(), frame.size()) != h.squeezed || h.plain / 64 > h.squeezed)
    throw damaged(file, "byte 8: sizes");
  const std::uint64_t memory =
      std::uint64_t(::sysconf(_SC_PHYS_PAGES)) * std::uint64_t(::sysconf(_SC_PAGESIZE));
  if (h.squeezed > memory || h.plain > memory - h.squeezed)
    throw damaged(file, "byte 8: " + std::to_string(h.plain) + " and " + std::to_string(h.squeezed) +
                            " bytes, the memory of this machine has " + std::to_string(memory));
  try {
    const auto check = [&](const Pages& plain) {
      if (checksum64_of_mapped(plain.span(), plain.of_file()) != h.checksum)
        throw damaged(file, "its content is not as it was");
    };
    const std::size_t page = Pages::page_bytes();
    const bool maybe_one = h.squeezed == h.plain + kPieceHeadBytes;  // then its plain bytes begin a page
    const std::size_t begin = maybe_one ? page - kPieceHeadBytes : 0;
    Pages squeezed(begin + h.squeezed);
    decompress(file, frame, known.get(), squeezed, begin);
    if (maybe_one && is_one_piece(squeezed.span().subspan(begin))) {
      squeezed.drop_front(page);
      check(squeezed);
      return squeezed;
    }
    Pages plain(h.plain);
    std::size_t read = 0, written = 0;
    const auto forget = [&](std::size_t until_read, std::size_t until_written) {
      squeezed.forget(std::exchange(read, until_read), until_read);
      plain.forget(std::exchange(written, until_written), until_written);
    };
    if (!restore_records(squeezed.span().subspan(begin), plain.span(), forget))
      throw damaged(file, "its content is not as it was");
    check(plain);
    return plain;
  } catch (const std::bad_alloc&) {
    throw damaged(
        file, "no memory for " + std::to_string(h.plain) + " and " + std::to_string(h.squeezed) + " bytes");
  }
}

}  // namespace firn::logfile
