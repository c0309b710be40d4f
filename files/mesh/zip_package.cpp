#include "files/mesh/zip_package.h"

#include <fmt/core.h>
#include <zip.h>

#include <array>

#include "files/usage_error.h"

namespace firn::mesh {
namespace {

// Text of facets packs to a tenth; a thousandth is deflate's own bound.
constexpr std::uint64_t kMaxRatio = 200, kFreeBytes = std::uint64_t(64) << 20;
constexpr std::size_t kShownName = 60;

class Error {
 public:
  Error() { zip_error_init(&error_); }
  ~Error() { zip_error_fini(&error_); }
  Error(const Error&) = delete;
  Error& operator=(const Error&) = delete;
  zip_error_t* get() { return &error_; }
  std::string text() { return zip_error_strerror(&error_); }

 private:
  zip_error_t error_;
};

std::string without_slash(std::string_view part) {
  return std::string(part.starts_with('/') ? part.substr(1) : part);
}

}  // namespace

void ZipPackage::Close::operator()(zip* archive) const { zip_discard(archive); }

ZipPackage::ZipPackage(Bytes bytes, const std::string& name)
    : name_(name), limit_(kFreeBytes + kMaxRatio * bytes.size()), packed_(bytes.size()) {
  Error error;
  zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, error.get());
  if (source) archive_.reset(zip_open_from_source(source, ZIP_RDONLY, error.get()));
  if (archive_) return;
  if (source) zip_source_free(source);
  throw UsageError(fmt::format("{}: is no ZIP archive, as a 3MF file is, or is cut: {}", name, error.text()));
}

std::vector<std::string> ZipPackage::parts() const {
  std::vector<std::string> names;
  const zip_int64_t count = zip_get_num_entries(archive_.get(), 0);
  for (zip_int64_t n = 0; n < count; ++n)
    if (const char* part = zip_get_name(archive_.get(), zip_uint64_t(n), 0)) names.emplace_back(part);
  return names;
}

bool ZipPackage::has(std::string_view part) const {
  return zip_name_locate(archive_.get(), without_slash(part).c_str(), ZIP_FL_NOCASE) >= 0;
}

void ZipPackage::read(std::string_view part, const std::function<void(std::string_view)>& sink) {
  const std::string wanted = without_slash(part);
  const auto fail = [&](const std::string& problem) {
    throw UsageError(fmt::format("{}: {}: {}", name_, wanted.substr(0, kShownName), problem));
  };
  const zip_int64_t index = zip_name_locate(archive_.get(), wanted.c_str(), ZIP_FL_NOCASE);
  if (index < 0) fail("the archive has no such part");
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(
      zip_fopen_index(archive_.get(), zip_uint64_t(index), 0), &zip_fclose);
  if (!file) fail(std::string("cannot be unpacked: ") + zip_strerror(archive_.get()));
  std::array<char, 1 << 16> block;
  for (;;) {
    const zip_int64_t got = zip_fread(file.get(), block.data(), block.size());
    if (got < 0) fail(std::string("cannot be unpacked: ") + zip_file_strerror(file.get()));
    if (got == 0) return;
    unpacked_ += std::uint64_t(got);
    if (unpacked_ > limit_)
      fail(fmt::format("unpacks to more than {} bytes, the limit for a file of {}", limit_, packed_));
    sink({block.data(), std::size_t(got)});
  }
}

}  // namespace firn::mesh
