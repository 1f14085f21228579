/// Numbers as text for people.
#pragma once

#include <string>

namespace bgsim {

/// A number as it is read by people: six digits, no trailing zeros.
std::string text_of_number(double value);

}  // namespace bgsim
