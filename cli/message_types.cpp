#include "cli/message_types.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "files/nearest.h"
#include "files/record/event_format.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runs/migrate/table.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxBytes = 16 << 20;  // of one .lcm file
constexpr std::size_t kMaxKnown = 4096;         // fingerprints that are kept

std::vector<TypeFile> files_of(const std::vector<std::string>& folders, std::vector<std::string>& problems) {
  std::vector<TypeFile> files;
  for (const std::string& folder : folders) {
    std::vector<fs::path> paths;
    std::error_code error;
    if (fs::is_directory(folder, error)) {
      for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
        if (it->path().extension() == ".lcm" && it->is_regular_file(error)) paths.push_back(it->path());
      if (error) throw UsageError(folder + ": " + error.message());
      if (paths.empty()) throw UsageError(folder + ": no .lcm file of a type in this folder");
    } else {
      paths.push_back(folder);
    }
    std::ranges::sort(paths);
    for (const fs::path& path : paths) {
      if (fs::file_size(path, error) > kMaxBytes && !error)
        problems.push_back(path.string() + ": longer than 16 MiB: a log, not the text of a type?");
      else
        files.push_back({path.string(), read_file(path)});
    }
  }
  return files;
}

std::string letters(std::string_view name) {
  std::string out;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c))) out += char(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

std::string_view without_ending(std::string_view type) {
  return type.ends_with("_t") ? type.substr(0, type.size() - 2) : type;
}

}  // namespace

MessageTypes::MessageTypes(const std::vector<std::string>& folders)
    : others_(Schema::parse_files(files_of(folders, problems_), problems_)) {
  if (!folders.empty() && others_.readable().empty())
    throw UsageError(folders.front() + ": no type that can be read" +
                     (problems_.empty() ? "" : ": " + problems_.front()));
}

const std::vector<const schema::Type*>& MessageTypes::of(std::span<const std::byte> message) const {
  static const std::vector<const schema::Type*> none;
  if (message.size() < 8) return none;
  const std::int64_t fingerprint = std::int64_t(record::big64(message.data()));
  if (const auto it = known_.find(fingerprint); it != known_.end()) return it->second;
  std::vector<const schema::Type*> types = others_.all_of(fingerprint);
  const schema::Type* own = runs::MigrationTable::builtin().type_of(message);
  const bool same = own && std::ranges::any_of(types, [&](const schema::Type* t) {
                      return full_name(*t) == full_name(*own);
                    });
  if (own && !same) types.push_back(own);
  if (known_.size() >= kMaxKnown) known_.clear();
  return known_[fingerprint] = std::move(types);
}

const schema::Type* MessageTypes::nearest_name(std::string_view channel) const {
  const std::string wanted = letters(channel.substr(0, 200));
  const schema::Type* best = nullptr;
  std::size_t best_distance = 0;
  const auto consider = [&](const schema::Type& type) {
    const std::string name = letters(without_ending(type.name));
    if (name.empty() || wanted.empty()) return;
    const bool within = name.size() > 2 && wanted.find(name) != wanted.npos;
    const std::size_t distance = within ? (wanted.size() - name.size()) / 4 : edit_distance(wanted, name);
    if (!within && 2 * distance > std::max(wanted.size(), name.size())) return;
    if (best && distance >= best_distance) return;
    best = &type;
    best_distance = distance;
  };
  for (const schema::Type* type : others_.readable()) consider(*type);
  for (const schema::Type* type : Schema::builtin().readable()) consider(*type);
  return best;
}

MessageTypes::Nearest MessageTypes::nearest_to(std::string_view channel,
                                               std::span<const std::byte> message) const {
  auto it = near_.find(channel);
  if (it == near_.end()) {
    if (near_.size() >= kMaxKnown) near_.clear();
    it = near_.emplace(channel, nearest_name(channel)).first;
  }
  const schema::Type* type = it->second;
  return {type, type && message.size() >= 8 && !check_members(*type, message)};
}

std::string full_name(const schema::Type& type) {
  return type.package.empty() ? type.name : type.package + "." + type.name;
}

std::optional<std::string> not_lcm(std::string_view channel, std::span<const std::byte> message) {
  if (channel == "LCM_SELF_TEST") return "LCM's self test";
  if (message.size() < 8) return std::to_string(message.size()) + " bytes, no fingerprint";
  const bool text = std::ranges::all_of(message.first(message.size() - 1), [](std::byte b) {
    const auto c = unsigned(b);
    return (c >= 0x20 && c < 0x7f) || c == '\n' || c == '\r' || c == '\t';
  });
  const auto last = unsigned(message.back());
  if (text && (last == 0 || last == '\n' || (last >= 0x20 && last < 0x7f))) return "text";
  return {};
}

}  // namespace firn
