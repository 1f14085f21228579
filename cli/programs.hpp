/// Other programs that the command line calls: Graphviz, gnuplot, rsvg-convert.
#pragma once

#include <string>
#include <vector>

namespace bgsim::cli {

/// A program, what it is needed for, and the Debian package that has it.
struct ExternalProgram {
  const char* name;
  const char* package;
  const char* purpose;  ///< "makes the layout of drawings"
};

inline constexpr ExternalProgram kDot{"dot", "graphviz", "lays drawings out"};
inline constexpr ExternalProgram kSfdp{"sfdp", "graphviz", "lays large drawings out"};
inline constexpr ExternalProgram kGnuplot{"gnuplot", "gnuplot-nox", "draws the picture"};
inline constexpr ExternalProgram kFontMatch{"fc-match", "fontconfig", "says which font draws"};
inline constexpr ExternalProgram kRsvgConvert{"rsvg-convert", "librsvg2-bin", "turns SVG into PNG"};

/// Runs a program with @p input as its standard input, without a shell, in an empty folder, for a quarter of an hour at
/// most. It is looked for in the folders of PATH that are absolute. A signal that ends this process ends the program,
/// too. Arguments never come from a model.
/// @return what it wrote on standard output.
/// @throws UsageError if it is not installed (which package has it), or if it fails (with what it said).
std::string run_program(const ExternalProgram& program, const std::vector<std::string>& arguments,
                        const std::string& input);

/// @throws UsageError if the program is not there; @p advice, if any, is added.
void require_program(const ExternalProgram& program, const std::string& advice = {});

}  // namespace bgsim::cli
