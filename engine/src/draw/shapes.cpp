#include "draw/shapes.hpp"

#include <algorithm>
#include <cmath>

#include "bgsim/modes.hpp"

namespace bgsim {

double length(Point a) { return std::hypot(a.x, a.y); }
Point unit(Point a) {
  const double size = length(a);
  return size > 0.0 ? (1.0 / size) * a : Point{1.0, 0.0};
}

Box around(Point centre, double width, double height) {
  return {{centre.x - width / 2, centre.y - height / 2}, {centre.x + width / 2, centre.y + height / 2}};
}
Box grown(const Box& box, double by) { return {box.low - Point{by, by}, box.high + Point{by, by}}; }
Box united(const Box& a, const Box& b) {
  return {{std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y)},
          {std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y)}};
}
double shared_area(const Box& a, const Box& b) {
  const double width = std::min(a.high.x, b.high.x) - std::max(a.low.x, b.low.x);
  const double height = std::min(a.high.y, b.high.y) - std::max(a.low.y, b.low.y);
  return width > 0.0 && height > 0.0 ? width * height : 0.0;
}

Point Curve::at(double s) const { return (1 - s) * (1 - s) * begin + 2 * s * (1 - s) * control + s * s * end; }
Point Curve::tangent(double s) const { return unit((1 - s) * (control - begin) + s * (end - control)); }
bool Curve::straight() const { return length(control - 0.5 * (begin + end)) < 0.05; }

Letters letters(const Element& element) {
  const std::string text = kind_text(element.kind, element.modulated);
  if (element.diode && !element.contact) {
    const std::string way = element.diode->out ? "out" : "in";
    return {text, element.diode->fire.valid() ? way + ", fire" : way};
  }
  if (is_switch(element.kind)) return {text, side_text(element, is_closed(element))};
  if (!imposed_variable(element.kind)) return {text, {}};
  return {text.substr(0, text.size() - 1), text.substr(text.size() - 1)};
}
double letters_width(const Letters& letters) {
  return text_width(letters.base, kLetterSize, Face::serif) +
         text_width(letters.subscript, 0.7 * kLetterSize, Face::serif);
}

Point Capsule::edge(Point towards) const {
  const Point d = unit(towards);
  // Along the straight sides, else on the circle at the side that d points to.
  if (std::abs(d.y) > 0.0 && std::abs(d.x / d.y) * radius <= reach) return centre + (radius / std::abs(d.y)) * d;
  const double c = d.x > 0.0 ? reach : -reach;
  const double along = d.x * c;
  return centre + (along + std::sqrt(std::max(0.0, along * along - c * c + radius * radius))) * d;
}

Capsule capsule(const Element& element, Point at) {
  Capsule shape;
  shape.centre = at;
  if (letters(element).subscript.size() > 1) shape.radius = 19.0;  // words stand below the middle, where bonds end
  shape.reach = std::max(0.0, letters_width(letters(element)) / 2 + 6.0 - shape.radius);
  return shape;
}

Point turned(Point a) { return {-a.y, a.x}; }

Point flow_side(Point tangent) {
  const Point n = turned(tangent);
  const double low = n.x + n.y;
  return low > 1e-9 || (std::abs(low) <= 1e-9 && n.y > 0.0) ? n : -1.0 * n;
}

std::array<Point, 2> signal_barbs(const Curve& line) {
  const Point along = line.tangent(1.0), across = turned(along);
  return {line.end - 7.0 * along + 3.2 * across, line.end - 7.0 * along - 3.2 * across};
}

Curve between(const Capsule& a, const Capsule& b, double bulge, double shift) {
  const Point middle = 0.5 * (a.centre + b.centre) + shift * (b.centre - a.centre);
  if (bulge == 0.0) {
    const Point begin = a.edge(b.centre - a.centre), end = b.edge(a.centre - b.centre);
    return {begin, 0.5 * (begin + end), end};
  }
  const Point control = middle + bulge * turned(b.centre - a.centre);
  return {a.edge(control - a.centre), control, b.edge(control - b.centre)};
}

std::string scope_of(const std::string& full_name) {
  const std::size_t dot = full_name.rfind('.');
  return dot == std::string::npos ? std::string() : full_name.substr(0, dot + 1);
}
std::string local_name(const std::string& full_name) {
  const std::size_t dot = full_name.rfind('.');
  return dot == std::string::npos ? full_name : full_name.substr(dot + 1);
}

Taken::Range Taken::add(const Box& box, double weight) {
  const auto index = static_cast<std::uint32_t>(items_.size());
  items_.push_back({box, weight});
  for (auto x = static_cast<std::int32_t>(std::floor(box.low.x / kCell)); x * kCell <= box.high.x; ++x)
    for (auto y = static_cast<std::int32_t>(std::floor(box.low.y / kCell)); y * kCell <= box.high.y; ++y)
      cells_[(std::uint64_t{static_cast<std::uint32_t>(x)} << 32U) | static_cast<std::uint32_t>(y)].push_back(index);
  return {index, index + 1};
}

Taken::Range Taken::add(const Curve& curve, double weight) {
  const auto first = static_cast<std::uint32_t>(items_.size());
  const int pieces = std::max(1, static_cast<int>(length(curve.end - curve.begin) / 5.0));
  for (int i = 0; i < pieces; ++i) {
    const Point a = curve.at(double(i) / pieces), b = curve.at(double(i + 1) / pieces);
    add(grown({{std::min(a.x, b.x), std::min(a.y, b.y)}, {std::max(a.x, b.x), std::max(a.y, b.y)}}, 1.5), weight);
  }
  return {first, static_cast<std::uint32_t>(items_.size())};
}

void Taken::remove(Range range) {
  for (std::uint32_t i = range.first; i < range.last; ++i) items_[i].weight = 0.0;
}

template <class Visit>
void Taken::near(const Box& box, const Visit& visit) const {
  std::vector<std::uint32_t> seen;
  for (auto x = static_cast<std::int32_t>(std::floor(box.low.x / kCell)); x * kCell <= box.high.x; ++x)
    for (auto y = static_cast<std::int32_t>(std::floor(box.low.y / kCell)); y * kCell <= box.high.y; ++y) {
      const auto cell =
          cells_.find((std::uint64_t{static_cast<std::uint32_t>(x)} << 32U) | static_cast<std::uint32_t>(y));
      if (cell != cells_.end()) seen.insert(seen.end(), cell->second.begin(), cell->second.end());
    }
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  for (const std::uint32_t index : seen) visit(items_[index]);
}

double Taken::overlap(const Box& box) const {
  double area = 0.0;
  near(box, [&](const Item& item) { area += item.weight * shared_area(box, item.box); });
  return area;
}

double Taken::crossed(const Curve& curve, double above) const {
  const int pieces = std::max(8, static_cast<int>(length(curve.end - curve.begin) / 4.0));
  const double step = length(curve.end - curve.begin) / pieces;
  double sum = 0.0;
  for (int i = 1; i < pieces; ++i) {
    const Point p = curve.at(double(i) / pieces);
    near({p, p}, [&](const Item& item) {
      if (item.weight > above && p.x >= item.box.low.x && p.x <= item.box.high.x && p.y >= item.box.low.y &&
          p.y <= item.box.high.y)
        sum += item.weight * step;
    });
  }
  return sum;
}

}  // namespace bgsim
