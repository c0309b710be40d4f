// Cvode solves a small system of ordinary differential equations by SUNDIALS' CVODE: Adams' method, iterated
// to a fixed point.
#pragma once

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <stdexcept>
#include <string>

#include "plant/ode/sun_comm.h"

namespace firn::plant {

/// The state begins at 0; tolerances are set by its owner.
struct Cvode {
  const char* name;  ///< of its owner, in errors
  SUNContext context = nullptr;
  N_Vector y = nullptr;
  SUNNonlinearSolver iteration = nullptr;
  void* memory = nullptr;

  Cvode(const char* owner, int states, CVRhsFn right_hand_side, void* user) : name(owner) {
    require(SUNContext_Create(SUN_COMM_NULL, &context), "SUNContext_Create");
    y = N_VNew_Serial(states, context);
    memory = CVodeCreate(CV_ADAMS, context);
    iteration = SUNNonlinSol_FixedPoint(y, 0, context);
    if (!y || !memory || !iteration) throw std::runtime_error(std::string(name) + ": no memory for CVODE");
    N_VConst(0.0, y);
    require(CVodeInit(memory, right_hand_side, 0.0, y), "CVodeInit");
    require(CVodeSetNonlinearSolver(memory, iteration), "CVodeSetNonlinearSolver");
    require(CVodeSetUserData(memory, user), "CVodeSetUserData");
    require(CVodeSetMaxNumSteps(memory, 100000), "CVodeSetMaxNumSteps");
  }
  Cvode(const Cvode&) = delete;
  Cvode& operator=(const Cvode&) = delete;
  ~Cvode() {
    CVodeFree(&memory);
    SUNNonlinSolFree(iteration);
    N_VDestroy(y);
    SUNContext_Free(&context);
  }

  /// @throws std::runtime_error naming the call, if its flag tells of a failure.
  void require(int flag, const char* call) const {
    if (flag < 0)
      throw std::runtime_error(std::string(name) + ": " + call + " failed, flag " + std::to_string(flag));
  }
};

}  // namespace firn::plant
