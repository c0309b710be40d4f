#include "procs/relay/file_stream.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "files/digest.h"
#include "files/record/open_file.h"
#include "files/run_paths.h"

namespace firn::relay {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& why) {
  throw std::runtime_error(file.string() + ": " + why);
}

int open_or_refuse(const std::filesystem::path& file, int flags) {
  const record::OpenedFile opened = record::open_file(file, flags);
  if (opened.fd < 0) refuse(file, opened.what ? opened.what : std::strerror(opened.error));
  return opened.fd;
}

struct Closing {
  int fd;
  ~Closing() { ::close(fd); }
};

}  // namespace

FileSource::~FileSource() {
  for (const Source& s : files_)
    if (s.fd >= 0) ::close(s.fd);
}

void FileSource::add(const std::string& name, std::int64_t from) {
  const auto known = std::ranges::find(files_, name, &Source::name);
  if (known != files_.end()) {
    known->sent = from;
    known->begun = from > 0;
    return;
  }
  files_.push_back({name, -1, from, from, from > 0});
}

void FileSource::look() {
  for (Source& s : files_) {
    const std::filesystem::path file = run_ / s.name;
    std::error_code missing;
    if (s.fd < 0 && !std::filesystem::exists(file, missing)) continue;
    if (s.fd < 0) s.fd = open_or_refuse(file, O_RDONLY);
    struct stat now {};
    if (::fstat(s.fd, &now) != 0) refuse(file, std::strerror(errno));
    s.seen = now.st_size;
  }
}

bool FileSource::next(std::vector<std::byte>& frame) {
  for (std::size_t n = 0; n < files_.size(); ++n) {
    Source& s = files_[turn_++ % files_.size()];
    if (s.fd < 0 || (s.begun && s.sent >= s.seen)) continue;
    piece_.resize(std::min(kPieceBytes, std::size_t(s.seen - s.sent)));
    const ssize_t got = ::pread(s.fd, piece_.data(), piece_.size(), s.sent);
    if (got < 0 || std::size_t(got) < piece_.size())
      refuse(run_ / s.name, got >= 0 ? "became shorter" : std::strerror(errno));
    append_frame({FrameKind::kFile, s.name, s.sent, 0, std::span(piece_).first(std::size_t(got))}, frame);
    s.sent += got;
    s.begun = true;
    return true;
  }
  return false;
}

bool FileSource::all_sent() const {
  return std::ranges::all_of(files_,
                             [](const Source& s) { return s.fd < 0 || (s.begun && s.sent >= s.seen); });
}

void FileSink::take(const Frame& f) {
  const std::filesystem::path file = run_ / f.name;
  if (!takes_(f.name)) refuse(file, "is no file that the other host may send");
  std::filesystem::create_directories(file.parent_path());
  const bool anew = f.number == 0 && !RunPaths::is_wal(file);  // a node's record is never taken back
  const Closing opened{open_or_refuse(file, O_WRONLY | O_CREAT | (anew ? O_TRUNC : 0))};
  const std::int64_t end = ::lseek(opened.fd, 0, SEEK_END);
  if (end != f.number)
    refuse(file,
           "has " + std::to_string(end) + " bytes, and the piece begins at byte " + std::to_string(f.number));
  for (std::size_t at = 0; at < f.bytes.size();) {
    const ssize_t put = ::write(opened.fd, f.bytes.data() + at, f.bytes.size() - at);
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) {
      const int error = errno;
      (void)!::ftruncate(opened.fd, end);
      refuse(file, std::strerror(error));
    }
    at += std::size_t(put);
  }
}

FileState state_of(const std::filesystem::path& file, std::int64_t most) {
  std::error_code missing;
  if (!std::filesystem::exists(file, missing)) return {};
  const Closing opened{open_or_refuse(file, O_RDONLY)};
  Sha256 digest;
  FileState state;
  state.bytes = 0;
  std::vector<std::byte> piece(std::size_t(1) << 18);
  for (;;) {
    std::size_t wanted = piece.size();
    if (most >= 0) wanted = std::min(wanted, std::size_t(most - state.bytes));
    const ssize_t got = wanted == 0 ? 0 : ::read(opened.fd, piece.data(), wanted);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) refuse(file, std::strerror(errno));
    if (got == 0) break;
    digest.add(std::span(piece).first(std::size_t(got)));
    state.bytes += got;
  }
  state.sha256 = digest.hex();
  return state;
}

}  // namespace firn::relay
