// CvodeKrylov solves a large stiff system of ordinary differential equations by SUNDIALS' CVODE: backward
// differentiation formulas, Newton's iteration, and GMRES with a preconditioner from its owner.
#pragma once

#include <cvode/cvode.h>
#include <cvode/cvode_ls.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <stdexcept>
#include <string>

#include "plant/ode/sun_comm.h"

namespace firn::plant {

struct CvodeKrylov {
  const char* name;  ///< of its owner, in errors
  SUNContext context = nullptr;
  N_Vector y = nullptr;
  SUNLinearSolver linear = nullptr;
  SUNNonlinearSolver iteration = nullptr;
  void* memory = nullptr;

  /// @param setup, solve of the preconditioner, as CVodeSetPreconditioner has them
  CvodeKrylov(const char* owner, sunindextype states, CVRhsFn right_hand_side, CVLsPrecSetupFn setup,
              CVLsPrecSolveFn solve, double relative, double absolute, void* user)
      : name(owner) {
    constexpr int kSubspace = 60;
    constexpr long kMostSteps = 200000;
    require(SUNContext_Create(SUN_COMM_NULL, &context), "SUNContext_Create");
    y = N_VNew_Serial(states, context);
    memory = CVodeCreate(CV_BDF, context);
    linear = SUNLinSol_SPGMR(y, SUN_PREC_RIGHT, kSubspace, context);
    iteration = SUNNonlinSol_Newton(y, context);
    if (!y || !memory || !linear || !iteration)
      throw std::runtime_error(std::string(name) + ": no memory for CVODE");
    N_VConst(0.0, y);
    require(CVodeInit(memory, right_hand_side, 0.0, y), "CVodeInit");
    require(CVodeSStolerances(memory, relative, absolute), "CVodeSStolerances");
    // Before the linear solver, which takes it over.
    require(CVodeSetUserData(memory, user), "CVodeSetUserData");
    require(CVodeSetNonlinearSolver(memory, iteration), "CVodeSetNonlinearSolver");
    require(CVodeSetLinearSolver(memory, linear, nullptr), "CVodeSetLinearSolver");
    require(CVodeSetPreconditioner(memory, setup, solve), "CVodeSetPreconditioner");
    require(CVodeSetMaxNumSteps(memory, kMostSteps), "CVodeSetMaxNumSteps");
  }
  CvodeKrylov(const CvodeKrylov&) = delete;
  CvodeKrylov& operator=(const CvodeKrylov&) = delete;
  ~CvodeKrylov() {
    CVodeFree(&memory);
    SUNLinSolFree(linear);
    SUNNonlinSolFree(iteration);
    N_VDestroy(y);
    SUNContext_Free(&context);
  }

  /// @throws std::runtime_error naming the call, if its flag tells of a failure
  void require(int flag, const char* call) const {
    if (flag < 0)
      throw std::runtime_error(std::string(name) + ": " + call + " failed, flag " + std::to_string(flag));
  }
};

}  // namespace firn::plant
