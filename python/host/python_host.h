// PythonHost runs Python code of a print: the interface between Firn and its plug-in, which alone holds an
// interpreter (python/plugin). The plug-in is loaded when an experiment names a Python file first
// (python/host/load.h), so that a program without such a file depends on no Python.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/grid/decision.h"
#include "core/grid/grid.h"
#include "core/grid/offsets.h"

namespace firn::python {

/// A Python file by its name without a folder: "level.py".
struct SourceFile {
  std::string name, text;
};

/// Names a class in the first of some files, with the arguments of its construction ("gain=0.5"; empty:
/// none).
struct ClassName {
  std::string name, arguments;
};

/// Holds the values from which a controller is built; heights in mm, arrays row-major [ny][nx].
struct ControllerSetup {
  GridSpec grid;
  std::span<const double> target_mm;
  std::span<const std::uint8_t> mask;
  double h1_mm = 0.0, h2_mm = 0.0, h3_mm = 0.0, layer_height_mm = 0.0;
  std::uint64_t seed = 0;
  int most_drops = 1;       ///< per cell and layer
  double longest_s = 0.0;   ///< wall time of one decision
  OffsetTable places = {};  ///< inside a cell, at which its droplets may be aimed
};

/// Computes heights by the height-change model, for a controller that plans with it.
class Prediction {
 public:
  virtual ~Prediction() = default;
  /// @param places of the droplets inside their cells, indices of ControllerSetup::places; empty: the centres
  /// @param after_mm [ny][nx], filled with the surface after one layer of `drops`
  virtual void predict(std::span<const double> height_mm, std::span<const std::uint8_t> drops,
                       std::span<const std::uint8_t> places, std::span<double> after_mm) = 0;
  /// Mean |height - target| over the part [mm].
  virtual double objective_mm(std::span<const double> height_mm) = 0;
};

struct Answer {
  PlanDecision kind = PlanDecision::kStop;
  std::vector<std::uint8_t> drops;   ///< [ny][nx] with kPrint; else empty
  std::vector<std::uint8_t> places;  ///< [ny][nx] of ControllerSetup::places; empty: all in the centres
  std::string reason;
};

/// A controller's object. Its state is a function of its calls.
class Controller {
 public:
  virtual ~Controller() = default;
  /// @throws std::runtime_error with the traceback of an exception; naming an answer that is none, and a
  /// decision that took longer than longest_s
  virtual Answer decide(std::span<const double> height_mm, int layer, int attempt, double noise_std_mm) = 0;
  virtual void use_model(double h1_mm, double h2_mm, double h3_mm) = 0;
};

/// Row-major numbers; an empty shape is one number.
struct Array {
  std::vector<int> shape;
  std::vector<double> values;
};

/// Named arrays and a text, which cross between C++ and an object in Python.
struct Parcel {
  std::map<std::string, Array> arrays;
  std::string text;

  void set(const std::string& name, double value) { arrays[name] = {{}, {value}}; }
  void set_seed(std::uint64_t seed) {  // a double holds 53 bits
    set("seed_high", double(seed >> 32));
    set("seed_low", double(seed & 0xffffffffu));
  }
  void set_grid(const GridSpec& g) {
    set("ny", g.ny);
    set("nx", g.nx);
    set("pitch_x_mm", g.pitch_x_mm);
    set("pitch_y_mm", g.pitch_y_mm);
    set("origin_x_mm", g.origin_x_mm);
    set("origin_y_mm", g.origin_y_mm);
  }
  /// @pre the name is there
  double number(const std::string& name) const { return arrays.at(name).values.at(0); }
};

/// An object of a class whose contract is in python/lib/firn/contract.py. Its state is a function of its
/// calls.
class Object {
 public:
  virtual ~Object() = default;
  /// @throws std::runtime_error as Controller::decide
  virtual Parcel call(const Parcel& with) = 0;
};

/// Kinds of such classes, and the method that is called.
enum class Kind : std::uint8_t {
  kEstimator,  ///< learn
  kPlant,      ///< deposit
  kSurface     ///< decide, of a print along paths
};

class Host {
 public:
  virtual ~Host() = default;

  /// Reads a file and the modules beside it that it imports, over any number of steps; the file comes first.
  /// @throws std::runtime_error naming file and line: unreadable, no Python, or an import that a print does
  /// not allow (a clock, threads, randomness without the seed, files, sockets, processes)
  virtual std::vector<SourceFile> sources(const std::string& path) = 0;

  /// Builds the object from the files alone: their folder is not read. Thread-safe.
  /// @throws std::runtime_error with the traceback of an exception
  virtual std::unique_ptr<Controller> make_controller(const std::vector<SourceFile>& files,
                                                      const ClassName& name, const ControllerSetup& setup,
                                                      std::shared_ptr<Prediction> prediction) = 0;

  /// The same for a class of another kind. @param longest_s wall time of one call
  virtual std::unique_ptr<Object> make_object(Kind kind, const std::vector<SourceFile>& files,
                                              const ClassName& name, const Parcel& setup,
                                              double longest_s) = 0;

  /// Returns the interpreter and the packages that files have imported so far, a line each: "Python 3.11.2",
  /// "numpy 1.24.2".
  virtual std::string versions() = 0;
};

/// Name and type of the function that a plug-in exports. It returns null if `interface` is not the digest of
/// this header that the plug-in was built with.
using HostFunction = Host* (*)(const char* interface);
inline constexpr const char* kHostFunction = "firn_python_host";

}  // namespace firn::python
