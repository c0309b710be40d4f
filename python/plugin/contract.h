// Contract holds the module `firn` of a controller's files (python/lib/firn/contract.py) inside an
// interpreter.
#pragma once

#include <pybind11/pybind11.h>

#include "python/host/python_host.h"

namespace firn::python {

/// Implements the interface on an interpreter that runs. Every function takes the interpreter itself.
class ContractHost final : public Host {
 public:
  /// @param contract the module. @pre the thread holds the interpreter
  explicit ContractHost(pybind11::object contract);

  std::vector<SourceFile> sources(const std::string& path) override;
  std::unique_ptr<Controller> make_controller(const std::vector<SourceFile>& files, const ClassName& name,
                                              const ControllerSetup& setup,
                                              std::shared_ptr<Prediction> prediction) override;
  std::unique_ptr<Object> make_object(Kind kind, const std::vector<SourceFile>& files, const ClassName& name,
                                      const Parcel& setup, double longest_s) override;
  std::string versions() override;

 private:
  struct Shared;
  template <class... Arguments>
  pybind11::object run_of(const char* maker, const std::vector<SourceFile>& files, const ClassName& name,
                          double longest_s, const Arguments&... arguments);

  std::shared_ptr<Shared> shared_;
};

/// Runs the contract's text as the module `firn`. @pre the thread holds the interpreter
pybind11::object run_contract();

}  // namespace firn::python
