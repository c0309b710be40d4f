// The plug-in: an interpreter of Firn's own inside the process (python/host/load.h).
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>

#include "python/plugin/contract.h"

namespace firn::python {
namespace {

namespace py = pybind11;

void check(const PyStatus& status) {
  if (PyStatus_Exception(status))
    throw std::runtime_error(std::string("Python does not start: ") +
                             (status.err_msg ? status.err_msg : "unknown cause"));
}

constexpr const char* kVersion = PY_VERSION;

// Packages of another Python cannot be loaded, and most would be found missing by a name that says nothing.
void check_environment(const std::string& folder) {
  const std::string file = folder + "/pyvenv.cfg";
  std::ifstream in(file);
  if (!in)
    throw std::runtime_error(
        file + " is not there: VIRTUAL_ENV names no virtual environment (deactivate, or unset VIRTUAL_ENV)");
  const std::string ours = std::to_string(PY_MAJOR_VERSION) + "." + std::to_string(PY_MINOR_VERSION) + ".";
  for (std::string line; std::getline(in, line);) {
    std::string key = line.substr(0, line.find('=')),
                value = line.substr(std::min(line.find('=') + 1, line.size()));
    std::erase(key, ' ');
    std::erase_if(value, [](char c) { return c == ' ' || c == '\r'; });
    if ((key == "version" || key == "version_info") && !(value + ".").starts_with(ours))
      throw std::runtime_error(file + ": the virtual environment is of Python " + value +
                               ", Firn's plug-in holds Python " + kVersion + ": make one with python" +
                               ours.substr(0, ours.size() - 1) + " -m venv, or deactivate it");
  }
}

// One thread for linear algebra, and one order of sets: the same input gives the same bytes. For the same
// reason the locale is C and files' names are UTF-8.
void start_interpreter() {
  for (const char* name : {"OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"})
    setenv(name, "1", 1);
  const char* environment = std::getenv("VIRTUAL_ENV");
  const bool in_environment = environment && *environment;
  if (in_environment) check_environment(environment);
  PyPreConfig before;
  PyPreConfig_InitPythonConfig(&before);
  before.configure_locale = 0;
  before.coerce_c_locale = 0;
  before.utf8_mode = 1;
  check(Py_PreInitialize(&before));
  PyConfig config;
  PyConfig_InitPythonConfig(&config);
  config.use_hash_seed = 1;
  config.hash_seed = 0;
  config.install_signal_handlers = 0;  // the program has its own
  config.write_bytecode = 0;
  const std::string program =
      in_environment ? std::string(environment) + "/bin/python3" : std::string("/usr/bin/python3");
  check(PyConfig_SetBytesString(&config, &config.program_name, program.c_str()));
  const PyStatus status = Py_InitializeFromConfig(&config);
  PyConfig_Clear(&config);
  check(status);
}

// "" outside of a virtual environment.
std::string where() {
  const char* environment = std::getenv("VIRTUAL_ENV");
  return environment && *environment ? std::string(" in ") + environment : "";
}

// A process has one interpreter, which starts once or not at all, and ends with the process.
struct Started {
  Host* host = nullptr;
  std::string trouble;
};

Started start() {
  Started started;
  try {
    start_interpreter();
  } catch (const std::exception& error) {
    return {nullptr, error.what()};
  }
  try {
    const py::object contract = run_contract();
    contract.attr("make_strict")();
    started.host = new ContractHost(contract);
  } catch (const std::exception& error) {
    started.trouble = std::string("Firn's plug-in for Python ") + kVersion + where() + ": " + error.what();
  }
  PyEval_SaveThread();
  return started;
}

}  // namespace
}  // namespace firn::python

extern "C" __attribute__((visibility("default"))) firn::python::Host* firn_python_host(
    const char* interface) {
  if (std::strcmp(interface, FIRN_HOST_INTERFACE) != 0) return nullptr;
  static const firn::python::Started started = firn::python::start();
  if (!started.host) throw std::runtime_error(started.trouble);
  return started.host;
}
