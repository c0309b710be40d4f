// run_help shows a page of the documents, or the sections and keys that a topic is found in.
#include "cli/commands.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "config/find_key.h"
#include "files/exit_codes.h"
#include "files/lowercase.h"
#include "files/nearest.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runtime/source_folder.h"

namespace firn {
namespace {

struct HelpOptions {
  std::vector<std::string> topic;  ///< words; empty: the list of pages
};

namespace fs = std::filesystem;

struct Page {
  std::string name;  ///< "commands/print"
  std::string title, text;
};

struct Section {
  const Page* page;
  std::string heading, text;
};

bool has_all(const std::string& text, const std::vector<std::string>& words) {
  const std::string in = lowercase(text);
  return std::ranges::all_of(
      words, [&](const std::string& w) { return in.find(lowercase(w)) != std::string::npos; });
}

std::vector<Page> pages() {
  const fs::path docs = source_folder() / "docs";
  if (!fs::is_directory(docs)) throw UsageError(docs.string() + ": the documents are not there");
  std::vector<Page> all;
  for (const auto& entry : fs::recursive_directory_iterator(docs)) {
    if (entry.path().extension() != ".md") continue;
    Page p;
    p.name = entry.path().lexically_relative(docs).replace_extension().generic_string();
    p.text = read_file(entry.path());
    p.title = p.text.substr(0, p.text.find('\n'));
    p.title.erase(0, p.title.find_first_not_of("# "));
    all.push_back(std::move(p));
  }
  std::ranges::sort(all, {}, &Page::name);
  return all;
}

// The sections of a page; the text above its first heading is one too, under the page's title.
std::vector<Section> sections(const Page& page) {
  std::vector<Section> all{{&page, page.title, ""}};
  std::istringstream in(page.text);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("## ")) all.push_back({&page, line.substr(3), ""});
    all.back().text += line + "\n";
  }
  return all;
}

const Page* page_of(const std::vector<Page>& all, const std::string& topic) {
  for (const Page& p : all)
    if (p.name == "commands/" + topic || p.name == topic || fs::path(p.name).filename() == topic) return &p;
  return nullptr;
}

// The last part of the name of the page whose name is spelt nearly so; "" if none is.
std::string likeliest_page(const std::vector<Page>& all, const std::string& topic) {
  std::vector<std::string> names;
  for (const Page& p : all) names.push_back(fs::path(p.name).filename());
  return nearest(topic, {names.begin(), names.end()});
}

/// @returns 0, or 1 when nothing mentions the topic
int run_help(const HelpOptions& options) {
  const std::vector<Page> all = pages();
  if (options.topic.empty()) {
    for (const Page& p : all) fmt::print("{:<34} {}\n", p.name, p.title);
    fmt::print(
        "\nfirn help TOPIC shows a page, or where a word is found; firn COMMAND --help lists options\n");
    return kOk;
  }
  if (const Page* page = options.topic.size() == 1 ? page_of(all, options.topic.front()) : nullptr) {
    std::fputs(page->text.c_str(), stdout);
    return kOk;
  }
  std::vector<Section> headed;
  for (const Page& p : all)
    for (Section& s : sections(p))
      if (has_all(s.heading, options.topic)) headed.push_back(std::move(s));
  if (headed.size() == 1) fmt::print("{}: {}\n", headed[0].page->name, headed[0].text);
  bool found = !headed.empty();
  if (headed.size() > 1)
    for (const Section& s : headed) fmt::print("{}: {}\n", s.page->name, s.heading);
  for (const Page& p : all)
    for (const Section& s : sections(p))
      if (!has_all(s.heading, options.topic) && has_all(s.text, options.topic)) {
        fmt::print("{}: {}\n", p.name, s.heading);
        found = true;
      }
  std::string query;
  for (const std::string& w : options.topic) query += w + " ";
  Experiment defaults;
  const std::vector<Field> table = fields(defaults);
  for (const Field* f : find_fields(table, query)) {
    fmt::print("key {}: {}\n", f->key, f->meaning);
    found = true;
  }
  if (found) return kOk;
  const std::string near = options.topic.size() == 1 ? likeliest_page(all, options.topic.front()) : "";
  if (near.empty())
    fmt::print(stderr, "no page, section or key mentions it; firn help lists the pages\n");
  else
    fmt::print(stderr, "firn help: no page {}; did you mean: firn help {}\n", options.topic.front(), near);
  return kFailed;
}

}  // namespace

void declare_help(OptionSet& options) {
  auto& o = options.calls(run_help);
  options.option("TOPIC", o.topic, "page, command or words to find; without it: the list of pages");
}

}  // namespace firn
