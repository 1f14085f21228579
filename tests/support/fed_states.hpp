/// Any system x' = f(t, x) as a model.
#pragma once

#include <string>
#include <vector>

namespace bgsim::test {

struct FedState {
  std::string name, start, rate;  ///< the rate in terms of "NAME.q" and t
};

/// Capacitors of 1, each fed by its rate; output "oNAME" is the state NAME.
/// @param scene  the scene's members: "\"stop\": 1, \"samples\": 2".
std::string fed_states(const std::vector<FedState>& states, const std::string& scene);

}  // namespace bgsim::test
