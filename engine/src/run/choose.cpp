#include "run/choose.hpp"

#include <algorithm>

#include "bgsim/text.hpp"
#include "run/integrate/integrator.hpp"

namespace bgsim {

MethodChoice choose_method(const Program& program, const RunInputs& inputs, std::optional<double> multistep_since) {
  // Up to here matrices are written out (radau_systems). A chain of ten states costs as much by either method at equal
  // error; beyond, a step's two factorizations cost more than the steps that they save.
  constexpr std::size_t kSmall = 8;
  if (inputs.method != Method::automatic) return {inputs.method, "asked for"};
  const std::string loops =
      program.blocks.empty() ? "state equations without loops" : "loops are solved inside the state equations";
  if (multistep_since)
    return {Method::bdf,
            loops + ", by BDF from t = " + number_text(*multistep_since) + " on: Radau IIA did not get on"};
  if (inputs.max_order > 0) return {Method::bdf, loops + "; an order can be limited in BDF"};
  // A multistep method begins again at order 1 after each event that sets something, which is what it is wrong by: a
  // sampled controller of nine states by BDF was off by 2.6e-6 at 1e-9, and took twice as long as by Radau.
  const std::size_t most = program.events.empty() ? kSmall : kDenseStates;
  if (program.state_names.size() > most) return {Method::bdf, loops};
  if (!std::all_of(program.blocks.begin(), program.blocks.end(), [](const auto& block) { return block.linear; }))
    return {Method::bdf, loops + ", which are nonlinear"};
  return {Method::radau, loops + (program.state_names.size() <= kSmall ? "; few states" : "; events that set stores")};
}

}  // namespace bgsim
