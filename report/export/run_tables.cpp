#include "report/export/run_tables.h"

#include <algorithm>
#include <array>
#include <bit>
#include <ctime>
#include <map>
#include <stdexcept>
#include <tuple>

#include "core/grid/npy.h"
#include "files/record/event_format.h"
#include "files/record/file.h"
#include "files/run_paths.h"
#include "lcmtypes/channels.h"
#include "report/export/member_texts.h"
#include "report/export/run_facts_tables.h"
#include "report/export/run_outlines.h"
#include "runs/folder/documents.h"
#include "runs/read/run_log.h"

namespace firn::report {
namespace {

namespace fs = std::filesystem;
using schema::Field;
using schema::Kind;
using schema::Type;

constexpr std::size_t kMaxTables = 4096;

struct Topic {
  std::string_view channel;  ///< the whole name, or its beginning where it ends in '_', or its end
  std::string_view group;
};
constexpr std::array kTopics{
    Topic{"HEIGHT_MAP", "maps"},
    Topic{"SIM_TRUTH", "truth"},
    Topic{"LAYER_METRICS", "metrics"},
    Topic{"LAYER_PLAN", "decisions"},
    Topic{"CONTROL_SURFACE", "decisions"},
    Topic{"DEPOSITION_REPORT", "droplets"},
    Topic{"HEIGHT_MODEL", "estimates"},
    Topic{"FLOW_MODEL", "estimates"},
    Topic{"TRAJECTORY", "paths"},
    Topic{"PULSE_LIST", "paths"},
    Topic{"PATH_JOB", "paths"},
    Topic{"PATH_REPORT", "paths"},
    Topic{"FOLLOWED_PATH", "paths"},
    Topic{"HEIGHT_PROFILE", "measurements"},
    Topic{"LASER_SAMPLES", "measurements"},
    Topic{"SCAN_DONE", "measurements"},
    Topic{"TEMPERATURE", "measurements"},
    Topic{"STATE_", "devices"},
    Topic{"ANSWER_", "devices"},
    Topic{"OPERATOR_COMMAND", "events"},
    Topic{"FAULT_", "events"},
    Topic{"SAFE_STOP", "events"},
    Topic{"RUN_START", "events"},
    Topic{"RUN_END", "events"},
    Topic{"ENABLE", "events"},
    Topic{"_COMMAND", "commands"},
    Topic{"HEARTBEAT_", "nodes"},
    Topic{"CONFIG_", "nodes"},
};

bool on_topic(std::string_view channel, std::string_view topic) {
  if (topic.starts_with('_')) return channel.ends_with(topic);
  return topic.ends_with('_') ? channel.starts_with(topic) : channel == topic;
}

std::string column_name(const Field& f) {
  std::string name = f.path.starts_with("header.") ? f.path.substr(7) : f.path;
  std::ranges::replace(name, '.', '_');
  return name;
}

// "header.seq" is described in header_t, "grid.nx" in grid_t.
MemberText text_of(const Type& type, const Field& f) {
  const std::size_t dot = f.path.find('.');
  if (dot == f.path.npos) return member_text(type.name, f.path);
  for (const schema::Member& m : type.members)
    if (f.path.starts_with(m.name + ".")) return member_text(m.type, f.path.substr(dot + 1));
  return {};
}

Column column_of(const Type& type, const Field& f, std::string_view channel) {
  const MemberText about = text_of(type, f);
  Column c;
  c.name = column_name(f);
  c.kind = f.kind;
  c.unit = f.kind == Kind::kString ? "text" : unit_of(c.name);
  c.values = about.values;
  std::string dimensions;
  for (const schema::Dimension& d : f.dimensions) dimensions += "[" + d.text + "]";
  c.text = "Member " + f.path + " of " + std::string(channel) + (about.text.empty() ? "" : ": ") +
           std::string(about.text) + ".";
  if (!dimensions.empty()) c.text += " Dimensions " + dimensions + ", row by row.";
  if (!about.range.empty()) c.text += " Range " + std::string(about.range) + ".";
  return c;
}

std::string about(const ChannelInfo* channel, const Type& type) {
  const std::string text(type_text(type.name));
  return (channel ? std::string(channel->meaning) + ". " : "") + text + (text.empty() ? "" : " ") +
         "One row a " + type.name + ", in the order of the log.";
}

// The first map of a channel over the layers, and the error of each layer.
std::optional<DefaultPlot> plot_of(const Table& table, std::string_view channel) {
  const auto has = [&](std::string_view name) {
    return std::ranges::any_of(table.columns,
                               [&](const Column& c) { return c.name == name && c.shape == Shape::kOne; });
  };
  if (!has("layer")) return {};
  const auto map = std::ranges::find(table.columns, Shape::kMap, &Column::shape);
  if (map != table.columns.end()) return DefaultPlot{map->name, "layer", channel == "HEIGHT_MAP"};
  if (has("rms_mm")) return DefaultPlot{"rms_mm", "layer", true};
  return {};
}

// "2026-12-01T09:30:00Z" that many microseconds after another such time; empty if that is no such time.
std::string utc_after(const std::string& started_utc, std::int64_t us) {
  std::tm parts{};
  if (!::strptime(started_utc.c_str(), "%Y-%m-%dT%H:%M:%SZ", &parts)) return "";
  const std::time_t end = ::timegm(&parts) + std::time_t(us / 1'000'000);
  ::gmtime_r(&end, &parts);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts)};
}

/// Opens a table for each channel, type, grid and shape of arrays, as they are met in the log.
class LogTables {
 public:
  LogTables(const fs::path& run, const std::string& prefix, TableSink& sink)
      : run_(run), prefix_(prefix), sink_(sink) {}

  std::uint64_t read(const std::function<void(double)>& progress) {
    return runs::each_message(
        run_, [this](const record::Event& e, const Type& type) { add(e, type); }, progress);
  }

  std::int64_t last_utime_us() const { return last_utime_us_; }

  /// Returns the first grid of a message with so many cells.
  GridSpec grid(int nx, int ny) const {
    for (const GridSpec& g : grids_)
      if (g.nx == nx && g.ny == ny) return g;
    throw std::invalid_argument(RunPaths(run_).log_path().string() + ": no message with a grid of " +
                                std::to_string(nx) + " x " + std::to_string(ny) +
                                " cells, which the target has");
  }

 private:
  struct Plan {
    const Type* type = nullptr;
    std::vector<std::size_t>
        grid;  // fields grid.nx, ny, pitch_x, pitch_y, origin_x, origin_y; empty: no grid
    std::map<std::pair<std::array<std::uint64_t, 6>, std::vector<Shape>>, std::size_t> tables;
  };

  Plan plan_of(const Type& type) const {
    Plan plan;
    plan.type = &type;
    for (const char* name : {"grid.nx", "grid.ny", "grid.pitch_x_mm", "grid.pitch_y_mm", "grid.origin_x_mm",
                             "grid.origin_y_mm"}) {
      const auto it = std::ranges::find(type.fields, name, &Field::path);
      if (it == type.fields.end()) return plan;
      plan.grid.push_back(std::size_t(it - type.fields.begin()));
    }
    return plan;
  }

  void add(const record::Event& e, const Type& type) {
    auto it = plans_.find(std::pair(e.channel, type.fingerprint));
    if (it == plans_.end())
      it = plans_.emplace(std::pair(std::string(e.channel), type.fingerprint), plan_of(type)).first;
    Plan& plan = it->second;
    places_.resize(type.fields.size());
    if (const auto error = check(type, e.data, places_))
      throw runs::bad_message(
          run_, e, error->path + ": byte " + std::to_string(error->offset) + ": " + error->message);
    const std::size_t table = table_of(plan, e);
    cells_.resize(type.fields.size() + 2);
    last_utime_us_ = std::max(last_utime_us_, e.utime_us);
    record::put_big64(numbers_.data(), e.eventnum);
    record::put_big64(numbers_.data() + 8, std::uint64_t(e.utime_us));
    cells_[0].numbers = std::span(numbers_).first(8);
    cells_[1].numbers = std::span(numbers_).subspan(8);
    for (std::size_t i = 0; i < type.fields.size(); ++i)
      fill(cells_[i + 2], type.fields[i].kind, places_[i], e);
    sink_.row(table, cells_);
  }

  static void fill(Cell& cell, Kind kind, const FieldPlace& place, const record::Event& e) {
    cell.strings.clear();
    if (kind != Kind::kString) {
      cell.numbers = e.data.subspan(place.offset, place.count * schema::size_of(kind));
      return;
    }
    std::size_t at = place.offset;
    for (std::size_t k = 0; k < place.count; ++k) {
      const std::size_t length = record::big32(e.data.data() + at);  // with the final zero; checked before
      cell.strings.emplace_back(reinterpret_cast<const char*>(e.data.data() + at + 4), length - 1);
      at += 4 + length;
    }
  }

  // The value of a number of the message.
  double value(const Plan& plan, std::size_t field, const record::Event& e) const {
    const std::byte* p = e.data.data() + places_[field].offset;
    if (plan.type->fields[field].kind == Kind::kInt32) return double(std::int32_t(record::big32(p)));
    return std::bit_cast<double>(record::big64(p));
  }

  std::size_t table_of(Plan& plan, const record::Event& e) {
    std::array<double, 6> grid{};
    for (std::size_t k = 0; k < plan.grid.size(); ++k) grid[k] = value(plan, plan.grid[k], e);
    const auto side = [](double n) { return n >= 1 && n <= kMaxGridSide; };
    const double size = side(grid[0]) && side(grid[1]) ? grid[0] * grid[1] : 0;
    std::vector<Shape> shapes;
    for (std::size_t i = 0; i < plan.type->fields.size(); ++i) {
      const Field& f = plan.type->fields[i];
      const bool counted = f.dimensions.size() == 1 && f.dimensions[0].variable && f.kind != Kind::kString;
      shapes.push_back(f.dimensions.empty()                                      ? Shape::kOne
                       : counted && size > 0 && double(places_[i].count) == size ? Shape::kMap
                                                                                 : Shape::kList);
    }
    std::array<std::uint64_t, 6> bits{};  // orders NaN too
    std::ranges::transform(grid, bits.begin(), [](double v) { return std::bit_cast<std::uint64_t>(v); });
    const auto key = std::pair(bits, shapes);
    if (const auto it = plan.tables.find(key); it != plan.tables.end()) return it->second;
    if (++tables_ > kMaxTables)
      throw std::invalid_argument(RunPaths(run_).log_path().string() + ": more than " +
                                  std::to_string(kMaxTables) + " tables: " + std::string(e.channel) +
                                  " has another grid in each message");
    const int number = ++names_[std::string(e.channel)];
    Table table;
    table.path = prefix_ + std::string(topic_of(e.channel)) + "/" + std::string(e.channel) +
                 (number > 1 ? "_" + std::to_string(number) : "");
    table.text = about(find_channel(e.channel), *plan.type);
    if (size > 0) {
      table.grid = GridSpec{int(grid[0]), int(grid[1]), grid[2], grid[3], grid[4], grid[5]};
      grids_.push_back(*table.grid);
    }
    table.columns = {
        {"log_event", Kind::kInt64, Shape::kOne, "1", "Number of the message in the log.", ""},
        {"log_utime_us", Kind::kInt64, Shape::kOne, "us", "Time stamp of the message in the log.", ""}};
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      table.columns.push_back(column_of(*plan.type, plan.type->fields[i], e.channel));
      table.columns.back().shape = shapes[i];
    }
    table.time_column = "log_utime_us";
    table.plot = plot_of(table, e.channel);
    return plan.tables[key] = sink_.open(table);
  }

  fs::path run_;
  std::string prefix_;
  TableSink& sink_;
  struct Less {
    using is_transparent = void;
    template <class A, class B>
    bool operator()(const A& a, const B& b) const {
      return std::tuple(std::string_view(a.first), a.second) <
             std::tuple(std::string_view(b.first), b.second);
    }
  };
  std::map<std::pair<std::string, std::int64_t>, Plan, Less> plans_;
  std::map<std::string, int> names_;
  std::vector<GridSpec> grids_;
  std::size_t tables_ = 0;
  std::int64_t last_utime_us_ = 0;
  std::vector<FieldPlace> places_;
  std::vector<Cell> cells_;
  std::array<std::byte, 16> numbers_{};
};

// Target and mask as one map each.
void write_inputs(const fs::path& run, const runs::ProvenanceDocument& provenance, const std::string& prefix,
                  const LogTables& reader, TableSink& sink) {
  for (const auto& [role, sha256] : provenance.inputs) {
    if (role != "target" && role != "mask") continue;
    const std::string name = RunPaths(run).input_path(sha256).string();
    const record::MappedFile file(name, record::MappedFile::Packed::kAsIs);
    const auto bytes = file.bytes();
    const NpyShape shape = npy_shape(bytes, name);
    const GridSpec grid = reader.grid(shape.nx, shape.ny);
    std::vector<std::byte> values;
    Table table;
    if (role == "target") {
      table = {prefix + "configuration/target",
               "The target surface.",
               {{"height_mm", Kind::kDouble, Shape::kMap, "mm", "Target height over each cell.", ""}},
               grid};
      for (const double v : height_map_from_npy(bytes, grid, name).cells) {
        values.resize(values.size() + 8);
        record::put_big64(values.data() + values.size() - 8, std::bit_cast<std::uint64_t>(v));
      }
    } else {
      table = {prefix + "configuration/mask",
               "The cells of the part.",
               {{"inside", Kind::kByte, Shape::kMap, "1", "1 where the cell belongs to the part.", ""}},
               grid};
      for (const std::uint8_t v : mask_from_npy(bytes, grid, name).cells) values.push_back(std::byte(v));
    }
    sink.row(sink.open(table), std::vector<Cell>{{values, {}}});
  }
}

}  // namespace

std::string_view topic_of(std::string_view channel) {
  for (const Topic& t : kTopics)
    if (on_topic(channel, t.channel)) return t.group;
  return "other";
}

std::uint64_t export_run(const fs::path& run, const std::string& prefix, TableSink& sink,
                         const std::function<void(double)>& progress) {
  const runs::RunTexts texts = runs::read_texts(run);
  const runs::ProvenanceDocument provenance =
      runs::parse_provenance(texts.provenance_json, RunPaths(run).provenance_path().string());
  const std::string started_utc = provenance.text("started_utc");
  sink.begin_run({prefix, provenance.text("name"), started_utc});
  sink.document(prefix + "configuration/experiment_toml", "The experiment with every key resolved, TOML.",
                texts.experiment_toml);
  sink.document(prefix + "provenance/provenance_json",
                "Program, commit, platform, seeds and digests of the inputs, JSON.", texts.provenance_json);
  sink.document(prefix + "provenance/result_json",
                "Outcome, reason and layers, JSON; empty: the run has not ended.", texts.result_json);
  write_meta(provenance, prefix, sink);
  write_notes(run, prefix, sink);
  LogTables reader(run, prefix, sink);
  const std::uint64_t messages = reader.read(progress);
  write_inputs(run, provenance, prefix, reader, sink);
  write_outlines(run, provenance, prefix, sink);
  sink.end_run(utc_after(started_utc, reader.last_utime_us()));
  return messages;
}

}  // namespace firn::report
