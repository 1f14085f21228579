/// Text in a shell's command line.
#pragma once

#include <string>
#include <string_view>

namespace bgsim::cli {

/// A word of a command line, quoted where a shell would not take it as it is; what has no shape is written out inside
/// $'...', which bash, zsh and ksh read. For commands that are shown, to be copied.
std::string shell_word(std::string_view word);

}  // namespace bgsim::cli
