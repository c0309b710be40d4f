#include "report/export/spool.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "files/text_file.h"
#include "files/usage_error.h"

namespace firn::report {

namespace fs = std::filesystem;

Spool::Spool(fs::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  fs::remove_all(folder_, error);
  fs::create_directories(folder_, error);
  if (error) throw UsageError(folder_.string() + ": cannot be made: " + error.message());
}

Spool::~Spool() {
  std::error_code ignored;
  if (!folder_.empty()) fs::remove_all(folder_, ignored);
}

std::size_t Spool::add(const std::string& name) {
  std::error_code error;
  fs::create_directories((folder_ / name).parent_path(), error);
  if (error) throw WriteError((folder_ / name).string() + ": " + error.message());
  files_.push_back({name, "", 0});
  return files_.size() - 1;
}

void Spool::append(std::size_t file, std::string_view bytes) {
  File& f = files_[file];
  f.buffer += bytes;
  buffered_ += bytes.size();
  if (f.buffer.size() >= kBuffer_bytes) write(f);
  if (buffered_ >= kAll_bytes) flush();
}

void Spool::write(File& file) {
  if (file.buffer.empty() && file.written > 0) return;
  const fs::path path = folder_ / file.name;
  std::FILE* out = std::fopen(path.c_str(), file.written > 0 ? "ab" : "wb");
  bool ok = out != nullptr;
  ok = ok && std::fwrite(file.buffer.data(), 1, file.buffer.size(), out) == file.buffer.size();
  ok = out && std::fclose(out) == 0 && ok;
  if (!ok)
    throw WriteError(path.string() + ": byte " + std::to_string(file.written) +
                     ": cannot be written: " + std::strerror(errno));
  file.written += file.buffer.size();
  buffered_ -= file.buffer.size();
  file.buffer.clear();
}

void Spool::flush() {
  for (File& file : files_) write(file);
}

void Spool::keep_as(const fs::path& target) {
  flush();
  std::error_code error;
  fs::rename(folder_, target, error);
  if (error) throw WriteError(target.string() + ": " + error.message());
  folder_.clear();
}

}  // namespace firn::report
