#include "files/text_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

#include "files/record/file.h"
#include "files/record/open_file.h"
#include "files/record/output_target.h"
#include "files/record/part_file.h"
#include "files/usage_error.h"

namespace firn {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kBlock = std::size_t(1) << 16;
constexpr const char* kPart = ".part";
// A report with its pictures has some megabytes, a seal a hundred bytes for each file.
constexpr std::size_t kMostOfRun_bytes = std::size_t(64) << 20;

std::string reason(const record::OpenedFile& file) {
  return file.what ? file.what : std::strerror(file.error);
}

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
  throw WriteError(path.string() + ": " + what);
}

}  // namespace

std::string read_file(const fs::path& path) {
  const record::FolderOfFile folder(path);
  const record::OpenedFile opened = folder.open(O_RDONLY);
  if (opened.fd < 0) throw UsageError(path.string() + ": cannot be read: " + reason(opened));
  const int fd = opened.fd;
  const auto refuse_size = [&](std::uint64_t bytes) {
    if (!folder.of_run() || bytes <= kMostOfRun_bytes) return;
    close(fd);
    throw UsageError(path.string() + ": has more than " + std::to_string(kMostOfRun_bytes) +
                     " bytes, which no document of a run has");
  };
  struct stat found {};
  if (fstat(fd, &found) == 0) refuse_size(std::uint64_t(found.st_size));
  std::string text;
  for (;;) {
    const std::size_t before = text.size();
    text.resize(before + kBlock);
    const ssize_t n = read(fd, text.data() + before, kBlock);
    const int error = errno;
    text.resize(before + (n > 0 ? std::size_t(n) : 0));
    refuse_size(text.size());  // it grows
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
    path = record::output_target(named);
  } catch (const record::FileError& e) {
    throw UsageError(e.what());
  }
  const record::PartFile part(path.string() + kPart);
  const fs::path& temporary = part.path();
  const record::FolderOfFile folder(path);
  const record::OpenedFile opened =
      folder.open(folder.name() + kPart, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW);
  if (const int e = opened.error; e == ENOSPC || e == EDQUOT || e == EIO) fail(path, std::strerror(e));
  if (opened.fd < 0) throw UsageError(named.string() + ": cannot be written: " + reason(opened));
  const int fd = opened.fd;
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
  const int close_error = errno;
  const int error = !synced ? sync_error : !closed ? close_error : folder.take_place(folder.name() + kPart);
  if (error == 0) return;
  unlink(temporary.c_str());
  fail(path, std::strerror(error));
}

}  // namespace firn
