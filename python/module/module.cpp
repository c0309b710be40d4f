#include "python/module/module.h"
#include "python/host/c_locale.h"

namespace firn::python {
namespace {

PyObject* error_class = PyExc_ValueError;  // firn.FirnError, once the package has handed it over

// Makes a Python exception with Firn's text of everything that Firn refuses; Python's own pass as they are.
template <class Answer, class... Arguments>
struct Told {
  Answer (*function)(Arguments...);

  Answer operator()(Arguments... arguments) const {
    const CLocale numbers_have_a_point;  // the program of the user may have another locale
    try {
      return function(std::forward<Arguments>(arguments)...);
    } catch (const NeedsProgram&) {
      throw;
    } catch (const py::error_already_set&) {
      throw;
    } catch (const py::builtin_exception&) {
      throw;
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& e) {
      PyErr_SetString(error_class, e.what());
      throw py::error_already_set();
    }
  }
};

template <class Answer, class... Arguments>
Told<Answer, Arguments...> told(Answer (*function)(Arguments...)) {
  return {function};
}

}  // namespace

}  // namespace firn::python

PYBIND11_MODULE(firn_core, m) {
  using namespace firn::python;
  m.doc() = "Firn's cores; the package firn wraps them.";
  py::register_exception<NeedsProgram>(m, "NeedsProgram");
  m.def("raise_errors_as", [](const py::object& type) { error_class = py::object(type).release().ptr(); });
  m.def("decide", told(&decide));
  m.def("slice", told(&slice));
  m.def("plan", told(&plan));
}
