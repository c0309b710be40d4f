// reproduce() computes every table and figure of the papers, with the paper's value beside ours, for firn
// reproduce. A part is one function that makes rows and pictures; one table lists all parts
// (cli/reproduce_parts.cpp), one file per paper and part.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace firn {

/// The reference of a row's comparison. Only a measurement that the model cannot give may go without a
/// verdict.
enum class RowKind {
  kComputed,  ///< follows from the paper's equations or data
  kFit,  ///< of a set-up that the paper does not print and that was fitted to its result; a match tests the
         ///< fit
  kProperty,  ///< must hold for any input
  kMeasured,  ///< the paper's own measurement: informative, no tolerance
};
std::string_view name(RowKind kind);

/// Holds a number (with its unit in the row) or words; empty words = the paper does not print it.
using RowValue = std::variant<std::string, double>;

struct ReproduceRow {
  std::string id;  ///< <paper>.<part>.<name>, lower case, digits, '.' and '-'
  std::string what;
  RowKind kind = RowKind::kComputed;
  std::string unit;  ///< of the numbers in paper, ours and tolerance
  RowValue paper, ours;
  RowValue tolerance;  ///< number = maximum |ours - paper|; words = the bound itself; empty = informative
  std::optional<bool> pass;  ///< empty = informative
  int decimals = 2;          ///< of the table; JSON carries the full numbers
};

// Row makers. NaN never passes.

/// |ours - paper| <= tolerance
ReproduceRow row_near(std::string id, std::string what, std::string unit, double paper, double ours,
                      double tolerance, RowKind kind = RowKind::kComputed);
/// ours <= bound; `paper` is the paper's printed value, if any
ReproduceRow row_at_most(std::string id, std::string what, std::string unit, RowValue paper, double ours,
                         double bound, RowKind kind = RowKind::kComputed);
/// A yes or no with its reason in words.
ReproduceRow row_holds(std::string id, std::string what, std::string paper, std::string ours, bool holds,
                       RowKind kind = RowKind::kProperty);
/// No verdict: shown side by side only.
ReproduceRow row_informative(std::string id, std::string what, std::string unit, RowValue paper,
                             RowValue ours, RowKind kind = RowKind::kMeasured);

struct ReproducePicture {
  std::string name;     ///< file name without its extension, [a-z0-9-]
  std::string caption;  ///< plain text
  std::string svg;      ///< one <svg> that uses the classes and colours of report/draw/style.cpp
};

/// Collects a part's rows, pictures and progress, and holds the options of its computation.
class Reproduction {
 public:
  virtual ~Reproduction() = default;
  virtual void row(ReproduceRow row) = 0;
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
  std::string out;  ///< folder for pictures and index.html; empty = no files
  bool json = false;
  bool quick = false;
  int threads = 0;   ///< 0 = as many as the machine has
  std::string mesh;  ///< of barnett.slicing, instead of the one made in code
};

/// Holds one part's outcome. A part that throws has one more row, which fails and gives the reason.
struct PartResult {
  ReproducePart part;
  std::vector<std::string> notes;
  std::vector<ReproduceRow> rows;
  std::vector<ReproducePicture> pictures;
};

/// Runs the wanted parts in order. @throws UsageError for an unknown paper or id, with the nearest known one
std::vector<PartResult> reproduce(const ReproduceOptions& options, const std::vector<ReproducePart>& parts);

/// Returns a value as the table and the page show it: a number with its unit ("-": not printed by the paper).
std::string text_of(const RowValue& value, int decimals, const std::string& unit);
std::string tolerance_of(const ReproduceRow& row);

/// Returns true when no row fails.
bool all_pass(const std::vector<PartResult>& results);

std::string reproduce_table(const std::vector<PartResult>& results);
std::string reproduce_json(const std::vector<PartResult>& results);
/// Returns one self-contained page: no network, no script.
std::string reproduce_page(const std::vector<PartResult>& results);

}  // namespace firn
