#include "bgsim/method.hpp"

#include <algorithm>
#include <array>

namespace bgsim {

namespace {

using Family = MethodFamily;

constexpr std::array<MethodFacts, 22> kMethods{{
    {Method::automatic, "auto", "chosen by the engine", Family::multistep, 0, 5},
    {Method::bdf, "bdf", "CVODE BDF", Family::multistep, 0, 5},
    {Method::adams, "adams", "CVODE Adams", Family::multistep, 0, 12},
    {Method::ida, "ida", "IDA", Family::multistep, 0, 5},
    {Method::erk2, "erk2", "ARKODE Heun-Euler 2(1)", Family::explicit_runge_kutta, 2, 0},
    {Method::erk3, "erk3", "ARKODE Bogacki-Shampine 3(2)", Family::explicit_runge_kutta, 3, 0},
    {Method::erk4, "erk4", "ARKODE Zonneveld 4(3)", Family::explicit_runge_kutta, 4, 0},
    {Method::erk5, "erk5", "ARKODE Dormand-Prince 5(4)", Family::explicit_runge_kutta, 5, 0},
    {Method::erk6, "erk6", "ARKODE Verner 6(5)", Family::explicit_runge_kutta, 6, 0},
    {Method::erk8, "erk8", "ARKODE Prince-Dormand 8(7)", Family::explicit_runge_kutta, 8, 0},
    {Method::dirk2, "dirk2", "ARKODE TR-BDF2 2(3)", Family::diagonally_implicit, 2, 0},
    {Method::dirk3, "dirk3", "ARKODE ESDIRK325L2SA 3(2)", Family::diagonally_implicit, 3, 0},
    {Method::dirk4, "dirk4", "ARKODE ESDIRK436L2SA 4(3)", Family::diagonally_implicit, 4, 0},
    {Method::dirk5, "dirk5", "ARKODE ESDIRK547L2SA2 5(4)", Family::diagonally_implicit, 5, 0},
    {Method::rodas5p, "rodas5p", "Rodas5P of order 5", Family::rosenbrock, 5, 0},
    {Method::radau, "radau", "Radau IIA of order 5", Family::collocation, 5, 0},
    {Method::radau9, "radau9", "Radau IIA of order 9", Family::collocation, 9, 0},
    {Method::radau13, "radau13", "Radau IIA of order 13", Family::collocation, 13, 0},
    {Method::euler, "euler", "explicit Euler", Family::fixed_step, 1, 0},
    {Method::implicit_euler, "implicit_euler", "implicit Euler", Family::fixed_step, 1, 0},
    {Method::rk4, "rk4", "classical Runge-Kutta of order 4", Family::fixed_step, 4, 0},
    {Method::verlet, "verlet", "Störmer-Verlet", Family::symplectic_fixed_step, 2, 0},
}};

constexpr bool methods_in_order() {
  for (std::size_t i = 0; i < kMethods.size(); ++i)
    if (kMethods[i].method != static_cast<Method>(i)) return false;
  return true;
}
static_assert(methods_in_order());

}  // namespace

std::span<const MethodFacts> all_methods() { return kMethods; }

const MethodFacts& facts_of(Method method) { return kMethods[static_cast<std::size_t>(method)]; }

std::optional<Method> method_from(const std::string& name) {
  const auto found = std::find_if(kMethods.begin(), kMethods.end(), [&](const auto& m) { return name == m.name; });
  return found == kMethods.end() ? std::nullopt : std::optional(found->method);
}

std::string method_name(Method method) { return facts_of(method).name; }

std::string method_list() {
  std::string text;
  for (const MethodFacts& facts : kMethods)
    text += (text.empty() ? "" : &facts == &kMethods.back() ? " and " : ", ") + std::string(facts.name);
  return text;
}

}  // namespace bgsim
