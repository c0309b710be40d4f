#include "studies/reproduce/part_record.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "files/json.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

// JSON has no number for these.
struct NotFinite {
  const char* word;
  double value;
};
constexpr NotFinite kNotFinite[] = {{"nan", std::numeric_limits<double>::quiet_NaN()},
                                    {"inf", std::numeric_limits<double>::infinity()},
                                    {"-inf", -std::numeric_limits<double>::infinity()}};

Json value_record(const RowValue& value) {
  if (const auto* words = std::get_if<std::string>(&value)) return *words;
  const double number = std::get<double>(value);
  if (std::isfinite(number)) return number;
  return Json{{"number", kNotFinite[std::isnan(number) ? 0 : number > 0.0 ? 1 : 2].word}};
}

RowValue value_of(const Json& j) {
  if (j.is_string()) return j.get<std::string>();
  if (j.is_number()) return j.get<double>();
  for (const NotFinite& known : kNotFinite)
    if (j.at("number") == known.word) return known.value;
  throw std::runtime_error("a value is neither a number nor words");
}

Json row_record(const ReproduceRow& r) {
  return {{"id", r.id},
          {"what", r.what},
          {"unit", r.unit},
          {"ours", value_record(r.ours)},
          {"decimals", r.decimals},
          {"printed", value_record(r.printed.value)},
          {"place", r.printed.place},
          {"quote", r.printed.quote},
          {"derived", value_record(r.derived.value)},
          {"by", r.derived.by},
          {"how", r.derived.how},
          {"tolerance", r.tolerance},
          {"fit", r.fit},
          {"unidentifiable_for", r.unidentifiable_for},
          {"missed_for", r.missed_for},
          {"compared_with_printed", r.compared_with_printed},
          {"compared_with_derived", r.compared_with_derived},
          {"agrees", r.agrees},
          {"arithmetic", r.is_arithmetic}};
}

ReproduceRow row_of(const Json& j) {
  ReproduceRow r;
  j.at("id").get_to(r.id);
  j.at("what").get_to(r.what);
  j.at("unit").get_to(r.unit);
  r.ours = value_of(j.at("ours"));
  j.at("decimals").get_to(r.decimals);
  r.printed.value = value_of(j.at("printed"));
  j.at("place").get_to(r.printed.place);
  j.at("quote").get_to(r.printed.quote);
  r.derived.value = value_of(j.at("derived"));
  j.at("by").get_to(r.derived.by);
  j.at("how").get_to(r.derived.how);
  j.at("tolerance").get_to(r.tolerance);
  j.at("fit").get_to(r.fit);
  j.at("unidentifiable_for").get_to(r.unidentifiable_for);
  j.at("missed_for").get_to(r.missed_for);
  j.at("compared_with_printed").get_to(r.compared_with_printed);
  j.at("compared_with_derived").get_to(r.compared_with_derived);
  j.at("agrees").get_to(r.agrees);
  j.at("arithmetic").get_to(r.is_arithmetic);
  return r;
}

}  // namespace

std::string part_record(const PartResult& result) {
  Json rows = Json::array(), beside = Json::array(), pictures = Json::array();
  for (const ReproduceRow& row : result.rows) rows.push_back(row_record(row));
  for (const BesideRow& row : result.beside)
    beside.push_back({{"id", row.id},
                      {"what", row.what},
                      {"unit", row.unit},
                      {"ours", value_record(row.value)},
                      {"decimals", row.decimals}});
  for (const ReproducePicture& p : result.pictures)
    pictures.push_back({{"name", p.name}, {"caption", p.caption}, {"svg", p.svg}});
  return Json{{"notes", result.notes},
              {"rows", rows},
              {"beside", beside},
              {"pictures", pictures},
              {"error", result.error}}
      .dump(-1, ' ', true, Json::error_handler_t::replace);
}

PartResult part_of(const std::string& record, const ReproducePart& part) try {
  const Json j = Json::parse(record);
  PartResult result;
  result.part = part;
  j.at("notes").get_to(result.notes);
  for (const Json& row : j.at("rows")) result.rows.push_back(row_of(row));
  for (const Json& row : j.at("beside"))
    result.beside.push_back({row.at("id").get<std::string>(), row.at("what").get<std::string>(),
                             row.at("unit").get<std::string>(), value_of(row.at("ours")),
                             row.at("decimals").get<int>()});
  for (const Json& p : j.at("pictures"))
    result.pictures.push_back({p.at("name").get<std::string>(), p.at("caption").get<std::string>(),
                               p.at("svg").get<std::string>()});
  j.at("error").get_to(result.error);
  return result;
} catch (const std::exception& error) {
  throw std::runtime_error(std::string("the record of ") + part.paper + "." + part.name + ": " +
                           error.what());
}

}  // namespace firn
