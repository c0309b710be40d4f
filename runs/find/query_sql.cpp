#include "runs/find/query_sql.h"

#include <algorithm>

#include "config/fields.h"
#include "config/labs.h"
#include "config/meta.h"
#include "core/options/number.h"
#include "files/lowercase.h"
#include "files/nearest.h"
#include "runs/find/run_facts.h"

namespace firn::runs {
namespace {

using Op = Query::Operator;

constexpr std::string_view kMetaKey = "meta.";

// The fields at their defaults: a run keeps those alone that differ.
const std::vector<Field>& default_fields() {
  static Experiment defaults;
  static const std::vector<Field> table = fields(defaults);
  return table;
}

const Field* setting(const std::string& key) {
  const auto& table = default_fields();
  const auto at = std::ranges::find(table, key, &Field::key);
  return at == table.end() || key == "run.name" ? nullptr : &*at;
}

const char* sign(Op op) {
  switch (op) {
    case Op::kLess:
      return "<";
    case Op::kAtMost:
      return "<=";
    case Op::kGreater:
      return ">";
    case Op::kAtLeast:
      return ">=";
    default:
      return "=";
  }
}

template <class Value>
bool in_order(Op op, const Value& a, const Value& b) {
  switch (op) {
    case Op::kLess:
      return a < b;
    case Op::kAtMost:
      return a <= b;
    case Op::kGreater:
      return a > b;
    case Op::kAtLeast:
      return a >= b;
    default:
      return a == b;
  }
}

bool holds(Op op, double a, double b) { return in_order(op, a, b); }

bool holds(Op op, const std::string& a, const std::string& b) {
  if (op == Op::kContains) return lowercase(a).find(lowercase(b)) != std::string::npos;
  return in_order(op, a, b);
}

// Returns whether a field's own value meets the comparison.
bool default_meets(const Field& f, Op op, const Query& q) {
  std::string text = value_text(f);
  if (text.starts_with('"')) text = text.substr(1, text.size() - 2);
  if (q.number && op != Op::kContains) {
    if (const auto* v = std::get_if<double*>(&f.value)) return holds(op, **v, *q.number);
    if (const auto number = whole_number<double>(text)) return holds(op, *number, *q.number);
    return op == Op::kEqual && text == q.text;
  }
  return holds(op, text, q.text);
}

class Writer {
 public:
  explicit Writer(std::string_view text) : text_(text) {}

  SqlCondition take() { return std::move(out_); }

  void write(const Query& q) {
    switch (q.kind) {
      case Query::Kind::kAll:
        add("1");
        break;
      case Query::Kind::kAnd:
        chain(q, " AND ");
        break;
      case Query::Kind::kOr:
        chain(q, " OR ");
        break;
      case Query::Kind::kNot:
        add("NOT ");
        write(q.parts.front());
        break;
      case Query::Kind::kMentions:
        add("r.id IN (SELECT run FROM texts WHERE instr(lower(word), ?))");
        out_.values.emplace_back(lowercase(q.text));
        break;
      case Query::Kind::kHas:
        check_query_key(q.key, text_, q.column + std::string_view("has ").size());
        if (const Field* f = setting(q.key))
          add("(r.settings AND r.lab IN (" + labs_of(*f) + "))");
        else
          of_key(q.key, "1");
        break;
      case Query::Kind::kCompare:
        check_query_key(q.key, text_, q.column);
        compare(q);
        break;
    }
  }

 private:
  void add(const std::string& text) { out_.text += text; }
  void chain(const Query& q, const char* between) {
    add("(");
    for (std::size_t n = 0; n < q.parts.size(); ++n) {
      if (n > 0) add(between);
      write(q.parts[n]);
    }
    add(")");
  }
  void of_key(const std::string& key, const std::string& condition) {
    add("r.id IN (SELECT run FROM facts WHERE key = ? AND " + condition + ")");
    out_.values.insert(out_.values.end() - std::ptrdiff_t(std::ranges::count(condition, '?')), key);
  }

  // a != b is the same as not a = b.
  void compare(const Query& q) {
    const bool negated = q.op == Op::kUnequal || q.op == Op::kLacks;
    const Op op = q.op == Op::kUnequal ? Op::kEqual : q.op == Op::kLacks ? Op::kContains : q.op;
    add(negated ? "NOT (" : "(");
    one_of_facts(q, op);
    if (const Field* f = setting(q.key); f && default_meets(*f, op, q)) {
      add(" OR (r.settings AND r.lab IN (" + labs_of(*f) + ") AND NOT ");
      of_key(q.key, "1");
      add(")");
    }
    add(")");
  }
  void one_of_facts(const Query& q, Op op) {
    if (op == Op::kContains) {
      out_.values.emplace_back(lowercase(q.text));
      of_key(q.key, "instr(lower(word), ?)");
    } else if (!q.number) {
      out_.values.emplace_back(q.text);
      of_key(q.key, std::string("word ") + sign(op) + " ?");
    } else if (op == Op::kEqual) {  // sample = 007 asks for a text too
      out_.values.emplace_back(*q.number);
      out_.values.emplace_back(q.text);
      of_key(q.key, "(number = ? OR (number IS NULL AND word = ?))");
    } else {
      out_.values.emplace_back(*q.number);
      out_.values.emplace_back(q.text);
      of_key(q.key,
             std::string("(number ") + sign(op) + " ? OR (number IS NULL AND word " + sign(op) + " ?))");
    }
  }
  static std::string labs_of(const Field& f) {
    std::string labs;
    for (const LabKind* lab : lab_kinds())
      if (belongs(f, lab->name)) labs += (labs.empty() ? "'" : ", '") + std::string(lab->name) + "'";
    return labs.empty() ? "''" : labs;
  }

  std::string_view text_;
  SqlCondition out_;
};

}  // namespace

void check_query_key(const std::string& key, std::string_view text, std::size_t column) {
  if (key.starts_with(kMetaKey) && is_meta_key(key.substr(kMetaKey.size()))) return;
  std::vector<std::string_view> known;
  const std::vector<FactKey> keys = fact_keys();
  for (const FactKey& k : keys) known.push_back(k.key);
  if (std::ranges::find(known, key) != known.end() || setting(key)) return;
  for (const Field& f : default_fields()) known.push_back(f.key);
  std::vector<std::string> metas;
  for (const std::string_view m : known_meta_keys()) metas.push_back(std::string(kMetaKey) + std::string(m));
  known.insert(known.end(), metas.begin(), metas.end());
  const std::string near = nearest(key, known);
  const bool is_meta = std::ranges::find(metas, std::string(kMetaKey) + key) != metas.end();
  throw QueryError(text, column,
                   key + ": no run has such a key" +
                       (is_meta        ? "; meta." + key + " is one"
                        : near.empty() ? ""
                                       : "; the nearest one is " + near));
}

SqlCondition sql_of(const Query& query, std::string_view text) {
  Writer writer(text);
  writer.write(query);
  return writer.take();
}

}  // namespace firn::runs
