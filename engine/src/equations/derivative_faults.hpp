/// What is said of derivatives that do not exist.
#pragma once

#include <cstdint>
#include <string>

#include "bgsim/diagnostic.hpp"

namespace bgsim {

/// What asks for a derivative: der(...) in a line of the model, or a store in derivative causality.
struct Wish {
  Place place;
  std::string store;  ///< its q or p by name; empty for der(...)
};

/// BG402: what the line at @p place gives jumps.
Diagnostic jump_fault(const std::string& expression, const Place& place, const Wish& wish);

/// BG403: a quantity would have to be differentiated more than @p most times.
Diagnostic index_fault(const std::string& quantity, std::uint32_t most, const Place& place);

/// BG404: @p event sets @p store, a dependent one. @p when: " at t = 3 in this mode", or nothing.
Diagnostic dependent_target(const std::string& event, const std::string& store, const Place& place,
                            const std::string& when = {});

}  // namespace bgsim
