// reproduce() computes every table and figure of the papers, with the paper's value beside ours, for firn
// reproduce. A part is one function that makes rows and pictures; one table lists all parts
// (reproduce_parts.cpp), one file per paper and part.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "studies/reproduce/row.h"

namespace firn {

struct ReproducePicture {
  std::string name;     ///< file name without its extension, [a-z0-9-]
  std::string caption;  ///< plain text
  std::string svg;      ///< one <svg> that uses the classes and colours of report/draw/style.cpp
};

/// Collects a part's rows, pictures and progress, and holds the options of its computation.
class Reproduction {
 public:
  virtual ~Reproduction() = default;
  /// @throws std::logic_error: a row of another part, one without a printed or derived value (a self-check),
  /// a printed value without a place, a row that is neither compared nor said to be not identifiable
  virtual void row(ReproduceRow row) = 0;
  /// Adds a number of ours that the paper does not print.
  virtual void beside(BesideRow row) = 0;
  virtual void picture(ReproducePicture picture) = 0;
  /// Adds a paragraph before the part's rows on the page: the choices and their reasons. Plain text.
  virtual void note(std::string text) = 0;
  /// Reports the fraction of the part that is done, 0 to 1, and the current step.
  virtual void progress(double fraction, std::string_view doing) = 0;
  /// True: the minimum number of repeats that makes sense (tests). Rows of many seeds then state their
  /// number.
  virtual bool quick() const = 0;
  /// Threads that the part may use, >= 1. The rows must not depend on it.
  virtual int threads() const = 0;
  /// A mesh to slice instead of the one made in code; empty = that one.
  virtual std::string mesh() const { return ""; }
};

struct ReproducePart {
  const char* paper;  ///< "lu", "barnett", "thompson"
  const char* name;   ///< row ids begin with <paper>.<name>.
  const char* what;   ///< the figures and tables of the paper
  double seconds;     ///< about, on one core; for the ETA before anything is known
  void (*run)(Reproduction&);
};
/// In the papers' order.
const std::vector<ReproducePart>& reproduce_parts();

struct ReproduceOptions {
  std::string paper;  ///< empty = all
  std::vector<std::string>
      only;  ///< parts or rows: an id or the front of one up to a '.', the paper's name may be left out
  bool quick = false;
  int threads = 0;   ///< 0 = as many as the machine has
  std::string mesh;  ///< of barnett.slicing, instead of the one made in code
};

/// Holds one part's outcome. A part that throws gives the reason in `error`, and its rows are void.
struct PartResult {
  ReproducePart part;
  std::vector<std::string> notes;
  std::vector<ReproduceRow> rows;
  std::vector<BesideRow> beside;
  std::vector<ReproducePicture> pictures;
  std::string error;
};

/// Runs the wanted parts in order. @throws UsageError for an unknown paper or id, with the nearest known one
std::vector<PartResult> reproduce(const ReproduceOptions& options, const std::vector<ReproducePart>& parts);

/// Holds numbers of rows by verdict.
struct VerdictCounts {
  int rows = 0, fitted = 0, unexpected = 0;
  std::array<int, std::size(kVerdicts)> of{};             ///< by Verdict
  std::array<int, std::size(kRowKinds)> reproduced_of{};  ///< of the reproduced ones, by RowKind
};
/// Returns "18 number, 20 number with fit, 40 wording, 12 arithmetic".
std::string kinds_in_words(const VerdictCounts& counts);
/// @param paper of the rows; empty = all
VerdictCounts count_verdicts(const std::vector<PartResult>& results, std::string_view paper = {});

/// Returns true when every part was computed and no row fails (ReproduceRow::fails).
bool all_pass(const std::vector<PartResult>& results);

std::string reproduce_table(const std::vector<PartResult>& results);
std::string reproduce_json(const std::vector<PartResult>& results);
/// Returns one self-contained page: no network, no script.
std::string reproduce_page(const std::vector<PartResult>& results);

}  // namespace firn
