// CVODE and ARKODE of SUNDIALS on q and u: A. C. Hindmarsh et al., "SUNDIALS: Suite of nonlinear
// and differential/algebraic equation solvers", ACM TOMS 31(3), 2005. They are reinitialised at
// every physics step, where commands jump. No internal history outlives a step: results depend only
// on the state. This is the only file that includes SUNDIALS.
#include <arkode/arkode_arkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_config.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "core/base/system/error.h"
#include "core/physics/step/integrator.h"

// SUNDIALS 6 under the names of SUNDIALS 7.
// NOLINTBEGIN(readability-identifier-naming)
#if SUNDIALS_VERSION_MAJOR < 7
#define SUN_COMM_NULL nullptr
#define ARKodeFree ARKStepFree
#define ARKodeSetUserData ARKStepSetUserData
#define ARKodeSetOrder ARKStepSetOrder
#define ARKodeSStolerances ARKStepSStolerances
#define ARKodeSetMaxNumSteps ARKStepSetMaxNumSteps
#define ARKodeSetLinearSolver ARKStepSetLinearSolver
#define ARKodeSetStopTime ARKStepSetStopTime
#define ARKodeEvolve ARKStepEvolve
#endif
// NOLINTEND(readability-identifier-naming)

namespace skybody {
namespace {

/// Checks the return value of a SUNDIALS function during construction.
void demand(int flag, const char* function) {
  if (flag < 0) throw Error(std::string(function) + " failed: " + std::to_string(flag));
}
template <class T>
T* demand(T* made, const char* function) {
  if (made == nullptr) throw Error(std::string(function) + " failed");
  return made;
}

template <auto kFree>
struct Free {
  template <class T>
  void operator()(T* made) const {
    kFree(made);
  }
};
template <class Handle, auto kFree>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Free<kFree>>;

void free_context(SUNContext context) { SUNContext_Free(&context); }
void free_linear_solver(SUNLinearSolver solver) { SUNLinSolFree(solver); }
void free_nonlinear_solver(SUNNonlinearSolver solver) { SUNNonlinSolFree(solver); }
void free_cvode(void* memory) { CVodeFree(&memory); }
void free_arkode(void* memory) { ARKodeFree(&memory); }

/// Messages on stderr are suppressed: an error is reported as a fault of the environment.
#if SUNDIALS_VERSION_MAJOR < 7
void ignore_message(int, const char*, const char*, char*, void*) {}
void silence(SUNContext) {}
void silence_cvode(void* cvode) {
  demand(CVodeSetErrHandlerFn(cvode, &ignore_message, nullptr), "CVodeSetErrHandlerFn");
}
void silence_arkode(void* arkode) {
  demand(ARKStepSetErrHandlerFn(arkode, &ignore_message, nullptr), "ARKStepSetErrHandlerFn");
}
#else
void silence(SUNContext context) {
  demand(SUNContext_ClearErrHandlers(context), "SUNContext_ClearErrHandlers");
  demand(SUNContext_SetLogger(context, nullptr), "SUNContext_SetLogger");
}
void silence_cvode(void*) {}
void silence_arkode(void*) {}
#endif

SUNContext new_context() {
  SUNContext context = nullptr;
  demand(SUNContext_Create(SUN_COMM_NULL, &context), "SUNContext_Create");
  silence(context);
  return context;
}

/// Common part of CVODE and ARKODE: y = (q, u), its derivative, and matrices for implicit methods.
class SundialsIntegrator : public Integrator {
 public:
  explicit SundialsIntegrator(const World& world)
      : settings_(world.scenario.stepping.solver),
        dt_(world.scenario.stepping.dt),
        q_count_(static_cast<std::size_t>(world.layout.q.size)),
        u_count_(static_cast<std::size_t>(world.layout.u.size)),
        context_(new_context()),
        y_(demand(N_VNew_Serial(static_cast<sunindextype>(q_count_ + u_count_), context()),
                  "N_VNew_Serial")) {}

  void advance(const Rates& rates, double* q, double* u) override {
    if (q_count_ + u_count_ == 0) return;
    rates_ = &rates;
    error_ = nullptr;
    double* y = N_VGetArrayPointer(y_.get());
    std::memcpy(y, q, q_count_ * sizeof(double));
    std::memcpy(y + q_count_, u, u_count_ * sizeof(double));
    const int flag = solve();
    if (error_) std::rethrow_exception(error_);
    // Too many internal steps, or no step size meets the tolerance.
    if (flag < 0) throw std::runtime_error("SUNDIALS gave up: " + std::to_string(flag));
    std::memcpy(q, y, q_count_ * sizeof(double));
    std::memcpy(u, y + q_count_, u_count_ * sizeof(double));
  }

 protected:
  /// Integrates y from time 0 to dt. @returns SUNDIALS' flag, < 0 on failure
  virtual int solve() = 0;

  /// dy/dt for SUNDIALS. Returns 1 to request another point (or a failure), -1 to stop.
  static int derivative(sunrealtype time, N_Vector y, N_Vector rates, void* self) {
    auto& me = *static_cast<SundialsIntegrator*>(self);
    const double* q = N_VGetArrayPointer(y);
    const double* u = q + me.q_count_;
    double* qdot = N_VGetArrayPointer(rates);
    const std::size_t count = me.q_count_ + me.u_count_;
    if (!are_finite(q, count)) return 1;
    try {
      (*me.rates_)(q, u, time, qdot, qdot + me.q_count_);
      if (!are_finite(qdot, count)) return 1;
    } catch (const std::runtime_error&) {  // the dynamics fails there
      return 1;
    } catch (...) {  // must not pass through C
      me.error_ = std::current_exception();
      return -1;
    }
    return 0;
  }

  static bool are_finite(const double* values, std::size_t count) {
    return std::all_of(values, values + count, [](double v) { return std::isfinite(v); });
  }

  void make_linear_solver() {
    const auto size = static_cast<sunindextype>(q_count_ + u_count_);
    matrix_.reset(demand(SUNDenseMatrix(size, size, context()), "SUNDenseMatrix"));
    linear_solver_.reset(demand(SUNLinSol_Dense(y(), matrix_.get(), context()), "SUNLinSol_Dense"));
  }

  const SolverSettings& settings() const { return settings_; }
  double dt() const { return dt_; }
  SUNContext context() const { return context_.get(); }
  N_Vector y() const { return y_.get(); }
  SUNMatrix matrix() const { return matrix_.get(); }
  SUNLinearSolver linear_solver() const { return linear_solver_.get(); }

 private:
  SolverSettings settings_;
  double dt_;
  std::size_t q_count_, u_count_;
  Owned<SUNContext, &free_context> context_;
  Owned<N_Vector, &N_VDestroy> y_;
  Owned<SUNMatrix, &SUNMatDestroy> matrix_;                    ///< null: explicit
  Owned<SUNLinearSolver, &free_linear_solver> linear_solver_;  ///< likewise
  const Rates* rates_ = nullptr;                               ///< of the current step
  std::exception_ptr error_;                                   ///< thrown in `derivative`
};

/// Adams-Moulton of orders 1 to 12 with fixed-point iteration, or BDF of orders 1 to 5 with
/// Newton's method.
class Cvode final : public SundialsIntegrator {
 public:
  explicit Cvode(const World& world)
      : SundialsIntegrator(world),
        memory_(demand(CVodeCreate(is_stiff() ? CV_BDF : CV_ADAMS, context()), "CVodeCreate")) {
    void* cvode = memory_.get();
    silence_cvode(cvode);
    demand(CVodeInit(cvode, &derivative, 0.0, y()), "CVodeInit");
    demand(CVodeSetUserData(cvode, static_cast<SundialsIntegrator*>(this)), "CVodeSetUserData");
    demand(CVodeSStolerances(cvode, settings().relative_tolerance, settings().absolute_tolerance),
           "CVodeSStolerances");
    demand(CVodeSetMaxNumSteps(cvode, settings().max_steps), "CVodeSetMaxNumSteps");
    if (is_stiff()) {
      make_linear_solver();
      demand(CVodeSetLinearSolver(cvode, linear_solver(), matrix()), "CVodeSetLinearSolver");
    } else {
      fixed_point_.reset(demand(SUNNonlinSol_FixedPoint(y(), 0, context()), "SUNNonlinSol"));
      demand(CVodeSetNonlinearSolver(cvode, fixed_point_.get()), "CVodeSetNonlinearSolver");
    }
  }

 private:
  bool is_stiff() const { return settings().method == SolverMethod::kBdf; }

  int solve() override {
    sunrealtype reached = 0.0;
    if (const int flag = CVodeReInit(memory_.get(), 0.0, y()); flag < 0) return flag;
    if (const int flag = CVodeSetStopTime(memory_.get(), dt()); flag < 0) return flag;
    return CVode(memory_.get(), dt(), y(), &reached, CV_NORMAL);
  }

  Owned<SUNNonlinearSolver, &free_nonlinear_solver> fixed_point_;
  Owned<void*, &free_cvode> memory_;  ///< destroyed first: it uses the solvers
};

/// Runge-Kutta methods of order 4: Zonneveld's explicit one, or the diagonally implicit one of
/// Hairer and Wanner (SDIRK 5, 4).
class Arkode final : public SundialsIntegrator {
 public:
  explicit Arkode(const World& world)
      : SundialsIntegrator(world),
        memory_(demand(ARKStepCreate(explicit_part(), implicit_part(), 0.0, y(), context()),
                       "ARKStepCreate")) {
    void* arkode = memory_.get();
    silence_arkode(arkode);
    demand(ARKodeSetUserData(arkode, static_cast<SundialsIntegrator*>(this)), "ARKodeSetUserData");
    demand(ARKodeSetOrder(arkode, 4), "ARKodeSetOrder");
    demand(ARKodeSStolerances(arkode, settings().relative_tolerance, settings().absolute_tolerance),
           "ARKodeSStolerances");
    demand(ARKodeSetMaxNumSteps(arkode, settings().max_steps), "ARKodeSetMaxNumSteps");
    if (is_stiff()) {
      make_linear_solver();
      demand(ARKodeSetLinearSolver(arkode, linear_solver(), matrix()), "ARKodeSetLinearSolver");
    }
  }

 private:
  bool is_stiff() const { return settings().method == SolverMethod::kDirk; }
  ARKRhsFn explicit_part() const { return is_stiff() ? nullptr : &derivative; }
  ARKRhsFn implicit_part() const { return is_stiff() ? &derivative : nullptr; }

  int solve() override {
    sunrealtype reached = 0.0;
    const int flag = ARKStepReInit(memory_.get(), explicit_part(), implicit_part(), 0.0, y());
    if (flag < 0) return flag;
    if (const int stop = ARKodeSetStopTime(memory_.get(), dt()); stop < 0) return stop;
    return ARKodeEvolve(memory_.get(), dt(), y(), &reached, ARK_NORMAL);
  }

  Owned<void*, &free_arkode> memory_;  ///< destroyed first: it uses the solvers
};

}  // namespace

std::unique_ptr<Integrator> make_integrator(const World& world) {
  const IntegratorChoice choice = world.scenario.stepping.integrator;
  if (choice == IntegratorChoice::kCvode) return std::make_unique<Cvode>(world);
  if (choice == IntegratorChoice::kArkode) return std::make_unique<Arkode>(world);
  return nullptr;
}

}  // namespace skybody
