/// The integration methods and what is known of each.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace bgsim {

/// Integration methods. `automatic` lets the engine choose.
enum class Method : std::uint8_t {
  automatic,
  bdf,
  adams,
  ida,
  erk2,
  erk3,
  erk4,
  erk5,
  erk6,
  erk8,
  dirk2,
  dirk3,
  dirk4,
  dirk5,
  rodas5p,
  radau,
  radau9,
  radau13,
  euler,
  implicit_euler,
  rk4,
  verlet
};

enum class MethodFamily : std::uint8_t {
  multistep,              ///< variable order: CVODE, IDA
  explicit_runge_kutta,   ///< ARKODE, error-controlled steps
  diagonally_implicit,    ///< ARKODE, error-controlled steps
  rosenbrock,             ///< Rodas5P, error-controlled steps: linear systems with the Jacobian, no iteration
  collocation,            ///< Radau IIA, error-controlled steps
  fixed_step,             ///< ARKODE with steps of one length
  symplectic_fixed_step,  ///< Störmer-Verlet
};

struct MethodFacts {
  Method method;
  const char* name;   ///< in scenes and on the command line
  const char* words;  ///< in reports: "ESDIRK of order 4"
  MethodFamily family;
  int order;       ///< of Runge-Kutta and fixed-step methods; 0: variable
  int most_order;  ///< that --max-order may name; 0: the order is the method's own
  [[nodiscard]] bool fixed_step() const {
    return family == MethodFamily::fixed_step || family == MethodFamily::symplectic_fixed_step;
  }
  /// The step's equations are solved by Newton's iteration with the Jacobian.
  [[nodiscard]] bool implicit() const {
    return family == MethodFamily::multistep || family == MethodFamily::diagonally_implicit ||
           family == MethodFamily::collocation || method == Method::implicit_euler;
  }
};

/// All methods, in the order of the enumeration.
std::span<const MethodFacts> all_methods();
const MethodFacts& facts_of(Method method);
std::optional<Method> method_from(const std::string& name);
std::string method_name(Method method);
/// "auto, bdf, ... and verlet", for messages.
std::string method_list();

}  // namespace bgsim
