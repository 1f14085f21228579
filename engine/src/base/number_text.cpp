#include "base/number_text.hpp"

#include <array>
#include <cstdio>

namespace bgsim {

std::string text_of_number(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

}  // namespace bgsim
