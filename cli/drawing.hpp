/// Drawings of models, laid out by Graphviz.
#pragma once

#include <string>

#include "bgsim/drawing.hpp"

namespace bgsim::cli {

/// The bond graph as SVG: bgsim::drawing_svg with a layout by `dot` (by `sfdp` where `dot` would take minutes).
/// Causality is shown as far as it goes, so that faulty models are drawn as well.
/// @throws UsageError if Graphviz is not installed or fails.
/// @note About 0.1 s for 100 elements, most of it Graphviz.
std::string drawn_svg(const Model& model, const DrawingOptions& options = {});
std::string drawn_svg(const Model& model, const DrawnCausality& causality, const DrawingOptions& options);

/// An SVG as PNG, @p zoom pixels for each px, on white.
/// @throws UsageError if rsvg-convert is not installed or fails.
std::string png_from_svg(const std::string& svg, double zoom);

}  // namespace bgsim::cli
