// Every table and figure of the papers that firn reproduce shows, with few repeats; the full counts are the
// command's.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "studies/reproduce/reproduce.h"

using namespace firn;

namespace {

namespace fs = std::filesystem;

// Made once for all tests.
const std::vector<PartResult>& quick(const std::string& paper) {
  static std::map<std::string, std::vector<PartResult>> made;
  if (!made.contains(paper)) {
    ReproduceOptions options;
    options.paper = paper;
    options.quick = true;
    made[paper] = reproduce(options, reproduce_parts());
  }
  return made[paper];
}

constexpr const char* kPapers[] = {"lu", "barnett", "thompson"};

std::vector<ReproduceRow> all_rows() {
  std::vector<ReproduceRow> rows;
  for (const char* paper : kPapers)
    for (const PartResult& part : quick(paper)) rows.insert(rows.end(), part.rows.begin(), part.rows.end());
  return rows;
}

void check_paper(const std::string& paper, std::size_t min_rows) {
  std::set<std::string> ids, pictures;
  std::size_t agree = 0;
  for (const PartResult& part : quick(paper)) {
    INFO(part.part.name << ": " << part.error);
    CHECK(part.error.empty());
    for (const ReproduceRow& row : part.rows) {
      INFO(row.id << ": " << row.what << ": printed " << text_of(row.printed.value, row.decimals, row.unit)
                  << ", derived " << text_of(row.derived.value, row.decimals, row.unit) << ", ours "
                  << text_of(row.ours, row.decimals, row.unit) << ", tolerance " << row.tolerance);
      CHECK_FALSE(row.fails());
      CHECK(ids.insert(row.id).second);
      agree += row.verdict() == Verdict::kReproduced || row.verdict() == Verdict::kDerived;
    }
    for (const BesideRow& row : part.beside) CHECK(ids.insert(row.id).second);
    for (const ReproducePicture& picture : part.pictures) {
      INFO(picture.name);
      CHECK(pictures.insert(picture.name).second);
      CHECK(picture.svg.starts_with("<svg "));
    }
  }
  CHECK(agree >= min_rows);
}

/// All numbers of a text; "118 604" is one of them as well as two.
std::vector<double> numbers_of(const std::string& text) {
  const auto digit = [&](std::size_t n) {
    return n < text.size() && std::isdigit(static_cast<unsigned char>(text[n]));
  };
  std::vector<double> numbers;
  for (std::size_t n = 0; n < text.size(); ++n) {
    if (!digit(n) || (n > 0 && digit(n - 1))) continue;
    std::size_t end = n;
    while (digit(end)) ++end;
    std::size_t grouped = end;
    while (grouped < text.size() && text[grouped] == ' ' && digit(grouped + 1) && digit(grouped + 2) &&
           digit(grouped + 3) && !digit(grouped + 4))
      grouped += 4;
    if (grouped > end) {
      std::string joined = text.substr(n, grouped - n);
      std::erase(joined, ' ');
      for (std::size_t more = joined.size(); more > end - n; more -= 3)
        numbers.push_back(std::atof(joined.substr(0, more).c_str()));
    }
    if (end + 1 < text.size() && text[end] == '.' && digit(end + 1)) {
      ++end;
      while (digit(end)) ++end;
    }
    numbers.push_back(std::atof(text.substr(n, end - n).c_str()));
    n = end - 1;
  }
  return numbers;
}

bool holds_number(const std::string& text, double number) {
  return std::ranges::any_of(numbers_of(text),
                             [&](double n) { return std::abs(n - std::abs(number)) < 1e-12; });
}

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

/// One space between words: the texts break lines and tables as they were scanned.
std::string with_single_spaces(const std::string& text) {
  std::string s;
  for (const char c : text) {
    const bool space = std::isspace(static_cast<unsigned char>(c));
    if (!space || (!s.empty() && s.back() != ' ')) s += space ? ' ' : c;
  }
  return s;
}

/// The paper's text, which stays outside the repository; empty where there is none.
std::string text_of_paper(const std::string& paper) {
  const std::map<std::string, std::string> files{{"lu", "lu2015-layer-to-layer.txt"},
                                                 {"barnett", "barnett2012-ice-thesis.txt"},
                                                 {"thompson", "thompson2014-path-planning.txt"}};
  for (const char* folder : {"/../shared/seeds/", "/../../shared/seeds/"}) {
    std::ifstream file(std::string(FIRN_SOURCE_DIR) + folder + files.at(paper));
    if (file) return with_single_spaces({std::istreambuf_iterator<char>(file), {}});
  }
  return "";
}

std::string paper_of(const ReproduceRow& row) { return row.id.substr(0, row.id.find('.')); }

}  // namespace

TEST_CASE("No row of firn reproduce thompson disagrees for an unknown reason", "[seeds]") {
  check_paper("thompson", 13);
}
TEST_CASE("No row of firn reproduce barnett disagrees for an unknown reason", "[seeds]") {
  check_paper("barnett", 30);
}
TEST_CASE("No row of firn reproduce lu disagrees for an unknown reason", "[seeds]") { check_paper("lu", 22); }

TEST_CASE("No row is a self-check: each has a printed or derived value that ours does not repeat bit for bit",
          "[seeds]") {
  // Counts, zeros and closed forms of the planners' arithmetic are met exactly.
  const std::set<std::string> exact{"lu.identification.recovery", "barnett.pulses.count",
                                    "barnett.pulses.rectangle",   "thompson.corners.fig9-transit-speed",
                                    "thompson.misprints.eq37",    "thompson.misprints.fig5"};
  for (const ReproduceRow& row : all_rows()) {
    INFO(row.id);
    CHECK_FALSE((is_none(row.printed.value) && is_none(row.derived.value)));
    const auto* ours = std::get_if<double>(&row.ours);
    if (!ours || *ours == 0.0 || exact.contains(row.id)) continue;
    for (const RowValue& value : {row.printed.value, row.derived.value})
      if (const auto* number = std::get_if<double>(&value)) CHECK(*number != *ours);
  }
}

TEST_CASE("One printed value is one row", "[seeds]") {
  std::map<std::string, std::string> row_of;
  for (const ReproduceRow& row : all_rows()) {
    if (is_none(row.printed.value)) continue;
    const auto [known, first] =
        row_of.emplace(paper_of(row) + "|" + row.printed.place + "|" +
                           text_of(row.printed.value, 6, row.unit) + "|" + row.printed.quote,
                       row.id);
    INFO(row.id << " and " << known->second << ": " << row.printed.quote);
    CHECK(first);
  }
}

TEST_CASE("Every wording that is judged has its threshold beside it", "[seeds]") {
  for (const ReproduceRow& row : all_rows()) {
    if (row.kind() != RowKind::kWording || row.verdict() == Verdict::kNotIdentifiable) continue;
    INFO(row.id);
    CHECK_FALSE(row.tolerance.empty());
  }
}

TEST_CASE("Every printed value has its page and stands in the paper's own words, or is read off a figure",
          "[seeds]") {
  for (const ReproduceRow& row : all_rows()) {
    if (is_none(row.printed.value)) continue;
    INFO(row.id << ": " << row.printed.place << ": " << row.printed.quote);
    CHECK(row.printed.place.starts_with("p. "));
    const char page = row.printed.place.at(3);  // a number, or a small Roman one before the first
    CHECK((std::isdigit(static_cast<unsigned char>(page)) ||
           std::string("ivx").find(page) != std::string::npos));
    if (row.printed.quote.empty()) {
      CHECK(row.printed.place.find("Fig.") != std::string::npos);
      continue;
    }
    if (const auto* number = std::get_if<double>(&row.printed.value)) {
      CHECK(holds_number(row.printed.quote, *number));
    } else {
      const std::string words = std::get<std::string>(row.printed.value);
      const std::vector<double> numbers = numbers_of(words);
      for (const double n : numbers) CHECK(holds_number(row.printed.quote, n));
      if (numbers.empty()) CHECK(lower(row.printed.quote).find(lower(words)) != std::string::npos);
    }
    // Where the papers' texts are at hand.
    const std::string paper = text_of_paper(paper_of(row));
    if (!paper.empty()) CHECK(paper.find(with_single_spaces(row.printed.quote)) != std::string::npos);
  }
}
