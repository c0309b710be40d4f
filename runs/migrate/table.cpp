#include "runs/migrate/table.h"

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "lcmtypes/schema_walk.h"

namespace firn::runs {
namespace {

constexpr std::int64_t kInkA = 1;

// One ink in one pattern had no companion: its passes are rounds, each cured.
void fill_deposition_report(const MessageFields& old, const MessageFields* detail, NewFields& now) {
  now.set("material", detail ? detail->integer("material") : kInkA);
  now.set("round", detail ? detail->integer("round") : old.integer("pass"));
  now.set("sub_pattern", detail ? detail->integer("sub_pattern") : 0);
  now.set("sub_patterns", detail ? detail->integer("sub_patterns") : 1);
  now.set("cured", detail ? detail->integer("cured") : 1);
}

void fill_layer_plan(const MessageFields&, const MessageFields* map, NewFields& now) {
  const std::vector<std::int8_t> material =
      map ? map->small_integers("material") : std::vector<std::int8_t>{};
  now.set("n_material", std::int64_t(material.size()));
  now.set("material", material);
}

// The counts of the whole layer were sent with each pass, which fired the cells with more than `pass` of
// them.
void fill_stage_command(const MessageFields& old, const MessageFields*, NewFields& now) {
  std::vector<std::int8_t> fires = old.small_integers("drops");
  for (std::int8_t& f : fires) f = f > old.integer("pass");
  now.set("fires", fires);
}

// Pulses came where their cells are.
void fill_stage_lead(const MessageFields&, const MessageFields*, NewFields& now) {
  now.set_number("lead_mm", 0.0);
}

// Rows that were lost were not counted, and the errors were those of all cells of the part together.
void fill_height_map(const MessageFields&, const MessageFields*, NewFields& now) {
  now.set("rows_expected", 0);
  now.set("rows_received", 0);
}

void fill_layer_metrics(const MessageFields&, const MessageFields*, NewFields& now) {
  now.set("rows_lost", 0);
  now.set("cells_guessed", 0);
  now.set_number("rms_inside_mm", 0.0);
  now.set_number("rms_rim_mm", 0.0);
}

// The only verb was "accept doubt".
void fill_operator_command(const MessageFields&, const MessageFields*, NewFields& now) {
  now.set("command_id", 0);
  now.set_text("key", "");
  now.set_text("value", "");
}

// A scan was one swath over the grid's middle.
void fill_profiler_command(const MessageFields& old, const MessageFields*, NewFields& now) {
  now.set("first_row", 0);
  now.set("rows_of_scan", old.integer("rows"));
  now.set_number("shift_x_mm", 0.0);
}

// There was no camera over the lines.
void fill_line_plan(const MessageFields&, const MessageFields*, NewFields& now) {
  now.set("looks", 0);
  for (const char* seen :
       {"seen_width_mm", "seen_width_std_mm", "seen_offset_mm", "seen_overspray", "seen_gap_mm"})
    now.set_empty(seen);
}

// The sheath's gas was the same in all layers.
void fill_line_plan_gas(const MessageFields&, const MessageFields*, NewFields& now) {
  now.set_number("sheath_share", 1.0);
}

// The path that was followed was not recorded.
void fill_path_report(const MessageFields&, const MessageFields*, NewFields& now) {
  now.set("samples", 0);
  for (const char* error : {"contour_max_mm", "contour_rms_mm", "following_max_mm", "lag_max_s",
                            "switch_max_mm", "offset_rms_mm"})
    now.set_number(error, std::numeric_limits<double>::quiet_NaN());
}

// A fault's numbers were in its text alone.
void fill_figure(const MessageFields&, const MessageFields*, NewFields& now) {
  now.set("figure.known", 0);
  now.set_number("figure.value", 0.0);
  now.set_number("figure.limit", 0.0);
  now.set_text("figure.unit", "");
  now.set_text("figure.key", "");
}

// Neither a stage nor a jet told until when it had acted.
void fill_until(const MessageFields&, const MessageFields*, NewFields& now) { now.set("until_utime_us", 0); }

// `pass` is a reserved word of Python, in which a class with such a member cannot be imported.
void fill_pass_index(const MessageFields& old, const MessageFields*, NewFields& now) {
  now.set("pass_index", old.integer("pass"));
}

// All droplets were in the centres of their cells.
void fill_centres(const MessageFields&, const MessageFields*, NewFields& now) {
  now.set("n_offset", 0);
  now.set_empty("offset");
}

void fill_stage_centres(const MessageFields& old, const MessageFields* companion, NewFields& now) {
  fill_centres(old, companion, now);
  now.set_number("apart_mm", 0.0);
}

constexpr Migration kMigrations[] = {
    {R"(struct profiler_command_t {
          header_t header;
          int64_t command_id;
          int64_t enable_epoch;
          int8_t verb;
          int32_t layer;
          int32_t attempt;
          int64_t scan_id;
          int32_t rows;
          double y0_mm;
          double pitch_y_mm;
        })",
     fill_profiler_command},
    {R"(struct operator_command_t {
          header_t header;
          int8_t verb;
          string text;
        })",
     fill_operator_command},
    {R"(struct deposition_report_t {
          header_t header;
          int32_t n;
          int32_t layer;
          int32_t attempt;
          int32_t pass;
          int32_t passes;
          int64_t map_id;
          int8_t outcome;
          int64_t commanded;
          int64_t triggered_stage;
          int64_t triggered_jet;
          int64_t confirmed;
          int64_t unknown_from;
          int64_t unknown_to;
          grid_t grid;
          int8_t drops[n];
        })",
     fill_deposition_report, "PASS_DETAIL"},
    {R"(struct layer_plan_t {
          header_t header;
          int32_t n;
          int32_t layer;
          int32_t attempt;
          int64_t map_id;
          int8_t decision;
          int32_t passes;
          grid_t grid;
          double objective_mm;
          double objective_none_mm;
          int64_t iterations;
          string reason;
          int8_t drops[n];
        })",
     fill_layer_plan, "MATERIAL_MAP"},
    {R"(struct stage_command_t {
          header_t header;
          int32_t n;
          int64_t command_id;
          int64_t enable_epoch;
          int8_t verb;
          int32_t layer;
          int32_t attempt;
          int32_t pass;
          int64_t scan_id;
          int32_t rows;
          double x_mm;
          double y_mm;
          double z_mm;
          double speed_mm_s;
          grid_t grid;
          int8_t drops[n];
        })",
     fill_stage_command},
    {R"(struct stage_command_t {
          header_t header;
          int32_t n;
          int64_t command_id;
          int64_t enable_epoch;
          int8_t verb;
          int32_t layer;
          int32_t attempt;
          int32_t pass;
          int64_t scan_id;
          int32_t rows;
          double x_mm;
          double y_mm;
          double z_mm;
          double speed_mm_s;
          grid_t grid;
          int8_t fires[n];
        })",
     fill_stage_lead},
    {R"(struct height_map_t {
          header_t header;
          int32_t n;
          int32_t layer;
          int32_t attempt;
          int64_t map_id;
          int64_t sample_utime_us;
          grid_t grid;
          double noise_std_mm;
          double measured_fraction;
          float height_mm[n];
          int8_t quality[n];
        })",
     fill_height_map},
    {R"(struct layer_metrics_t {
          header_t header;
          int32_t layer;
          int32_t attempt;
          int64_t map_id;
          double target_mean_mm;
          double mean_height_mm;
          double mean_error_mm;
          double rms_mm;
          double std_mm;
          double min_error_mm;
          double max_error_mm;
          double volume_mm3;
          int64_t drops;
          int64_t drops_total;
          double objective_mm;
          int64_t iterations;
          double deposit_s;
          double cure_s;
          double scan_s;
          double decide_s;
          int32_t layers_expected;
        })",
     fill_layer_metrics},
    {R"(struct line_plan_t {
          header_t header;
          int32_t knots;
          int32_t switches;
          int32_t stations;
          int32_t layer;
          int32_t attempt;
          int64_t map_id;
          int64_t path;
          int8_t decision;
          double duration_s;
          double open_s;
          double printed_mm;
          double open_delay_s;
          double close_delay_s;
          double flow_share;
          double start_error_mm;
          double end_error_mm;
          string reason;
          double t_s[knots];
          double x_mm[knots];
          double y_mm[knots];
          double vx_mm_s[knots];
          double vy_mm_s[knots];
          double switch_mm[switches];
          float station_x_mm[stations];
          float station_y_mm[stations];
          float speed_mm_s[stations];
          float area_mm2[stations];
          float layer_area_mm2[stations];
          float width_mm[stations];
          float offset_mm[stations];
          float overspray[stations];
        })",
     fill_line_plan},
    {R"(struct line_plan_t {
          header_t header;
          int32_t knots;
          int32_t switches;
          int32_t stations;
          int32_t looks;
          int32_t layer;
          int32_t attempt;
          int64_t map_id;
          int64_t path;
          int8_t decision;
          double duration_s;
          double open_s;
          double printed_mm;
          double open_delay_s;
          double close_delay_s;
          double flow_share;
          double start_error_mm;
          double end_error_mm;
          string reason;
          double t_s[knots];
          double x_mm[knots];
          double y_mm[knots];
          double vx_mm_s[knots];
          double vy_mm_s[knots];
          double switch_mm[switches];
          float station_x_mm[stations];
          float station_y_mm[stations];
          float speed_mm_s[stations];
          float area_mm2[stations];
          float layer_area_mm2[stations];
          float width_mm[stations];
          float offset_mm[stations];
          float overspray[stations];
          float seen_width_mm[looks];
          float seen_width_std_mm[looks];
          float seen_offset_mm[looks];
          float seen_overspray[looks];
          float seen_gap_mm[looks];
        })",
     fill_line_plan_gas},
    {R"(struct path_report_t {
          header_t header;
          int64_t path;
          int64_t batch;
          int32_t layer;
          int32_t attempt;
          int8_t material;
          int8_t kind;
          int8_t outcome;
          int64_t pulses_commanded;
          int64_t pulses_counted;
          double volume_mm3;
          double planned_s;
          double measured_s;
          int64_t begin_utime_us;
        })",
     fill_path_report},
    {R"(struct fault_t {
          header_t header;
          int8_t severity;
          int32_t code;
          string node;
          string text;
        })",
     fill_figure},
    {R"(struct answer_t {
          header_t header;
          string node;
          int64_t command_id;
          int8_t outcome;
          int64_t counted;
          int64_t expected;
          int64_t unknown_from;
          int64_t unknown_to;
          int32_t code;
          string text;
        })",
     fill_figure},
    {R"(struct deposition_report_t {
          header_t header;
          int32_t n;
          int32_t layer;
          int32_t attempt;
          int32_t pass;
          int32_t passes;
          int64_t map_id;
          int8_t material;
          int32_t round;
          int32_t sub_pattern;
          int32_t sub_patterns;
          int8_t cured;
          int8_t outcome;
          int64_t commanded;
          int64_t triggered_stage;
          int64_t triggered_jet;
          int64_t confirmed;
          int64_t unknown_from;
          int64_t unknown_to;
          grid_t grid;
          int8_t drops[n];
        })",
     fill_pass_index},
    {R"(struct jet_command_t {
          header_t header;
          int64_t command_id;
          int64_t enable_epoch;
          int8_t verb;
          int32_t layer;
          int32_t attempt;
          int32_t pass;
          int64_t expected;
        })",
     fill_pass_index},
    {R"(struct stage_command_t {
          header_t header;
          int32_t n;
          int64_t command_id;
          int64_t enable_epoch;
          int8_t verb;
          int32_t layer;
          int32_t attempt;
          int32_t pass;
          int64_t scan_id;
          int32_t rows;
          double x_mm;
          double y_mm;
          double z_mm;
          double speed_mm_s;
          grid_t grid;
          double lead_mm;
          int8_t fires[n];
        })",
     fill_pass_index},
    {R"(struct answer_t {
          header_t header;
          string node;
          int64_t command_id;
          int8_t outcome;
          int64_t counted;
          int64_t expected;
          int64_t unknown_from;
          int64_t unknown_to;
          int32_t code;
          string text;
          figure_t figure;
        })",
     fill_until},
    {R"(struct layer_plan_t {
          header_t header;
          int32_t n;
          int32_t layer;
          int32_t attempt;
          int64_t map_id;
          int8_t decision;
          int32_t passes;
          grid_t grid;
          int32_t n_material;
          int8_t material[n_material];
          double objective_mm;
          double objective_none_mm;
          int64_t iterations;
          string reason;
          int8_t drops[n];
        })",
     fill_centres},
    {R"(struct stage_command_t {
          header_t header;
          int32_t n;
          int64_t command_id;
          int64_t enable_epoch;
          int8_t verb;
          int32_t layer;
          int32_t attempt;
          int32_t pass_index;
          int64_t scan_id;
          int32_t rows;
          double x_mm;
          double y_mm;
          double z_mm;
          double speed_mm_s;
          grid_t grid;
          double lead_mm;
          int8_t fires[n];
        })",
     fill_stage_centres},
};

constexpr RetiredChannel kRetired[] = {
    {"PASS_DETAIL",
     R"(struct pass_detail_t {
          header_t header;
          int32_t layer;
          int32_t attempt;
          int32_t pass;
          int32_t passes;
          int64_t map_id;
          int8_t material;
          int32_t round;
          int32_t sub_pattern;
          int32_t sub_patterns;
          int8_t cured;
        })",
     "DEPOSITION_REPORT",
     {"layer", "attempt", "pass", "map_id"},
     ""},
    {"MATERIAL_MAP",
     R"(struct material_map_t {
          header_t header;
          int32_t n;
          int32_t layer;
          int32_t attempt;
          int64_t map_id;
          grid_t grid;
          int8_t material[n];
        })",
     "LAYER_PLAN",
     {"layer", "attempt", "map_id"},
     "scheduler"},
};

// The recorded structs use these; a change of one is a change of every message that has it.
constexpr std::string_view kCommon = R"(package firn;
    struct header_t { int64_t run_id; int32_t incarnation; int64_t seq; int64_t utime_us; }
    struct grid_t { int32_t nx; int32_t ny; double pitch_x_mm; double pitch_y_mm; double origin_x_mm;
                    double origin_y_mm; }
    struct figure_t { int8_t known; double value; double limit; string unit; string key; }
    )";

std::int64_t fingerprint_of(std::span<const std::byte> message) {
  return message.size() < 8 ? 0 : std::int64_t(schema::big_endian(message.data(), 8));
}

}  // namespace

const MigrationTable& MigrationTable::builtin() {
  static const MigrationTable table(kMigrations, kRetired, Schema::builtin());
  return table;
}

MigrationTable::MigrationTable(std::span<const Migration> rows, std::span<const RetiredChannel> retired,
                               const Schema& today)
    : retired_(retired), today_(today) {
  std::vector<MigrationStep> all;
  for (const Migration& row : rows) all.push_back({&row, parse(row.was), nullptr});
  for (auto step = all.begin(); step != all.end(); ++step) {
    const auto next = std::find_if(step + 1, all.end(),
                                   [&](const MigrationStep& s) { return s.from->name == step->from->name; });
    step->to = next == all.end() ? today.find(step->from->name) : next->from;
    steps_.emplace(step->from->fingerprint, *step);
  }
  for (const RetiredChannel& r : retired) {
    const schema::Type* type = parse(r.was);
    retired_types_.emplace(type->fingerprint, type);
  }
}

const schema::Type* MigrationTable::parse(std::string_view was) {
  schemas_.push_back(Schema::parse(std::string(kCommon) + std::string(was)));
  return &schemas_.back().types().back();
}

const MigrationStep* MigrationTable::step_from(std::span<const std::byte> message) const {
  const auto it = steps_.find(fingerprint_of(message));
  return it == steps_.end() ? nullptr : &it->second;
}

const schema::Type* MigrationTable::type_of(std::span<const std::byte> message) const {
  if (const schema::Type* today = today_.type_of(message)) return today;
  if (const MigrationStep* step = step_from(message)) return step->from;
  const auto it = retired_types_.find(fingerprint_of(message));
  return it == retired_types_.end() ? nullptr : it->second;
}

const RetiredChannel* MigrationTable::retired(std::string_view channel) const {
  const auto it = std::ranges::find(retired_, channel, &RetiredChannel::name);
  return it == retired_.end() ? nullptr : &*it;
}

}  // namespace firn::runs
