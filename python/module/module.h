// The Python module firn_core: Firn's cores with numpy arrays in and out (python/lib/firn/commands.py wraps
// it). Computations run without the interpreter's lock; Ctrl-C ends the long ones.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <atomic>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/grid/grid.h"
#include "python/host/c_locale.h"
#include "runtime/thread_pool.h"

namespace firn::python {

namespace py = pybind11;

constexpr auto kRowMajor = py::array::c_style | py::array::forcecast;
using Doubles = py::array_t<double, kRowMajor>;
using Bytes = py::array_t<std::uint8_t, kRowMajor>;

/// The computation wants the program: a scheme is a Python file, which runs in an interpreter of Firn's own,
/// or only the command plans for the machine.
struct NeedsProgram : std::runtime_error {
  using runtime_error::runtime_error;
};

/// Ended by `stop`.
struct Stopped : std::runtime_error {
  Stopped() : std::runtime_error("interrupted") {}
};

/// As parallel_on(), in the C locale: the program of the user may have another one.
inline ParallelFor parallel_in_c_locale(int threads) {
  return [run = parallel_on(thread_count(threads))](int n, const std::function<void(int)>& body) {
    run(n, [&](int i) {
      const CLocale numbers_have_a_point;
      body(i);
    });
  };
}

/// Returns an array that owns a copy of the values.
template <class T>
py::array_t<T> array_of(std::vector<py::ssize_t> shape, const T* values) {
  return py::array_t<T>(std::move(shape), values);
}

py::dict decide(const Doubles& height_mm, const Doubles& target_mm, const std::optional<Bytes>& mask,
                const std::vector<std::string>& settings, int threads);
py::dict slice(const std::vector<std::string>& meshes, const std::vector<int>& layers,
               const std::string& settings_file, const std::vector<std::string>& settings, int threads);
py::tuple plan(const Doubles& points_mm, const std::string& machine, bool closed, double origin_x_mm,
               double origin_y_mm, const std::string& method, double tolerance_mm);

}  // namespace firn::python
