#include "drawing.hpp"

#include "programs.hpp"

namespace bgsim::cli {

namespace {

// A ladder of 10,000 elements takes dot three seconds, a square mesh of 4,000 as many; beyond, sfdp is quicker.
constexpr std::size_t kMostForDot = 10000;

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
  return run_program(kRsvgConvert, {"--format=png", "--zoom=" + std::to_string(zoom), "--unlimited"}, svg);
}

}  // namespace bgsim::cli
