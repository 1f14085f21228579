/// Text in LaTeX.
#pragma once

#include <string>
#include <string_view>

namespace bgsim {

/// A name as upright text in a formula: \mathrm{...} for letters, digits, dots and underscores, else \text{...} with
/// all that LaTeX would read written so that it does not; no line break, so that no comment and no formula ends in it.
std::string latex_text(std::string_view name);

}  // namespace bgsim
