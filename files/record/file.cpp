#include "files/record/file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "files/record/open_file.h"
#include "files/record/packed.h"
#include "files/record/pages.h"

namespace firn::record {

FileError::FileError(const std::filesystem::path& p, std::uint64_t at, const std::string& what, int e)
    : std::runtime_error(p.string() + ": byte " + std::to_string(at) + ": " + what + ": " +
                         std::generic_category().message(e)),
      path(p),
      offset(at),
      error(e) {}

bool FileError::disk_full() const { return error == ENOSPC || error == EDQUOT || error == EFBIG; }

File::File(const std::filesystem::path& path, Mode mode) : path_(path) {
  const int flags = O_RDWR | O_CREAT | O_CLOEXEC | (mode == Mode::kCreate ? O_EXCL : 0);
  const OpenedFile opened = open_file(path, flags);
  if (opened.fd < 0)
    throw FileError(path, 0,
                    opened.what             ? opened.what
                    : mode == Mode::kCreate ? "cannot create"
                                            : "cannot open",
                    opened.error);
  fd_ = opened.fd;
  if (::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    const int e = errno;
    ::close(fd_);
    throw FileError(path, 0, "is being written by another process", e);
  }
  const off_t end = ::lseek(fd_, 0, SEEK_END);
  position_ = end < 0 ? 0 : std::uint64_t(end);
}

File::~File() {
  if (fd_ >= 0) ::close(fd_);
}

void File::write(std::span<iovec> parts) {
  std::size_t first = 0;
  while (true) {
    while (first < parts.size() && parts[first].iov_len == 0) ++first;
    if (first == parts.size()) return;
    const ssize_t n = ::pwritev(fd_, parts.data() + first, int(parts.size() - first), off_t(position_));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const int e = n < 0 ? errno : ENOSPC;
      std::size_t left = 0;
      for (std::size_t i = first; i < parts.size(); ++i) left += parts[i].iov_len;
      throw FileError(path_, position_, "cannot write " + std::to_string(left) + " bytes", e);
    }
    position_ += std::uint64_t(n);
    std::size_t done = std::size_t(n);
    while (done > 0) {  // the kernel may take fewer bytes than offered
      const std::size_t part = std::min(done, parts[first].iov_len);
      parts[first].iov_base = static_cast<char*>(parts[first].iov_base) + part;
      parts[first].iov_len -= part;
      done -= part;
      if (parts[first].iov_len == 0) ++first;
    }
  }
}

void File::overwrite(std::uint64_t offset, std::span<const std::byte> bytes) {
  const std::uint64_t end = std::exchange(position_, offset);
  iovec part{const_cast<std::byte*>(bytes.data()), bytes.size()};
  write({&part, 1});
  position_ = end;
}

void File::truncate(std::uint64_t size) {
  if (::ftruncate(fd_, off_t(size)) != 0) throw FileError(path_, size, "cannot truncate", errno);
  position_ = size;
}

void File::sync() {
  if (::fdatasync(fd_) != 0) throw FileError(path_, position_, "cannot sync", errno);
  if (!folder_synced_) sync_folder(path_.has_parent_path() ? path_.parent_path() : ".");
  folder_synced_ = true;
}

void File::close() {
  if (fd_ < 0) return;
  const int fd = std::exchange(fd_, -1);
  if (::close(fd) != 0 && errno != EINTR) throw FileError(path_, position_, "cannot close", errno);
}

MappedFile::MappedFile(const std::filesystem::path& path, Packed packed) {
  const OpenedFile opened = open_file(path, O_RDONLY);
  if (opened.fd < 0) throw FileError(path, 0, opened.what ? opened.what : "cannot open", opened.error);
  const int fd = opened.fd;
  struct stat status {};
  int e = ::fstat(fd, &status) == 0 ? 0 : errno;
  if (!e && !S_ISREG(status.st_mode)) e = S_ISDIR(status.st_mode) ? EISDIR : EINVAL;
  if (!e && status.st_size > 0) {
    void* at = ::mmap(nullptr, std::size_t(status.st_size), PROT_READ, MAP_PRIVATE, fd, 0);
    if (at == MAP_FAILED)
      e = errno;
    else
      bytes_ = {static_cast<const std::byte*>(at), std::size_t(status.st_size)};
  }
  ::close(fd);
  if (e) throw FileError(path, 0, "cannot map", e);
  if (packed == Packed::kAsIs || !is_packed(bytes_)) return;
  const MappedFile stored(std::move(*this));
  Pages plain = unpack(path, stored.bytes());
  of_file_ = plain.of_file();
  bytes_ = plain.release();
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

void MappedFile::forget_before(std::uint64_t offset) const {
  constexpr std::uint64_t kBlock_bytes = 2 << 20;  // a multiple of any page; a run has ten files
  if (!of_file_ || offset < forgotten_ + 2 * kBlock_bytes) return;
  const std::uint64_t until = std::min<std::uint64_t>(offset, bytes_.size()) / kBlock_bytes * kBlock_bytes;
  forget_pages(bytes_, forgotten_, until);
  forgotten_ = until;
}

void MappedFile::forget() const {
  if (of_file_) forget_pages(bytes_, 0, bytes_.size());
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : bytes_(std::exchange(other.bytes_, {})), forgotten_(other.forgotten_), of_file_(other.of_file_) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(bytes_, other.bytes_);
  std::swap(forgotten_, other.forgotten_);
  std::swap(of_file_, other.of_file_);
  return *this;
}

std::filesystem::path save_torn_tail(const std::filesystem::path& path, std::span<const std::byte> tail) {
  for (int n = 1;; ++n) {
    const std::filesystem::path torn = path.string() + ".torn-" + std::to_string(n);
    if (std::filesystem::exists(torn)) continue;
    File copy(torn, File::Mode::kCreate);
    iovec part{const_cast<std::byte*>(tail.data()), tail.size()};
    copy.write({&part, 1});
    copy.sync();
    return torn;
  }
}

void sync_folder(const std::filesystem::path& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) throw FileError(folder, 0, "cannot open folder", errno);
  const int e = ::fsync(fd) == 0 ? 0 : errno;
  ::close(fd);
  if (e) throw FileError(folder, 0, "cannot sync folder", e);
}

}  // namespace firn::record
