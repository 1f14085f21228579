#include "draw/labels.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace bgsim {

namespace {

/// With what should be free around a text, so that two of them do not read as one.
Box with_room(const Box& box) { return {box.low - Point{4.0, 1.0}, box.high + Point{4.0, 1.0}}; }

/// Whether any letter goes below the base line.
bool descends(const std::string& text) { return text.find_first_of("_gjpqy,;()[]{}Q@|$") != std::string::npos; }

}  // namespace

PlacedText text_at(Point at, Anchor anchor, double size, std::string text, std::string subscript, Face face) {
  PlacedText placed;
  placed.width = text_width(text, size, face) + text_width(subscript, 0.75 * size, face);
  const double left = anchor == Anchor::middle  ? at.x - placed.width / 2
                      : anchor == Anchor::start ? at.x
                                                : at.x - placed.width;
  placed.at = {at.x, at.y + 0.35 * size};
  // Capitals and ascenders are 0.73 em high in these fonts, descenders 0.21 em deep.
  const bool deep = descends(text) || !subscript.empty();
  placed.box = {{left, placed.at.y - 0.74 * size}, {left + placed.width, placed.at.y + (deep ? 0.22 : 0.02) * size}};
  if (!subscript.empty()) placed.box.high.y += descends(subscript) ? 0.17 * size : 0.0;
  placed.anchor = anchor;
  placed.size = size;
  placed.text = std::move(text);
  placed.subscript = std::move(subscript);
  return placed;
}

PlacedText text_beside(const Curve& line, double s, Point n, double size, std::string text, std::string subscript) {
  PlacedText placed = text_at(line.at(s), Anchor::middle, size, std::move(text), std::move(subscript));
  const double clear = 3.5 + std::abs(n.x) * placed.box.width() / 2 + std::abs(n.y) * placed.box.height() / 2;
  return text_at(line.at(s) + clear * n, Anchor::middle, size, placed.text, placed.subscript);
}

std::size_t Labels::add(std::vector<Candidate> candidates) {
  labels_.push_back({std::move(candidates), 0, 0.0, {}});
  choose(labels_.back());
  return labels_.size() - 1;
}

void Labels::drop(std::size_t label) {
  taken_.remove(labels_[label].taken);
  labels_[label].candidates.clear();
}

const PlacedText& Labels::operator[](std::size_t label) const {
  return labels_[label].candidates[labels_[label].chosen].text;
}

void Labels::choose(Label& label) {
  taken_.remove(label.taken);
  label.cost = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < label.candidates.size(); ++i) {
    const Candidate& candidate = label.candidates[i];
    if (candidate.cost >= label.cost) continue;
    const double cost = taken_.overlap(with_room(candidate.text.box)) + candidate.cost;
    if (cost >= label.cost) continue;
    label.cost = cost;
    label.chosen = i;
  }
  label.taken = taken_.add(label.candidates[label.chosen].text.box, kTextWeight);
}

void Labels::improve() {
  constexpr int kRounds = 4;
  bool changed = true;
  for (int round = 0; round < kRounds && changed; ++round) {
    changed = false;
    for (Label& label : labels_) {
      if (label.candidates.empty()) continue;
      const std::size_t before = label.chosen;
      choose(label);
      changed = changed || label.chosen != before;
    }
  }
}

double Labels::covered() const {
  double sum = 0.0;
  for (const Label& label : labels_) {
    if (label.candidates.empty()) continue;
    const Box& box = label.candidates[label.chosen].text.box;
    sum += taken_.overlap(box) - kTextWeight * box.width() * box.height();  // it covers itself
  }
  return sum;
}

}  // namespace bgsim
