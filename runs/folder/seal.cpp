#include "runs/folder/seal.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>
#include <stdexcept>

#include "core/options/number.h"
#include "files/digest.h"
#include "files/record/file.h"
#include "files/record/open_file.h"
#include "files/record/packed.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFirstLine = "firn-seal 1";
constexpr std::size_t kBlock_bytes = 1 << 20;

std::string digest_of(std::string_view text) { return sha256_hex(std::as_bytes(std::span(text))); }

// A line of text holds no line break of a path or a reason.
std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ') c = '?';
  return text;
}

class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}

  bool done() const { return text_.empty(); }
  std::string_view next() {
    const std::size_t end = text_.find('\n');
    if (end == std::string_view::npos) fail("has no end");
    line_ = text_.substr(0, end);
    text_.remove_prefix(end + 1);
    ++number_;
    return line_;
  }
  bool next_is(std::string_view word) const { return text_.starts_with(word); }
  // Returns the rest of the next line behind "<word> ".
  std::string_view value(std::string_view word) {
    const std::string_view line = next();
    if (!line.starts_with(word) || line.size() <= word.size() || line[word.size()] != ' ')
      fail("'" + std::string(word) + "' is missing");
    return line.substr(word.size() + 1);
  }
  template <class T>
  T number(std::string_view text) const {
    const std::optional<T> value = whole_number<T>(text);
    if (!value) fail("'" + std::string(text.substr(0, 40)) + "' is no number");
    return *value;
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error("line " + std::to_string(number_ + 1) + ": " + what);
  }

 private:
  std::string_view text_, line_;
  int number_ = 0;
};

SealedFile file_of(Lines& lines) {
  std::string_view rest = lines.value("file");
  const auto word = [&] {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    const std::string_view w = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    return w;
  };
  SealedFile f;
  f.sha256 = word();
  f.bytes = lines.number<std::uint64_t>(word());
  const std::string_view mark = word();
  f.anew = mark == "*";
  f.path = rest;
  const fs::path path(f.path);
  if (!is_sha256_hex(f.sha256) || (mark != "*" && mark != "=")) lines.fail("is no 'file' line");
  if (f.path.empty() || path.is_absolute() || std::ranges::find(path, fs::path("..")) != path.end())
    lines.fail("'" + f.path + "' is no path in the folder");
  return f;
}

class Descriptor {
 public:
  explicit Descriptor(const fs::path& path)
      : path_(path), fd_(record::open_file(path, O_RDONLY | O_NOFOLLOW).fd) {
    struct stat s {};
    if (fd_ < 0 || ::fstat(fd_, &s) != 0) fail();
    if (!S_ISREG(s.st_mode)) {
      ::close(fd_);
      throw std::runtime_error(path.string() + ": is no regular file");
    }
  }
  ~Descriptor() { ::close(fd_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  void sync() const {
    if (::fdatasync(fd_) != 0) fail();
  }
  // Calls `use` with block after block of the plain bytes.
  void each_block(const std::function<void(std::span<const std::byte>)>& use) const {
    if (record::is_packed(path_)) {
      const record::MappedFile packed(path_, record::MappedFile::Packed::kAsIs);
      record::PackedReader reader(path_, packed.bytes());
      for (auto part = reader.next(); !part.empty(); part = reader.next()) use(part);
      return;
    }
    std::vector<std::byte> block(kBlock_bytes);
    for (;;) {
      const ssize_t n = ::read(fd_, block.data(), block.size());
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) fail();
      if (n == 0) return;
      use(std::span(block).first(std::size_t(n)));
    }
  }

 private:
  [[noreturn]] void fail() const { throw record::FileError(path_, 0, "cannot be read and synced", errno); }

  fs::path path_;
  int fd_;
};

}  // namespace

std::string encode_seal(Seal& s) {
  std::string text(kFirstLine);
  text += "\nnumber " + std::to_string(s.number) + "\nrun " + std::to_string(s.run_id) + "\nincarnation " +
          std::to_string(s.incarnation) + "\nstate " + (s.open ? "begun" : "ended") + "\nreason " +
          one_line(s.reason) + "\nbefore " + (s.before.empty() ? "nothing" : s.before) + "\n";
  for (const std::string& d : s.differs) text += "differs " + one_line(d) + "\n";
  for (const SealedFile& f : s.files)
    text += "file " + f.sha256 + " " + std::to_string(f.bytes) + (f.anew ? " * " : " = ") + one_line(f.path) +
            "\n";
  s.digest = digest_of(text);
  return text + "seal " + s.digest + "\n";
}

Seal decode_seal(std::string_view text) {
  constexpr std::size_t kLast = 5 + 64 + 1;  // "seal <digest>\n"
  Seal s;
  Lines lines(text);
  if (text.size() < kLast) lines.fail("the seal is cut");
  const std::string_view last = text.substr(text.size() - kLast), body = text.substr(0, text.size() - kLast);
  s.digest = digest_of(body);
  if (last != "seal " + s.digest + "\n") lines.fail("the digest of the seal does not hold");
  if (lines.next() != kFirstLine) lines.fail("is no seal of a known version");
  s.number = lines.number<std::int64_t>(lines.value("number"));
  s.run_id = lines.number<std::int64_t>(lines.value("run"));
  s.incarnation = lines.number<std::int32_t>(lines.value("incarnation"));
  s.open = lines.value("state") == "begun";
  s.reason = lines.value("reason");
  s.before = lines.value("before");
  if (s.before == "nothing") s.before.clear();
  while (lines.next_is("differs ")) s.differs.emplace_back(lines.value("differs"));
  while (lines.next_is("file ")) s.files.push_back(file_of(lines));
  lines.value("seal");
  if (!lines.done()) lines.fail("something follows the seal");
  return s;
}

FileDigests digest_file(const fs::path& path, std::span<const std::uint64_t> lengths, bool sync) {
  const Descriptor file(path);
  if (sync) file.sync();
  FileDigests d;
  d.prefixes.resize(lengths.size());
  std::size_t next = 0;
  Sha256 digest;
  const auto reached = [&] {
    for (; next < lengths.size() && lengths[next] == d.bytes; ++next) d.prefixes[next] = digest.hex();
  };
  reached();
  file.each_block([&](std::span<const std::byte> block) {
    while (!block.empty()) {
      const std::uint64_t left = next < lengths.size() ? lengths[next] - d.bytes : block.size();
      const auto part = block.first(std::size_t(std::min<std::uint64_t>(left, block.size())));
      digest.add(part);
      d.bytes += part.size();
      block = block.subspan(part.size());
      reached();
    }
  });
  d.sha256 = digest.hex();
  return d;
}

bool restores(const fs::path& path, const fs::path& tail, const SealedFile& sealed) {
  Sha256 digest;
  const std::uint64_t tail_bytes = fs::file_size(tail);
  if (tail_bytes > sealed.bytes) return false;
  std::uint64_t left = sealed.bytes - tail_bytes;
  Descriptor(path).each_block([&](std::span<const std::byte> block) {
    const auto part = block.first(std::size_t(std::min<std::uint64_t>(left, block.size())));
    digest.add(part);
    left -= part.size();
  });
  Descriptor(tail).each_block([&](std::span<const std::byte> block) { digest.add(block); });
  return left == 0 && digest.hex() == sealed.sha256;
}

}  // namespace firn::runs
