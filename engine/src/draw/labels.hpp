/// The texts of a drawing, each with the places it may take; which of them it takes is decided among all.
#pragma once

#include <string>
#include <vector>

#include "draw/shapes.hpp"

namespace bgsim {

enum class Anchor : std::uint8_t { start, middle, end };

struct PlacedText {
  Point at;  ///< on the base line, at the anchor
  Anchor anchor = Anchor::middle;
  double size = kNameSize, width = 0.0;
  std::string text, subscript;
  Box box;
};

/// A text whose anchor is at @p at, half way up.
PlacedText text_at(Point at, Anchor anchor, double size, std::string text, std::string subscript = {},
                   Face face = Face::sans);

/// A text beside the line at @p s, on the side @p n of it, just clear of it.
PlacedText text_beside(const Curve& line, double s, Point n, double size, std::string text, std::string subscript = {});

/// A place that a text may take, and how far it is from the best one if nothing else is there.
struct Candidate {
  PlacedText text;
  double cost = 0.0;
};

// How bad it is to cover something; what counts more than kSolid is gone round by bonds, what counts more than kLight
// by signals.
inline constexpr double kLetterWeight = 10.0, kSolid = 9.0, kTextWeight = 6.0, kLineWeight = 4.0, kLight = 5.0,
                        kSignalWeight = 1.5;

class Labels {
 public:
  explicit Labels(Taken& taken) : taken_(taken) {}

  /// Adds a text, at the place where it covers least of what is there. @return its number. There is one candidate at
  /// least.
  std::size_t add(std::vector<Candidate> candidates);
  /// Takes a text out; its number means nothing any more.
  void drop(std::size_t label);
  [[nodiscard]] const PlacedText& operator[](std::size_t label) const;
  /// Takes up those that cover something and puts them where they cover less, as long as that helps.
  void improve();
  /// What texts cover, in px^2 by weight.
  [[nodiscard]] double covered() const;

 private:
  struct Label {
    std::vector<Candidate> candidates;
    std::size_t chosen = 0;
    double cost = 0.0;  ///< of the chosen place, preference included
    Taken::Range taken;
  };
  void choose(Label& label);
  Taken& taken_;
  std::vector<Label> labels_;
};

}  // namespace bgsim
