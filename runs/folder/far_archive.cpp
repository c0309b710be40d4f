#include "runs/folder/far_archive.h"

#include <array>
#include <sstream>
#include <stdexcept>

#include "files/command.h"
#include "files/run_paths.h"
#include "files/usage_error.h"
#include "runs/folder/run_folder.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

// A socket's path has at most 108 bytes, so that TMPDIR may be too long a place.
constexpr const char* kScratchPlace = "/tmp";

constexpr const char* kConnection =
    "ssh -o BatchMode=yes -o ConnectTimeout=10 -o ControlMaster=auto "
    "-o ControlPersist=60 -o ControlPath=";

}  // namespace

std::optional<FarPlace> far_place(const std::string& word) {
  const std::size_t colon = word.find(':');
  if (colon == word.npos || word.find('/') < colon) return std::nullopt;
  FarPlace place{word.substr(0, colon), word.substr(colon + 1)};
  if (place.host.empty() || place.host.front() == '-')
    throw UsageError(word + ": HOST:PATH wants the name of a computer before the colon");
  if (place.path.empty() || place.path.front() == '-')
    throw UsageError(word + ": HOST:PATH wants a folder behind the colon, full or below the home folder");
  return place;
}

FarArchive::FarArchive(FarPlace place) : place_(std::move(place)), scratch_("sync", kScratchPlace) {
  try {
    std::istringstream all(
        there("mkdir -p -- " + shell_word(place_.path) + " && ls -a -- " + shell_word(place_.path)));
    for (std::string name; std::getline(all, name);) names_.insert(name);
  } catch (const std::runtime_error& e) {
    throw UsageError(e.what());
  }
}

FarArchive::~FarArchive() {
  try {
    run_command(
        {"ssh", "-o", "ControlPath=" + (scratch_ / "line").string(), "-O", "exit", "--", place_.host});
  } catch (const std::exception&) {  // the connection ends by itself
  }
}

std::string FarArchive::there(const std::string& command) const {
  std::vector<std::string> words;
  std::istringstream options(kConnection + (scratch_ / "line").string());
  for (std::string word; options >> word;) words.push_back(word);
  words.insert(words.end(), {"--", place_.host, command});
  const CommandEnd end = run_command(std::move(words));
  if (end.missing()) throw UsageError("ssh is not installed: apt install openssh-client");
  if (end.code != 0) throw std::runtime_error(place_.host + ": " + end.reason());
  return end.output;
}

std::string FarArchive::folder(const std::string& name) const {
  return place_.host + ":" + place_.path + "/" + name + "/";
}

fs::path FarArchive::look(const std::string& name) {
  if (!names_.contains(name)) return {};
  const fs::path seen = scratch_ / "seen" / name;
  fs::create_directories(seen);
  const std::vector<std::string> how{"-e",
                                     kConnection + (scratch_ / "line").string(),
                                     "--protect-args",
                                     "--include=/seals/***",
                                     std::string("--include=/") + RunPaths::kNotes,
                                     std::string("--include=/") + RunPaths::kProvenance,
                                     std::string("--include=/") + RunPaths::kExperiment,
                                     "--include=/nodes/",
                                     "--exclude=*"};
  rsync_run(how, folder(name), seen.string() + "/", nullptr);
  return seen;
}

void FarArchive::send(const fs::path& run, const std::string& name, bool renews, bool thorough,
                      const std::atomic<bool>* stop) {
  std::vector<std::string> how{"-e", kConnection + (scratch_ / "line").string(), "--protect-args"};
  if (thorough) how.push_back("--checksum");
  if (renews) how.push_back("--link-dest=../" + name);
  rsync_run(how, fs::absolute(run).string() + "/", folder(kArriving + name), stop);
}

std::string FarArchive::verify(const fs::path& run, const std::string& name, const std::string&,
                               const std::atomic<bool>* stop) {
  const std::vector<std::string> how{"-e",
                                     kConnection + (scratch_ / "line").string(),
                                     "--protect-args",
                                     "--checksum",
                                     "--dry-run",
                                     "--itemize-changes"};
  std::istringstream changes(
      rsync_run(how, fs::absolute(run).string() + "/", folder(kArriving + name), stop));
  for (std::string line; std::getline(changes, line);)  // "." marks times and modes alone
    if (!line.empty() && line.front() != '.') return line.substr(line.find(' ') + 1) + " is another";
  return "";
}

void FarArchive::keep(const std::string& name, bool renews) {
  const std::string at = shell_word("./" + name), arriving = shell_word("./" + (kArriving + name)),
                    going = shell_word("./" + (kRemoving + name));
  std::string command = "cd -- " + shell_word(place_.path);
  if (renews)
    command += " && rm -rf " + going + " && mv " + at + " " + going;
  else
    command += " && test ! -e " + at;
  command += " && mv " + arriving + " " + at + " && sync && rm -rf " + going;
  there(command);
  names_.insert(name);
}

}  // namespace firn::runs
