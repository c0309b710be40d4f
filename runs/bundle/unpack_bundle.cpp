#include <zip.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <memory>
#include <set>

#include "core/options/number.h"
#include "files/digest.h"
#include "files/json.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "lcmtypes/utf8.h"
#include "runs/bundle/bundle.h"
#include "runs/bundle/crate.h"
#include "runs/folder/run_folder.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxRatio = 200, kFreeBytes = std::uint64_t(64) << 20;  // as of meshes (files/mesh)
constexpr std::uint64_t kMaxMetadata_bytes = std::uint64_t(64) << 20;
constexpr std::size_t kMaxEntries = 100'000, kMaxName = 1000;
constexpr std::uint32_t kUnixKind = 0170000, kUnixFile = 0100000, kUnixFolder = 0040000;

struct Entry {
  zip_uint64_t index = 0;
  std::string path;  // below the root folder of the archive
  std::uint64_t bytes = 0;
};

class BundleArchive {
 public:
  explicit BundleArchive(const fs::path& file) : file_(file) {
    if (!fs::is_regular_file(file)) fail("", "no such file");
    int error = 0;
    archive_.reset(zip_open(file.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, &error));
    if (!archive_) {
      zip_error_t e;
      zip_error_init_with_code(&e, error);
      const std::string reason = zip_error_strerror(&e);
      zip_error_fini(&e);
      fail("", "is no ZIP archive, as a bundle is, or is damaged: " + reason);
    }
    look();
  }

  const std::vector<Entry>& entries() const { return entries_; }

  // Unpacks an entry piece by piece; no more than it declares.
  void read(const Entry& e, const std::function<void(std::string_view)>& sink) const {
    const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> opened(
        zip_fopen_index(archive_.get(), e.index, 0), &zip_fclose);
    if (!opened) fail(e.path, std::string("cannot be unpacked: ") + zip_strerror(archive_.get()));
    std::array<char, 1 << 16> block;
    std::uint64_t bytes = 0;
    for (;;) {
      const zip_int64_t got = zip_fread(opened.get(), block.data(), block.size());
      if (got < 0) fail(e.path, std::string("cannot be unpacked: ") + zip_file_strerror(opened.get()));
      if (got == 0) break;
      bytes += std::uint64_t(got);
      if (bytes > e.bytes)
        fail(e.path, "unpacks to more than the " + std::to_string(e.bytes) + " bytes that it declares");
      sink({block.data(), std::size_t(got)});
    }
    if (bytes != e.bytes)
      fail(e.path, "has " + std::to_string(bytes) + " bytes, and declares " + std::to_string(e.bytes));
  }

  [[noreturn]] void fail(const std::string& path, const std::string& problem) const {
    throw UsageError(file_.string() + ": " +
                     (path.empty() ? "" : valid_utf8(path.substr(0, kMaxName)) + ": ") + problem);
  }

 private:
  struct Discard {
    void operator()(zip* archive) const { zip_discard(archive); }
  };

  void look() {
    const zip_int64_t count = zip_get_num_entries(archive_.get(), 0);
    if (count < 0 || std::size_t(count) > kMaxEntries)
      fail("", "has more than " + std::to_string(kMaxEntries) + " files");
    const std::uint64_t limit = kFreeBytes + kMaxRatio * fs::file_size(file_);
    std::uint64_t sum = 0;
    std::string root;
    std::set<std::string> seen;
    for (zip_uint64_t n = 0; n < zip_uint64_t(count); ++n) {
      zip_stat_t stat;
      if (zip_stat_index(archive_.get(), n, 0, &stat) != 0 || !stat.name)
        fail("", "has an entry that cannot be read");
      const std::string name = stat.name;
      const bool folder = name.ends_with('/');
      check_name(name);
      check_kind(n, name, folder);
      if (stat.encryption_method != ZIP_EM_NONE) fail(name, "is encrypted");
      const std::size_t slash = name.find('/');
      if (slash == name.npos) fail(name, "stands beside the one folder that a bundle has");
      if (root.empty()) root = name.substr(0, slash);
      if (name.substr(0, slash) != root)
        fail(name, "a bundle has one folder, and this is a second one beside " + root);
      if (!seen.insert(name).second) fail(name, "is there twice");
      if (folder) continue;
      sum += stat.size;
      if (stat.size > limit || sum > limit)
        fail(name, "the archive unpacks to more than " + std::to_string(limit) +
                       " bytes, the limit for a file of " + std::to_string(fs::file_size(file_)));
      entries_.push_back({n, name.substr(slash + 1), stat.size});
    }
  }

  // One that leads out of the folder, or that another system reads as another name.
  void check_name(const std::string& name) const {
    if (name.empty() || name.size() > kMaxName)
      fail(name, "a name has 1 to " + std::to_string(kMaxName) + " bytes");
    for (const unsigned char c : name)
      if (c < 0x20 || c == 0x7f || c == '\\') fail(name, "a name with a control character or a backslash");
    if (name.front() == '/' || name.find(':') != name.npos)
      fail(name, "leads out of the folder: it is an absolute path");
    for (const fs::path& part : fs::path(name))
      if (part == ".." || part == ".")
        fail(name, "leads out of the folder: it has the part " + part.string());
    if (name.find("//") != name.npos) fail(name, "has an empty part");
  }

  void check_kind(zip_uint64_t n, const std::string& name, bool folder) const {
    zip_uint8_t system = 0;
    zip_uint32_t attributes = 0;
    if (zip_file_get_external_attributes(archive_.get(), n, 0, &system, &attributes) != 0 ||
        system != ZIP_OPSYS_UNIX)
      return;
    const std::uint32_t kind = (attributes >> 16) & kUnixKind;
    if (kind != 0 && kind != (folder ? kUnixFolder : kUnixFile))
      fail(name, "is a link or a device, and no file");
  }

  fs::path file_;
  std::unique_ptr<zip, Discard> archive_;
  std::vector<Entry> entries_;
};

struct Told {
  std::uint64_t bytes = 0;
  std::string sha256;
};

// The files of the metadata, by the reference of their path.
std::map<std::string, Told> told_files(const BundleArchive& archive, const std::string& metadata) {
  const auto json = nlohmann::json::parse(metadata, nullptr, false);
  const auto fail = [&](const std::string& problem) { archive.fail(kCrateMetadata, problem); };
  if (!json.is_object() || !json.contains("@graph") || !json.at("@graph").is_array())
    fail("is no RO-Crate metadata: it has no @graph");
  std::map<std::string, Told> files;
  for (const auto& entity : json.at("@graph")) {
    if (!entity.is_object() || !entity.contains("@type") || entity.at("@type") != "File") continue;
    const auto text = [&](const char* key) {
      const auto at = entity.find(key);
      return at != entity.end() && at->is_string() ? at->get<std::string>() : std::string();
    };
    std::string id = text("@id");
    if (id.starts_with("./")) id.erase(0, 2);
    const auto bytes = whole_number<std::uint64_t>(text("contentSize"));
    if (id.empty() || !bytes || !is_sha256_hex(text("sha256")))
      fail("a file without @id, contentSize or sha256: '" + id.substr(0, kMaxName) + "'");
    if (!files.emplace(id, Told{*bytes, text("sha256")}).second) fail("has two entries of " + id);
  }
  return files;
}

}  // namespace

std::vector<BundledRun> unpack_bundle(const fs::path& file, const fs::path& into) {
  const BundleArchive archive(file);
  const auto metadata_entry = std::ranges::find(archive.entries(), kCrateMetadata, &Entry::path);
  if (metadata_entry == archive.entries().end())
    archive.fail("", std::string("has no ") + kCrateMetadata + ": it is no bundle");
  if (metadata_entry->bytes > kMaxMetadata_bytes) archive.fail(kCrateMetadata, "has more than 64 MiB");
  std::string metadata;
  archive.read(*metadata_entry, [&](std::string_view piece) { metadata += piece; });
  std::map<std::string, Told> told = told_files(archive, metadata);
  for (const Entry& e : archive.entries()) {
    if (e.path == kCrateMetadata) continue;
    const auto known = told.find(uri_path(e.path));
    if (known == told.end()) archive.fail(e.path, "is not in the metadata");
    if (known->second.bytes != e.bytes)
      archive.fail(e.path, "has " + std::to_string(e.bytes) + " bytes, and the metadata says " +
                               std::to_string(known->second.bytes));
    const fs::path target = into / e.path;
    fs::create_directories(target.parent_path());
    std::ofstream out(target, std::ios::binary);
    Sha256 digest;
    archive.read(e, [&](std::string_view piece) {
      out.write(piece.data(), std::streamsize(piece.size()));
      digest.add(std::as_bytes(std::span(piece)));
    });
    out.close();
    if (!out) throw WriteError(target.string() + ": cannot be written");
    if (digest.hex() != known->second.sha256)
      archive.fail(e.path, "is not what the metadata says: another SHA-256");
    told.erase(known);
  }
  if (!told.empty()) archive.fail(told.begin()->first, "is in the metadata and not in the archive");
  std::vector<BundledRun> found;
  for (const auto& entry : fs::directory_iterator(into))
    if (is_run(entry.path())) found.push_back({entry.path().filename().string(), entry.path()});
  std::ranges::sort(found, {}, &BundledRun::name);
  if (found.empty()) archive.fail("", "holds no run");
  return found;
}

}  // namespace firn::runs
