/// CVODE, ARKODE and IDA under the same names: what SUNDIALS calls differently in each package, and nothing else. A
/// name that a package lacks is a capability it does not have (`requires` in sundials_integrator.hpp).
#pragma once

#include <arkode/arkode_arkstep.h>
#include <cvode/cvode.h>
#include <ida/ida.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <string>

#include "bgsim/text.hpp"
#include "run/integrate/sundials.hpp"

namespace bgsim {

/// A return flag that a run is known to end with, in words.
struct FlagText {
  int flag;
  const char* text;
};

inline constexpr const char* kTooAccurateText = "the tolerance is beyond double precision";
inline constexpr const char* kErrorTestText = "the estimated error stayed too large however small the step";
inline constexpr const char* kIterationText = "the corrector iteration did not converge however small the step";
inline constexpr const char* kLinearText = "the linear system of a step could not be solved";
inline constexpr const char* kStateEquationsText = "the state equations could not be evaluated";
inline constexpr const char* kTooCloseText = "the stretch of time is shorter than the resolution of the time itself";

struct Cvode {
  using Handle = CvodeHandle;
  static constexpr const char* kName = "CVODE";
  static constexpr const char* kNoStart = kStateEquationsText;
  static constexpr int kTooAccurate = CV_TOO_MUCH_ACC, kAtLimit = CV_TSTOP_RETURN, kSuccess = CV_SUCCESS;
  static constexpr auto flag_name = CVodeGetReturnFlagName;
  static constexpr std::array<FlagText, 11> kTexts{{{CV_TOO_MUCH_ACC, kTooAccurateText},
                                                    {CV_ERR_FAILURE, kErrorTestText},
                                                    {CV_CONV_FAILURE, kIterationText},
                                                    {CV_LINIT_FAIL, kLinearText},
                                                    {CV_LSETUP_FAIL, kLinearText},
                                                    {CV_LSOLVE_FAIL, kLinearText},
                                                    {CV_RHSFUNC_FAIL, kStateEquationsText},
                                                    {CV_FIRST_RHSFUNC_ERR, kStateEquationsText},
                                                    {CV_REPTD_RHSFUNC_ERR, kStateEquationsText},
                                                    {CV_UNREC_RHSFUNC_ERR, kStateEquationsText},
                                                    {CV_TOO_CLOSE, kTooCloseText}}};

  static constexpr auto capture_errors = CVodeSetErrHandlerFn;
  static constexpr auto set_user = CVodeSetUserData;
  static constexpr auto set_weights = CVodeWFtolerances;
  static constexpr auto set_linear_solver = CVodeSetLinearSolver;
  static constexpr auto set_jacobian = CVodeSetJacFn;
  static constexpr auto set_most_steps = CVodeSetMaxNumSteps;
  static constexpr auto set_most_error_failures = CVodeSetMaxErrTestFails;
  static constexpr auto set_most_warnings = CVodeSetMaxHnilWarns;
  static constexpr auto set_longest_step = CVodeSetMaxStep;
  static constexpr auto set_order = CVodeSetMaxOrd;
  static constexpr auto set_limit = CVodeSetStopTime;
  static constexpr auto set_first_step = CVodeSetInitStep;

  static constexpr auto last_order = CVodeGetLastOrder;
  static constexpr auto current_time = CVodeGetCurrentTime;
  static constexpr auto current_step = CVodeGetCurrentStep;
  static constexpr auto interpolate = CVodeGetDky;
  static constexpr auto local_errors = CVodeGetEstLocalErrors;
  static constexpr auto weights = CVodeGetErrWeights;

  static constexpr auto steps = CVodeGetNumSteps;
  static constexpr auto rates = CVodeGetNumRhsEvals;
  static constexpr auto factorizations = CVodeGetNumLinSolvSetups;
  static constexpr auto jacobians = CVodeGetNumJacEvals;
  static constexpr auto iterations = CVodeGetNumNonlinSolvIters;
  static constexpr auto error_failures = CVodeGetNumErrTestFails;
  static constexpr auto convergence_failures = CVodeGetNumStepSolveFails;
};

struct Arkode {
  using Handle = ArkodeHandle;
  static constexpr const char* kName = "ARKODE";
  static constexpr const char* kNoStart = kStateEquationsText;
  static constexpr int kTooAccurate = ARK_TOO_MUCH_ACC, kAtLimit = ARK_TSTOP_RETURN, kSuccess = ARK_SUCCESS;
  static constexpr auto flag_name = ARKStepGetReturnFlagName;
  static constexpr std::array<FlagText, 11> kTexts{{{ARK_TOO_MUCH_ACC, kTooAccurateText},
                                                    {ARK_ERR_FAILURE, kErrorTestText},
                                                    {ARK_CONV_FAILURE, "the corrector iteration did not converge"},
                                                    {ARK_LINIT_FAIL, kLinearText},
                                                    {ARK_LSETUP_FAIL, kLinearText},
                                                    {ARK_LSOLVE_FAIL, kLinearText},
                                                    {ARK_RHSFUNC_FAIL, kStateEquationsText},
                                                    {ARK_FIRST_RHSFUNC_ERR, kStateEquationsText},
                                                    {ARK_REPTD_RHSFUNC_ERR, kStateEquationsText},
                                                    {ARK_UNREC_RHSFUNC_ERR, kStateEquationsText},
                                                    {ARK_TOO_CLOSE, kTooCloseText}}};

  static constexpr auto capture_errors = ARKStepSetErrHandlerFn;
  static constexpr auto set_user = ARKStepSetUserData;
  static constexpr auto set_weights = ARKStepWFtolerances;
  static constexpr auto set_linear_solver = ARKStepSetLinearSolver;
  static constexpr auto set_jacobian = ARKStepSetJacFn;
  static constexpr auto set_most_steps = ARKStepSetMaxNumSteps;
  static constexpr auto set_most_error_failures = ARKStepSetMaxErrTestFails;
  static constexpr auto set_most_warnings = ARKStepSetMaxHnilWarns;
  static constexpr auto set_longest_step = ARKStepSetMaxStep;
  static constexpr auto set_limit = ARKStepSetStopTime;
  static constexpr auto set_first_step = ARKStepSetInitStep;

  static constexpr auto current_time = ARKStepGetCurrentTime;
  static constexpr auto current_step = ARKStepGetCurrentStep;
  static constexpr auto interpolate = ARKStepGetDky;
  static constexpr auto local_errors = ARKStepGetEstLocalErrors;
  static constexpr auto weights = ARKStepGetErrWeights;

  static constexpr auto steps = ARKStepGetNumSteps;
  static int rates(void* memory, long* count) {  // of the explicit and of the implicit part
    long expl = 0, impl = 0;
    const int flag = ARKStepGetNumRhsEvals(memory, &expl, &impl);
    *count = expl + impl;
    return flag;
  }
  static constexpr auto factorizations = ARKStepGetNumLinSolvSetups;
  static constexpr auto jacobians = ARKStepGetNumJacEvals;
  static constexpr auto iterations = ARKStepGetNumNonlinSolvIters;
  static constexpr auto error_failures = ARKStepGetNumErrTestFails;
  static constexpr auto convergence_failures = ARKStepGetNumStepSolveFails;
};

struct Ida {
  using Handle = IdaHandle;
  static constexpr const char* kName = "IDA";
  static constexpr const char* kNoStart = "the equations could not be evaluated";
  static constexpr int kTooAccurate = IDA_TOO_MUCH_ACC, kAtLimit = IDA_TSTOP_RETURN, kSuccess = IDA_SUCCESS;
  static constexpr auto flag_name = IDAGetReturnFlagName;
  static constexpr std::array<FlagText, 9> kTexts{{{IDA_TOO_MUCH_ACC, kTooAccurateText},
                                                   {IDA_ERR_FAIL, kErrorTestText},
                                                   {IDA_CONV_FAIL, kIterationText},
                                                   {IDA_LINIT_FAIL, kLinearText},
                                                   {IDA_LSETUP_FAIL, kLinearText},
                                                   {IDA_LSOLVE_FAIL, kLinearText},
                                                   {IDA_RES_FAIL, kNoStart},
                                                   {IDA_REP_RES_ERR, kNoStart},
                                                   {IDA_FIRST_RES_FAIL, kNoStart}}};

  static constexpr auto capture_errors = IDASetErrHandlerFn;
  static constexpr auto set_user = IDASetUserData;
  static constexpr auto set_weights = IDAWFtolerances;
  static constexpr auto set_linear_solver = IDASetLinearSolver;
  static constexpr auto set_jacobian = IDASetJacFn;
  static constexpr auto set_most_steps = IDASetMaxNumSteps;
  static constexpr auto set_most_error_failures = IDASetMaxErrTestFails;
  static constexpr auto set_longest_step = IDASetMaxStep;
  static constexpr auto set_order = IDASetMaxOrd;
  static constexpr auto set_limit = IDASetStopTime;
  static constexpr auto set_first_step = IDASetInitStep;

  static constexpr auto last_order = IDAGetLastOrder;
  static constexpr auto current_time = IDAGetCurrentTime;
  static constexpr auto current_step = IDAGetCurrentStep;
  static constexpr auto interpolate = IDAGetDky;
  static constexpr auto local_errors = IDAGetEstLocalErrors;
  static constexpr auto weights = IDAGetErrWeights;

  static constexpr auto steps = IDAGetNumSteps;
  static constexpr auto rates = IDAGetNumResEvals;
  static constexpr auto factorizations = IDAGetNumLinSolvSetups;
  static constexpr auto jacobians = IDAGetNumJacEvals;
  static constexpr auto iterations = IDAGetNumNonlinSolvIters;
  static constexpr auto error_failures = IDAGetNumErrTestFails;
  static constexpr auto convergence_failures = IDAGetNumStepSolveFails;
};

/// A return flag in words: "the error test failed repeatedly or with the smallest step". A flag that a run is not known
/// to end with is given by its name and SUNDIALS' own text.
template <class Package>
std::string flag_words(int flag, const std::string& own_text) {
  for (const FlagText& row : Package::kTexts)
    if (row.flag == flag) return row.text;
  // The library allocates the name with malloc and hands it over.
  const std::unique_ptr<char, void (*)(void*)> name(Package::flag_name(flag), std::free);
  std::string words = Package::kName;
  words.append(" returned ").append(name.get());
  if (!own_text.empty()) words.append(": ").append(visible_line(own_text));
  return words;
}

}  // namespace bgsim
