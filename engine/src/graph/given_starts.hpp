/// Which stores have an initial value: these are independent rather than others, so that what is given holds.
#pragma once

#include <unordered_set>

#include "bgsim/model.hpp"

namespace bgsim {

/// The ports of stores to which the model or one of its scenes gives an initial value, of either variable.
/// @note Time linear in the model.
class GivenStarts {
 public:
  explicit GivenStarts(const Model& model);
  [[nodiscard]] bool operator()(ElementId element, std::uint32_t port) const {
    return given_.contains(key(element, port));
  }

 private:
  [[nodiscard]] static std::uint64_t key(ElementId element, std::uint32_t port) {
    return (std::uint64_t{element.value} << 32U) | port;
  }
  std::unordered_set<std::uint64_t> given_;
};

}  // namespace bgsim
