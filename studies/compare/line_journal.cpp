#include "studies/compare/line_journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <span>
#include <stdexcept>

#include "files/record/checksum.h"
#include "files/text_file.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr std::size_t kDigits = 16;  // of the checksum; a space follows

std::string checksum_of(std::string_view text) {
  char hex[kDigits + 1];
  std::snprintf(hex, sizeof hex, "%016llx",
                static_cast<unsigned long long>(record::checksum64(std::as_bytes(std::span(text)))));
  return hex;
}

}  // namespace

LineJournal::LineJournal(const std::filesystem::path& path, const std::string& busy) : path_(path) {
  fd_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (fd_ < 0) throw UsageError(path.string() + ": cannot be opened: " + std::strerror(errno));
  if (::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    ::close(fd_);
    throw UsageError(busy);
  }
}

LineJournal::~LineJournal() { ::close(fd_); }

std::vector<LineJournal::Line> LineJournal::lines() {
  const std::string text = read_file(path_);
  torn_ = !text.empty() && text.back() != '\n';
  return lines_of(text);
}

std::vector<LineJournal::Line> LineJournal::lines_of(std::string_view text) {
  std::vector<Line> lines;
  std::size_t number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = text.substr(at, end - at);
    at = end + 1;
    ++number;
    if (line.empty()) continue;
    const bool right = line.size() > kDigits + 1 && line[kDigits] == ' ' &&
                       checksum_of(line.substr(kDigits + 1)) == line.substr(0, kDigits);
    lines.push_back({number, std::string(right ? line.substr(kDigits + 1) : line), right});
  }
  return lines;
}

std::vector<LineJournal::Line> LineJournal::read(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  return lines_of(std::string_view(text).substr(0, text.rfind('\n') + 1));
}

void LineJournal::append(std::string_view text) {
  const std::string line = (torn_ ? "\n" : "") + checksum_of(text) + " " + std::string(text) + "\n";
  torn_ = false;
  std::size_t done = 0;
  while (done < line.size()) {
    const ssize_t n = ::write(fd_, line.data() + done, line.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw std::runtime_error(path_.string() + ": cannot be written: " + std::strerror(errno));
    done += std::size_t(n);
  }
}

}  // namespace firn
