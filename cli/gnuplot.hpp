/// Pictures drawn by gnuplot. Its scripts can run shell commands, so a text enters them through gnuplot_string alone.
#pragma once

#include <string>
#include <string_view>

namespace bgsim::cli {

/// A text that gnuplot takes as it is: in double quotes, in which all but letters and blanks is an octal code, so that
/// nothing is left to be read as a quote, a command in backquotes or the end of a statement. (Digits too, since gnuplot
/// reads more than three into a code.) No longer than short_name leaves it. The terminal is to be set to noenhanced.
std::string gnuplot_string(std::string_view text);

/// The SVG that a script draws. Nobody's settings are read.
/// @throws UsageError if gnuplot is missing or fails.
std::string svg_from_gnuplot(const std::string& script);

}  // namespace bgsim::cli
