// The plug-in: an interpreter of Firn's own inside the process (python/host/load.h).
#include <cstdlib>
#include <cstring>
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

// One thread for linear algebra, and one order of sets: the same input gives the same bytes.
void start_interpreter() {
  for (const char* name : {"OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"})
    setenv(name, "1", 1);
  PyConfig config;
  PyConfig_InitPythonConfig(&config);
  config.use_hash_seed = 1;
  config.hash_seed = 0;
  config.install_signal_handlers = 0;  // the program has its own
  config.write_bytecode = 0;
  const char* environment = std::getenv("VIRTUAL_ENV");
  const std::string program = environment && *environment ? std::string(environment) + "/bin/python3"
                                                          : std::string("/usr/bin/python3");
  check(PyConfig_SetBytesString(&config, &config.program_name, program.c_str()));
  const PyStatus status = Py_InitializeFromConfig(&config);
  PyConfig_Clear(&config);
  check(status);
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
    const py::object contract = run_contract("firn");
    py::module_::import("sys").attr("modules")["firn"] = contract;
    contract.attr("make_strict")();
    started.host = new ContractHost(contract);
  } catch (const std::exception& error) {
    started.trouble = std::string("Firn's plug-in for Python: ") + error.what();
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
