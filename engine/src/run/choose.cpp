#include "run/choose.hpp"

#include <algorithm>

#include "bgsim/text.hpp"
#include "run/integrate/integrator.hpp"

namespace bgsim {

MethodChoice choose_method(const Program& program, const RunInputs& inputs, std::optional<double> multistep_since) {
  if (inputs.method != Method::automatic) return {inputs.method, "asked for"};
  const std::string loops =
      program.blocks.empty() ? "state equations without loops" : "loops are solved inside the state equations";
  if (multistep_since)
    return {Method::bdf,
            loops + ", by BDF from t = " + number_text(*multistep_since) + " on: Radau IIA did not get on"};
  if (inputs.max_order > 0) return {Method::bdf, loops + "; an order can be limited in BDF"};
  // Up to here Radau is the cheapest at equal error, of stiff lines, oscillators and laws with events alike; above, the
  // matrices of BDF are sparse, and it takes a third to a half of the time on lines (bench methods --random).
  if (program.state_names.size() > kDenseStates) return {Method::bdf, loops + "; many states"};
  if (!std::all_of(program.blocks.begin(), program.blocks.end(), [](const auto& block) { return block.linear; }))
    return {Method::bdf, loops + ", which are nonlinear"};
  return {Method::radau, loops + "; few states"};
}

}  // namespace bgsim
