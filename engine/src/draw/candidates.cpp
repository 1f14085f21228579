// The places that each text of a drawing may take, the best ones cheapest.
#include <algorithm>
#include <cmath>

#include "draw/scene.hpp"

namespace bgsim {

namespace {

constexpr double kPortSize = 9.5;

}  // namespace

std::vector<Candidate> name_places(const Element& element, Point at, Point towards) {
  const Capsule shape = capsule(element, at);
  const double reach = shape.reach;
  const std::string name = local_name(element.name);
  const bool junction = is_junction(element.kind), one_port = !junction && port_count(element) == 1;
  std::vector<Candidate> candidates;
  const auto add = [&](Point offset, Anchor anchor, const std::string& text, double cost) {
    // Away from the bond, as far as there is one direction to speak of.
    const double against = unit(offset).x * unit(towards).x + unit(offset).y * unit(towards).y;
    candidates.push_back(
        {text_at(at + offset, anchor, kNameSize, text), cost + (one_port ? 60.0 * (1.0 + against) : 0.0)});
  };
  const double side = reach + shape.radius - 2.0, high = 18.0, sides = one_port ? 0.0 : 30.0;
  add({side, 0.0}, Anchor::start, one_port ? ": " + name : name, sides);
  add({-side, 0.0}, Anchor::end, one_port ? name + " :" : name, sides);
  add({0.0, high}, Anchor::middle, name, junction ? 22.0 : 0.0);
  add({0.0, -high}, Anchor::middle, name, junction ? 20.0 : 2.0);
  for (const double further : {0.0, 6.0, 12.0, 18.0, 26.0}) {
    const double x = reach + 7.0, y = 14.0 + further, cost = (junction ? 0.0 : 16.0) + 2.0 * further;
    add({x, -y}, Anchor::start, name, cost);
    add({-x, -y}, Anchor::end, name, cost + 1.0);
    add({x, y}, Anchor::start, name, cost + 2.0);
    add({-x, y}, Anchor::end, name, cost + 3.0);
  }
  // Where signals come and go, a little to the side is enough.
  for (const double aside : {0.25, -0.25, 0.5, -0.5}) {
    const double x = aside * text_width(name, kNameSize), cost = (junction ? 24.0 : 10.0) + 8.0 * std::abs(aside);
    add({x, high}, Anchor::middle, name, cost);
    add({x, -high}, Anchor::middle, name, cost);
  }
  return candidates;
}

std::vector<Candidate> port_places(const Curve& line, bool head, const std::string& name) {
  const double whole = std::max(1.0, length(line.end - line.begin));
  const Point side = flow_side(line.tangent(head ? 1.0 : 0.0));
  std::vector<Candidate> candidates;
  for (const double away : {0.5 * text_width(name, kPortSize) + 6.0, 22.0, 30.0}) {
    const double s = std::min(0.5, away / whole);
    for (const double sign : {1.0, -1.0})
      candidates.push_back(
          {text_beside(line, head ? 1.0 - s : s, sign * side, kPortSize, name), away + (sign < 0 ? 1.0 : 0.0)});
  }
  return candidates;
}

std::vector<Candidate> beside_line(const Curve& line, double preferred, bool either_side, const std::string& text,
                                   const std::string& subscript) {
  std::vector<Candidate> candidates;
  for (const double s : {0.5, 0.44, 0.56, 0.38, 0.62, 0.31, 0.69, 0.24, 0.76}) {
    const Point side = flow_side(line.tangent(s));
    const double cost = 40.0 * std::abs(s - 0.5);
    candidates.push_back({text_beside(line, s, preferred * side, kBondNameSize, text, subscript), cost});
    if (either_side)
      candidates.push_back({text_beside(line, s, -preferred * side, kBondNameSize, text, subscript), cost + 3.0});
  }
  return candidates;
}

}  // namespace bgsim
