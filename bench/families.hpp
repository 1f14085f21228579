/// Random models of a given size, of which no two are alike: what `scripts/bench methods --random` runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace bgsim::bench {

/// The families: stiff lines and nets, lines that ring, contacts written as conditions, samples, ideal switches, ...
const std::vector<std::string>& family_names();

/// A model of one of them as text, with one scene.
/// @param states  how many it should have at least; some families round to what they are made of.
/// @param seed    equal seeds give equal models.
std::string family_model(const std::string& family, std::size_t states, std::uint32_t seed);

}  // namespace bgsim::bench
