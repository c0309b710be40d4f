#include "files/text_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "files/record/file.h"
#include "files/record/output_target.h"
#include "files/record/part_file.h"
#include "files/usage_error.h"

namespace firn {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kBlock = std::size_t(1) << 16;

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
  throw WriteError(path.string() + ": " + what);
}

}  // namespace

std::string read_file(const fs::path& path) {
  const int fd =
      open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // a pipe without a writer does not hang
  if (fd < 0) throw UsageError(path.string() + ": cannot be read: " + std::strerror(errno));
  std::string text;
  for (;;) {
    const std::size_t before = text.size();
    text.resize(before + kBlock);
    const ssize_t n = read(fd, text.data() + before, kBlock);
    const int error = errno;
    text.resize(before + (n > 0 ? std::size_t(n) : 0));
    if (n > 0 || (n < 0 && error == EINTR)) continue;
    close(fd);
    if (n < 0)
      throw UsageError(path.string() + ": byte " + std::to_string(before) +
                       ": cannot be read: " + std::strerror(error));
    return text;
  }
}

void write_file_atomically(const fs::path& named, std::string_view content) {
  fs::path path = named;
  try {
    path = logfile::output_target(named);
  } catch (const logfile::FileError& e) {
    throw UsageError(e.what());
  }
  const logfile::PartFile part(path.string() + ".part");
  const fs::path& temporary = part.path();
  const int fd = open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (fd < 0 && (errno == ENOSPC || errno == EDQUOT || errno == EIO)) fail(path, std::strerror(errno));
  if (fd < 0) throw UsageError(named.string() + ": cannot be written: " + std::strerror(errno));
  std::size_t done = 0;
  while (done < content.size()) {
    const ssize_t n = write(fd, content.data() + done, content.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int error = errno;
      close(fd);
      unlink(temporary.c_str());
      fail(path, std::string("byte ") + std::to_string(done) + ": " + std::strerror(error));
    }
    done += std::size_t(n);
  }
  const bool synced = fsync(fd) == 0;
  const int sync_error = errno;
  const bool closed = close(fd) == 0;
  if (synced && closed && rename(temporary.c_str(), path.c_str()) == 0) return;
  const int error = synced ? errno : sync_error;
  unlink(temporary.c_str());
  fail(path, std::strerror(error));
}

}  // namespace firn
