// firn reproduce: every table and figure of the papers, the paper's value beside ours. A part is one function
// that makes rows and pictures; all parts stand in one table (cli/reproduce_parts.cpp), one file per paper
// and part.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace firn {

/// What a row compares with. Only a measurement that the model cannot give may go without a verdict.
enum class RowKind {
  kComputed,  ///< follows from the paper's equations or data
  kFit,  ///< of a set-up that the paper does not print and that was fitted to its result; a match tests the
         ///< fit
  kProperty,  ///< must hold for any input
  kMeasured,  ///< the paper's own measurement: informative, no tolerance
};
std::string_view name(RowKind kind);

/// A number (with its unit in the row) or words; empty words = the paper does not print it.
using RowValue = std::variant<std::string, double>;

struct ReproduceRow {
  std::string id;  ///< <paper>.<part>.<name>, lower case, digits, '.' and '-'
  std::string what;
  RowKind kind = RowKind::kComputed;
  std::string unit;  ///< of the numbers in paper, ours and tolerance
  RowValue paper, ours;
  RowValue tolerance;  ///< number = largest |ours - paper|; words = the bound itself; empty = informative
  std::optional<bool> pass;  ///< none = informative
  int decimals = 2;          ///< of the table; JSON carries the full numbers
};

// Row makers. NaN never passes.

/// |ours - paper| <= tolerance
ReproduceRow row_near(std::string id, std::string what, std::string unit, double paper, double ours,
                      double tolerance, RowKind kind = RowKind::kComputed);
/// ours <= bound; `paper` is what the paper prints, if anything
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

/// What a part is handed: where its rows, pictures and progress go, and how much it shall compute.
class Reproduction {
 public:
  virtual ~Reproduction() = default;
  virtual void row(ReproduceRow row) = 0;
  virtual void picture(ReproducePicture picture) = 0;
  /// A paragraph that stands before the part's rows on the page: what was chosen and why. Plain text.
  virtual void note(std::string text) = 0;
  /// Fraction of the part that is done, 0 to 1, and what is being done.
  virtual void progress(double fraction, std::string_view doing) = 0;
  /// True: as few repeats as still make sense (tests). Rows of many seeds then say how many.
  virtual bool quick() const = 0;
  /// Threads that the part may use, >= 1. The rows must not depend on it.
  virtual int threads() const = 0;
  /// A mesh to slice instead of the one made in code; empty = none.
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
  std::string out;  ///< folder for pictures and index.html; empty = none
  bool json = false;
  bool quick = false;
  int threads = 0;   ///< 0 = as many as the machine has
  std::string mesh;  ///< of barnett.slicing, instead of the one made in code
};

/// One part's outcome. A part that throws has one more row, which fails and says why.
struct PartResult {
  ReproducePart part;
  std::vector<std::string> notes;
  std::vector<ReproduceRow> rows;
  std::vector<ReproducePicture> pictures;
};

/// Runs the wanted parts in order. @throws UsageError for an unknown paper or id, with the nearest known one
std::vector<PartResult> reproduce(const ReproduceOptions& options, const std::vector<ReproducePart>& parts);

/// A value as the table and the page show it: a number with its unit ("-" = the paper prints none).
std::string text_of(const RowValue& value, int decimals, const std::string& unit);
std::string tolerance_of(const ReproduceRow& row);

/// True when no row fails.
bool all_pass(const std::vector<PartResult>& results);

std::string reproduce_table(const std::vector<PartResult>& results);
std::string reproduce_json(const std::vector<PartResult>& results);
/// One self-contained page: no network, no script.
std::string reproduce_page(const std::vector<PartResult>& results);

}  // namespace firn
