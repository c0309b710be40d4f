#include "python/plugin/contract.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/options/enumerators.h"
#include "python/host/c_locale.h"
#include "python/plugin/interpreter.h"
#include "python/plugin/memory_limit.h"
#include "python/plugin/watchdog.h"

namespace firn::python {

extern const char kContractText[], kSourcesText[];  // python/lib/firn: contract.py, sources.py

namespace py = pybind11;

// Objects of Python must be released by a thread that holds the interpreter.
struct ContractHost::Shared {
  explicit Shared(py::object module) : contract(std::move(module)), watchdog(contract.attr("SlowError")) {}
  py::object contract;
  Watchdog watchdog;
};

namespace {

constexpr auto kContiguous = py::array::c_style | py::array::forcecast;
using Heights = py::array_t<double, kContiguous>;
using Drops = py::array_t<std::uint8_t, kContiguous>;

template <class T>
std::span<const T> span_of(const py::array_t<T, kContiguous>& array) {
  return {array.data(), std::size_t(array.size())};
}

std::string explained(const py::object& explain, py::error_already_set& error) {
  py::object value = error.value();
  if (error.trace()) PyException_SetTraceback(value.ptr(), error.trace().ptr());
  return py::cast<std::string>(explain(value));
}

template <class T>
py::array_t<T> grid_array(const GridSpec& g, std::span<const T> cells) {
  return py::array_t<T>({g.ny, g.nx}, cells.data());
}

py::object setup_object(const py::object& contract, const ControllerSetup& s,
                        const std::shared_ptr<Prediction>& prediction) {
  const GridSpec g = s.grid;
  py::dict values;
  values["shape"] = py::make_tuple(g.ny, g.nx);
  values["pitch_x_mm"] = g.pitch_x_mm;
  values["pitch_y_mm"] = g.pitch_y_mm;
  values["origin_x_mm"] = g.origin_x_mm;
  values["origin_y_mm"] = g.origin_y_mm;
  values["target_mm"] = grid_array(g, s.target_mm);
  values["mask"] = grid_array(g, s.mask).attr("astype")("bool");
  values["h1_mm"] = s.h1_mm;
  values["h2_mm"] = s.h2_mm;
  values["h3_mm"] = s.h3_mm;
  values["layer_height_mm"] = s.layer_height_mm;
  values["seed"] = s.seed;
  values["most_drops"] = s.most_drops;
  Heights places({s.places.size(), 2});
  for (int n = 0; n < s.places.size(); ++n) {
    places.mutable_at(n, 0) = s.places[n].x;
    places.mutable_at(n, 1) = s.places[n].y;
  }
  values["places"] = places;
  const auto predict = [g, prediction](const Heights& height, const Drops& drops, const Drops& at) {
    Heights after({g.ny, g.nx});
    prediction->predict(span_of(height), span_of(drops), span_of(at), {after.mutable_data(), g.size()});
    return after;
  };
  const auto objective = [prediction](const Heights& height) {
    return prediction->objective_mm(span_of(height));
  };
  return contract.attr("Setup")(values, py::cpp_function(predict), py::cpp_function(objective));
}

std::string seconds_text(double seconds) {
  std::string text = std::to_string(seconds);
  return text.substr(0, text.find('.') + 3);
}

py::dict arrays_of(const Parcel& parcel) {
  py::dict arrays;
  for (const auto& [name, array] : parcel.arrays)
    if (array.shape.empty())
      arrays[name.c_str()] = array.values.at(0);
    else
      arrays[name.c_str()] = py::array_t<double>(array.shape, array.values.data());
  return arrays;
}

Parcel parcel_of(const py::tuple& told) {
  Parcel parcel;
  for (const auto& [name, value] : told[0].cast<py::dict>()) {
    const auto values = value.cast<Heights>();
    Array& array = parcel.arrays[name.cast<std::string>()];
    for (py::ssize_t n = 0; n < values.ndim(); ++n) array.shape.push_back(int(values.shape(n)));
    array.values.assign(values.data(), values.data() + values.size());
  }
  parcel.text = told[1].cast<std::string>();
  return parcel;
}

// Calls `call` under the watchdog. @throws std::runtime_error with the text of what went wrong
template <class Shared, class Call>
void watched(Shared& shared, const py::object& run, double longest_s, const std::string& what, Call call) {
  const auto watch = shared.watchdog.arm(longest_s);
  std::string trouble;
  try {
    const MemoryLimit limit;
    call();
  } catch (py::error_already_set& error) {
    trouble = explained(run.attr("explain"), error);
  } catch (const std::exception& error) {
    trouble = error.what();
  }
  restore_c_locale();
  if (shared.watchdog.disarm(watch)) trouble = what + " took longer than " + seconds_text(longest_s) + " s";
  if (!trouble.empty()) throw std::runtime_error(trouble);
}

}  // namespace

// Runs one object; `Shared` outlives it.
template <class Shared>
class ContractObject final : public Object {
 public:
  ContractObject(std::shared_ptr<Shared> shared, py::object run, double longest_s)
      : shared_(std::move(shared)), run_(std::move(run)), longest_s_(longest_s) {}
  ~ContractObject() override {
    const InterpreterHold interpreter;
    run_ = {};
  }

  Parcel call(const Parcel& with) override {
    const InterpreterHold interpreter;
    Parcel answer;
    watched(*shared_, run_, longest_s_, py::cast<std::string>(run_.attr("method")) + " of " + with.text,
            [&] { answer = parcel_of(run_.attr("call")(arrays_of(with)).template cast<py::tuple>()); });
    return answer;
  }

 private:
  std::shared_ptr<Shared> shared_;
  py::object run_;
  double longest_s_;
};

// Runs one controller.
template <class Shared>
class ContractController final : public Controller {
 public:
  ContractController(std::shared_ptr<Shared> shared, py::object run, const ControllerSetup& setup)
      : shared_(std::move(shared)), run_(std::move(run)), grid_(setup.grid), longest_s_(setup.longest_s) {}
  ~ContractController() override {
    const InterpreterHold interpreter;
    run_ = {};
  }

  Answer decide(std::span<const double> height_mm, int layer, int attempt, double noise_std_mm) override {
    const InterpreterHold interpreter;
    Answer answer;
    watched(*shared_, run_, longest_s_, "decide of layer " + std::to_string(layer + 1), [&] {
      answer = answer_of(run_.attr("decide")(grid_array(grid_, height_mm), layer, attempt, noise_std_mm)
                             .template cast<py::tuple>());
    });
    return answer;
  }

  void use_model(double h1_mm, double h2_mm, double h3_mm) override {
    const InterpreterHold interpreter;
    watched(*shared_, run_, longest_s_, "use_model", [&] { run_.attr("use_model")(h1_mm, h2_mm, h3_mm); });
  }

 private:
  static Answer answer_of(const py::tuple& told) {
    Answer answer;
    answer.kind = PlanDecision(told[0].cast<int>());
    answer.reason = told[3].cast<std::string>();
    if (answer.kind == PlanDecision::kPrint) {
      const auto drops = told[1].cast<Drops>(), places = told[2].cast<Drops>();
      answer.drops.assign(drops.data(), drops.data() + drops.size());
      answer.places.assign(places.data(), places.data() + places.size());
    }
    return answer;
  }

  std::shared_ptr<Shared> shared_;
  py::object run_;
  GridSpec grid_;
  double longest_s_;
};

ContractHost::ContractHost(py::object contract) : shared_(std::make_shared<Shared>(std::move(contract))) {}

std::vector<SourceFile> ContractHost::sources(const std::string& path) {
  const InterpreterHold interpreter;
  try {
    std::vector<SourceFile> files;
    for (const py::handle pair : shared_->contract.attr("sources")(path)) {
      const auto [name, text] = pair.cast<std::pair<std::string, std::string>>();
      files.push_back({name, text});
    }
    return files;
  } catch (py::error_already_set& error) {
    throw std::runtime_error(explained(shared_->contract.attr("explain"), error));
  }
}

template <class... Arguments>
py::object ContractHost::run_of(const char* maker, const std::vector<SourceFile>& files,
                                const ClassName& name, double longest_s, const Arguments&... arguments) {
  const py::object& contract = shared_->contract;
  py::list texts;
  py::set names;
  for (const SourceFile& f : files) {
    texts.append(py::make_tuple(f.name, f.text));
    names.add(f.name);
  }
  const auto watch = shared_->watchdog.arm(longest_s);
  py::object run;
  std::string trouble;
  try {
    const MemoryLimit limit;
    run = contract.attr(maker)(texts, name.name, name.arguments, arguments...);
  } catch (py::error_already_set& error) {
    trouble = explained(
        py::cpp_function([&](const py::object& e) { return contract.attr("explain")(e, names); }), error);
  }
  restore_c_locale();
  if (shared_->watchdog.disarm(watch)) trouble = "the construction of " + name.name + " took too long";
  if (!trouble.empty()) throw std::runtime_error(trouble);
  return run;
}

std::unique_ptr<Controller> ContractHost::make_controller(const std::vector<SourceFile>& files,
                                                          const ClassName& name, const ControllerSetup& setup,
                                                          std::shared_ptr<Prediction> prediction) {
  const InterpreterHold interpreter;
  return std::make_unique<ContractController<Shared>>(
      shared_,
      run_of("Run", files, name, setup.longest_s, setup_object(shared_->contract, setup, prediction)), setup);
}

std::unique_ptr<Object> ContractHost::make_object(Kind kind, const std::vector<SourceFile>& files,
                                                  const ClassName& name, const Parcel& setup,
                                                  double longest_s) {
  static constexpr const char* kMakers[] = {"EstimatorRun", "PlantRun", "SurfaceRun"};
  static_assert(std::size(kMakers) == kTableSize<Kind>);
  const InterpreterHold interpreter;
  return std::make_unique<ContractObject<Shared>>(
      shared_, run_of(kMakers[int(kind)], files, name, longest_s, arrays_of(setup)), longest_s);
}

std::string ContractHost::versions() {
  const InterpreterHold interpreter;
  return py::cast<std::string>(shared_->contract.attr("versions")());
}

static py::object run_text(const char* name, const char* file, const char* text) {
  const py::module_ builtins = py::module_::import("builtins");
  py::object module = py::module_::import("types").attr("ModuleType")(name);
  py::dict space = module.attr("__dict__");
  space["__builtins__"] = builtins;
  builtins.attr("exec")(builtins.attr("compile")(py::str(text), file, "exec"), space);
  py::module_::import("sys").attr("modules")[name] = module;
  return module;
}

py::object run_contract() {
  run_text("firn.sources", "firn/sources.py", kSourcesText);
  return run_text("firn", "firn/contract.py", kContractText);
}

}  // namespace firn::python
