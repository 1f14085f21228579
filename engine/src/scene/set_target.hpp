/// --set of a name that is no parameter and no state: what it may be instead.
#pragma once

#include <string>

#include "bgsim/model.hpp"

namespace bgsim {

struct UnknownTarget {
  std::string situation, help;
};
/// Says what has the name, if anything has (a signal, an output, an element), and which names are near.
UnknownTarget unknown_target_words(const Model& model, const std::string& name);

}  // namespace bgsim
