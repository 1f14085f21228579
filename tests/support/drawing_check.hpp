/// What touches what in a drawing, measured on the SVG itself with the metrics of the fonts that draw it.
#pragma once

#include <string>
#include <vector>

namespace bgsim::test {

/// Pairs that should keep apart and do not, in words with place:
/// * texts (letters of elements included) that share more than 1 px in both directions, or stand outside the picture;
/// * lines (bonds, half-arrows, strokes, signals, borders of frames) that enter a text, 1 px within its box;
/// * a stroke that touches the stroke or the line of another bond;
/// * two bonds that lie on each other for more than 12 px.
/// Lines may cross lines: not every graph is planar.
std::vector<std::string> collisions_in(const std::string& svg);

/// The drawing of a model as `bgsim draw` makes it, laid out by dot.
std::string drawn_by_dot(const std::string& model_json, const std::string& file = "test.json");
std::string drawn_by_dot_from(const std::string& path);

}  // namespace bgsim::test
