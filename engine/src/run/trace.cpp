#include <algorithm>
#include <stdexcept>

#include "bgsim/simulate.hpp"

namespace bgsim {

std::span<const double> Trace::operator[](std::string_view name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return columns[static_cast<std::size_t>(found - names.begin())];
  const std::string near = nearest_name(std::string(name), names);
  throw std::out_of_range("the trace has no column \"" + std::string(name) + '"' +
                          (near.empty() ? "" : "; did you mean \"" + near + "\"?"));
}

}  // namespace bgsim
