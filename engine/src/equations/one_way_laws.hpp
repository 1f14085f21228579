/// Laws that keep a store from being independent.
#pragma once

#include <vector>

#include "bgsim/causality.hpp"

namespace bgsim {

/// @p problems, with notes to BG402 and BG403: which laws force stores into derivative causality because they cannot be
/// solved for the other variable, and with that are what the derivative is asked of. The first store names a law.
std::vector<Diagnostic> with_one_way_laws(const Model& model, const BondGraph& graph, const CausalGraph& causal,
                                          std::vector<Diagnostic> problems);

}  // namespace bgsim
