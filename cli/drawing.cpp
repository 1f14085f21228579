#include "drawing.hpp"

#include <array>
#include <iostream>

#include "command.hpp"
#include "programs.hpp"

namespace bgsim::cli {

namespace {

// A ladder of 10,000 elements takes dot three seconds, a square mesh of 4,000 as many; beyond, sfdp is quicker.
constexpr std::size_t kMostForDot = 10000;

/// Texts are laid out by the widths of Liberation Sans. A browser keeps them so wide in any font (textLength); what
/// makes the PNG does not.
void note_other_font() {
  constexpr std::array<const char*, 5> kSameWidths{"Liberation Sans", "Arial", "Arimo", "Helvetica", "Nimbus Sans"};
  std::string font;
  try {
    font = run_program(kFontMatch, {"-f", "%{family[0]}", "Liberation Sans"}, "");
  } catch (const UsageError&) {
    return;  // without fontconfig's program nothing is known
  }
  for (const char* same : kSameWidths)
    if (font == same) return;
  std::cerr
      << "note: the PNG is drawn with the font \"" << font
      << "\", for which it is not laid out: texts may touch; Liberation Sans is laid out for (Debian: apt-get install "
         "fonts-liberation)\n";
}

}  // namespace

std::string drawn_svg(const Model& model, const DrawnCausality& causality, const DrawingOptions& options) {
  const bool large = model.elements.size() > kMostForDot;
  const std::string plain = run_program(large ? kSfdp : kDot, {"-Tplain"}, layout_request(model));
  return drawing_svg(model, causality, read_layout(model, plain), options);
}

std::string drawn_svg(const Model& model, const DrawingOptions& options) {
  return drawn_svg(model, drawn_causality(model), options);
}

std::string png_from_svg(const std::string& svg, double zoom) {
  note_other_font();
  return run_program(kRsvgConvert, {"--format=png", "--zoom=" + std::to_string(zoom), "--unlimited"}, svg);
}

}  // namespace bgsim::cli
