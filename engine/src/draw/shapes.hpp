/// What drawings are made of: places on the plane, the words beside elements, and what is already taken.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "bgsim/drawing.hpp"

namespace bgsim {

using Point = Layout::Point;
inline Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y}; }
inline Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y}; }
inline Point operator*(double s, Point a) { return {s * a.x, s * a.y}; }
double length(Point a);
Point unit(Point a);  ///< (1, 0) for a point at the origin

/// Axis-parallel, low <= high.
struct Box {
  Point low, high;
  [[nodiscard]] double width() const { return high.x - low.x; }
  [[nodiscard]] double height() const { return high.y - low.y; }
};
Box around(Point centre, double width, double height);
Box grown(const Box& box, double by);
Box united(const Box& a, const Box& b);
double shared_area(const Box& a, const Box& b);

/// A quadratic Bezier curve; a straight line has its control point in the middle.
struct Curve {
  Point begin, control, end;
  [[nodiscard]] Point at(double s) const;       ///< 0 <= s <= 1
  [[nodiscard]] Point tangent(double s) const;  ///< of length 1, towards the end
  [[nodiscard]] bool straight() const;
};

Point turned(Point a);  ///< by a quarter, from x to y
/// The side of a line for its flow and its barb: below, or right of an upright one.
Point flow_side(Point tangent);

inline constexpr double kLetterSize = 20.0;  ///< of the elements' letters, in px
inline constexpr double kNameSize = 11.5;    ///< of their names
inline constexpr double kBondNameSize = 10.0;

/// Liberation Sans, the same in bold, Liberation Serif; each has the metrics of Arial or Times New Roman.
enum class Face : std::uint8_t { sans, bold, serif };
/// Width of a text in px, as the font has it. Beyond ASCII every character counts as wide.
double text_width(const std::string& text, double size, Face face = Face::sans);
/// Whether text_width() is exact and not an upper bound.
bool exact_width(const std::string& text);

/// The letters of an element as drawn: "MS" with subscript "e", "R", "0"; of a switch or contact with its side in the
/// model's mode, "Sw" with "open", of a diode with the way that it passes, "D" with "in"; of a
/// thyristor "in, fire".
struct Letters {
  std::string base, subscript;
};
Letters letters(const Element& element);
double letters_width(const Letters& letters);

/// The clear space around an element's letters at which bonds end: a line of half length `reach` swept by a circle.
struct Capsule {
  Point centre;
  double reach = 0.0, radius = 14.0;
  /// Where the straight line from the centre in direction @p towards leaves it.
  [[nodiscard]] Point edge(Point towards) const;
  [[nodiscard]] Box box() const { return around(centre, 2.0 * (reach + radius), 2.0 * radius); }
};
Capsule capsule(const Element& element, Point at);

/// The ends of the arrow at the end of a signal.
std::array<Point, 2> signal_barbs(const Curve& line);

/// The way from one to the other. @p bulge and @p shift: how far the control point is beside the middle and along the
/// way, in lengths of the way.
Curve between(const Capsule& a, const Capsule& b, double bulge, double shift = 0.0);

/// "left.pump" is "pump" inside the frame "left".
std::string scope_of(const std::string& full_name);    ///< "left." or ""
std::string local_name(const std::string& full_name);  ///< "pump"

/// What is drawn already, so that what comes next can keep clear of it. Costs what is near, not what there is.
class Taken {
 public:
  /// What was added by one call, to be removed again.
  struct Range {
    std::uint32_t first = 0, last = 0;
  };
  Range add(const Box& box, double weight);
  Range add(const Curve& curve, double weight);  ///< as a string of small boxes
  void remove(Range range);
  /// Area of @p box that is taken, in px^2, by weight.
  [[nodiscard]] double overlap(const Box& box) const;
  /// Length of the curve from 0 to 1 that lies in what is taken, by weight; what is heavier than @p above counts.
  [[nodiscard]] double crossed(const Curve& curve, double above = 0.0) const;

 private:
  static constexpr double kCell = 48.0;
  struct Item {
    Box box;
    double weight = 1.0;
  };
  template <class Visit>
  void near(const Box& box, const Visit& visit) const;
  std::vector<Item> items_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

}  // namespace bgsim
