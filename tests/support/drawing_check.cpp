#include "support/drawing_check.hpp"

#include <algorithm>
#include <cmath>
#include <regex>
#include <sstream>
#include <stdexcept>

#include "bgsim/drawing.hpp"
#include "support/files.hpp"
#include "support/font.hpp"

namespace bgsim::test {

namespace {

struct P {
  double x = 0.0, y = 0.0;
};
double distance(P a, P b) { return std::hypot(a.x - b.x, a.y - b.y); }

struct TextBox {
  std::string group, text;
  P low, high;
};

enum class LineKind { bond, stroke, barb, signal, border };

struct Line {
  LineKind kind = LineKind::bond;
  std::string group;
  std::vector<P> points;  ///< a pixel apart
};

std::string attribute(const std::string& tag, const std::string& name) {
  const std::size_t found = tag.find(" " + name + "=\"");
  if (found == std::string::npos) return {};
  const std::size_t begin = found + name.size() + 3;
  return tag.substr(begin, tag.find('"', begin) - begin);
}
double number(const std::string& tag, const std::string& name) {
  const std::string text = attribute(tag, name);
  return text.empty() ? 0.0 : std::stod(text);
}

std::string plain(std::string text) {
  for (const auto& [from, to] :
       {std::pair("&lt;", "<"), std::pair("&gt;", ">"), std::pair("&quot;", "\""), std::pair("&amp;", "&")})
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos;)
      text.replace(at, std::string(from).size(), to);
  return text;
}

/// M x y L x y L x y, or M x y Q cx cy x y.
std::vector<P> points_of(std::string path) {
  const bool curve = path.find('Q') != std::string::npos;
  for (char& c : path)
    if (c == 'M' || c == 'L' || c == 'Q') c = ' ';
  std::istringstream numbers(path);
  std::vector<P> corners, points;
  for (P p; numbers >> p.x >> p.y;) corners.push_back(p);
  const auto dense = [&](auto at, double size) {
    const int pieces = std::max(2, static_cast<int>(size));
    for (int i = 0; i <= pieces; ++i) points.push_back(at(double(i) / pieces));
  };
  if (curve) {
    const P a = corners[0], b = corners[1], c = corners[2];
    dense(
        [&](double s) {
          return P{(1 - s) * (1 - s) * a.x + 2 * s * (1 - s) * b.x + s * s * c.x,
                   (1 - s) * (1 - s) * a.y + 2 * s * (1 - s) * b.y + s * s * c.y};
        },
        distance(a, b) + distance(b, c));
    return points;
  }
  for (std::size_t k = 0; k + 1 < corners.size(); ++k) {
    const P a = corners[k], b = corners[k + 1];
    dense([&](double s) { return P{a.x + s * (b.x - a.x), a.y + s * (b.y - a.y)}; }, distance(a, b));
  }
  return points;
}

class Picture {
 public:
  explicit Picture(const std::string& svg) {
    std::istringstream box(attribute(svg.substr(svg.find("<svg"), 1000), "viewBox"));
    double width = 0.0, height = 0.0;
    box >> low_.x >> low_.y >> width >> height;
    high_ = {low_.x + width, low_.y + height};
    static const std::regex kPiece(
        R"(<g[^>]*>|<rect[^>]*>|<path[^>]*>|<text[^>]*>(?:[^<]|<tspan[^>]*>|</tspan>)*</text>)");
    for (auto it = std::sregex_iterator(svg.begin(), svg.end(), kPiece); it != std::sregex_iterator(); ++it)
      take(it->str());
  }

  std::vector<std::string> collisions() {
    texts_apart();
    lines_off_texts();
    strokes_apart();
    bonds_apart();
    return std::move(found_);
  }

 private:
  void take(const std::string& piece) {
    if (piece.starts_with("<g")) {
      const std::string kind = attribute(piece, "class");
      group_ = kind + " " + attribute(piece, "data-bond") + attribute(piece, "data-element") +
               attribute(piece, "data-submodel");
      if (kind == "signal") group_ += "to " + attribute(piece, "data-to") + " #" + std::to_string(++signals_);
      in_legend_ = in_legend_ || kind == "legend";
      bond_ = kind.starts_with("bond");
      signal_ = kind == "signal";
      frame_ = kind == "frame";
    } else if (piece.starts_with("<rect")) {
      if (frame_) take_border(piece);
    } else if (piece.starts_with("<path")) {
      take_path(piece);
    } else {
      take_text(piece);
    }
  }

  void take_border(const std::string& tag) {
    const double x = number(tag, "x"), y = number(tag, "y"), w = number(tag, "width"), h = number(tag, "height");
    std::ostringstream path;
    path << "M" << x << " " << y << "L" << x + w << " " << y << "L" << x + w << " " << y + h << "L" << x << " " << y + h
         << "L" << x << " " << y;
    lines_.push_back({LineKind::border, group_, points_of(path.str())});
  }

  void take_path(const std::string& tag) {
    if (in_legend_) return;
    const std::string kind = attribute(tag, "class");
    const std::vector<P> points = points_of(attribute(tag, "d"));
    if (signal_) lines_.push_back({LineKind::signal, group_, points});
    if (!bond_ || kind == "hit") return;
    lines_.push_back({kind == "stroke"  ? LineKind::stroke
                      : kind == "arrow" ? LineKind::barb
                                        : LineKind::bond,
                      group_, points});
  }

  void take_text(const std::string& piece) {
    const std::string css = attribute(piece, "class"), anchor = attribute(piece, "text-anchor");
    const Font& font = css.find("letter") != std::string::npos       ? serif_
                       : css.find("frame-name") != std::string::npos ? bold_
                                                                     : sans_;
    const double x = number(piece, "x"), y = number(piece, "y"), size = number(piece, "font-size");
    const std::size_t begin = piece.find('>') + 1, tspan = piece.find("<tspan");
    const std::string text = plain(piece.substr(begin, std::min(piece.find("</text>"), tspan) - begin));
    double width = font.width(text, size), deep = 0.0;
    std::string whole = text;
    // Letters of these fonts are at most 0.73 em high and 0.21 em deep.
    if (text.find_first_of("_gjpqy,;()[]Q") != std::string::npos) deep = 0.21 * size;
    if (tspan != std::string::npos) {
      const std::string inner = piece.substr(tspan);
      const std::string low = plain(inner.substr(inner.find('>') + 1, inner.find("</tspan>") - inner.find('>') - 1));
      const double small = number(inner, "font-size");
      width += font.width(low, small);
      deep = std::max(deep, number(inner, "dy"));
      whole += low;
    }
    const double left = anchor == "middle" ? x - width / 2 : anchor == "end" ? x - width : x;
    const double high = css.find("letter") != std::string::npos ? 0.66 : 0.73;
    texts_.push_back({group_, whole, {left, y - high * size}, {left + width, y + deep}});
    // What a viewer with another font squeezes the text to is what the font has.
    const std::string fitted = attribute(piece, "textLength");
    if (!fitted.empty() && std::abs(std::stod(fitted) - width) > 0.02 + 1e-3 * width)
      found_.push_back("\"" + whole + "\" is " + std::to_string(width) + " px wide, its textLength " + fitted);
  }

  static std::string at(P p) {
    return " at (" + std::to_string(std::lround(p.x)) + ", " + std::to_string(std::lround(p.y)) + ")";
  }
  static std::string words(const TextBox& text) { return "\"" + text.text + "\" of " + text.group; }

  void texts_apart() {
    for (std::size_t i = 0; i < texts_.size(); ++i) {
      const TextBox& a = texts_[i];
      if (a.low.x < low_.x || a.low.y < low_.y || a.high.x > high_.x || a.high.y > high_.y)
        found_.push_back(words(a) + " is cut at the picture's edge");
      for (std::size_t k = i + 1; k < texts_.size(); ++k) {
        const TextBox& b = texts_[k];
        if (std::min(a.high.x, b.high.x) - std::max(a.low.x, b.low.x) > 1.0 &&
            std::min(a.high.y, b.high.y) - std::max(a.low.y, b.low.y) > 1.0)
          found_.push_back(words(a) + " covers " + words(b) + at(a.low));
      }
    }
  }

  void lines_off_texts() {
    for (const TextBox& text : texts_)
      for (const Line& line : lines_)
        for (const P& p : line.points)
          if (p.x > text.low.x + 1.0 && p.x < text.high.x - 1.0 && p.y > text.low.y + 1.0 && p.y < text.high.y - 1.0) {
            found_.push_back("a line of " + line.group + " goes through " + words(text) + at(p));
            break;
          }
  }

  void strokes_apart() {
    for (const Line& stroke : lines_) {
      if (stroke.kind != LineKind::stroke) continue;
      for (const Line& other : lines_) {
        const bool again = other.kind == LineKind::stroke && &other < &stroke;
        if ((other.kind != LineKind::stroke && other.kind != LineKind::bond) || other.group == stroke.group || again)
          continue;
        const bool near = std::any_of(stroke.points.begin(), stroke.points.end(), [&](P p) {
          return std::any_of(other.points.begin(), other.points.end(), [&](P q) { return distance(p, q) < 1.2; });
        });
        if (near) found_.push_back("the stroke of " + stroke.group + " touches " + other.group + at(stroke.points[0]));
      }
    }
  }

  void bonds_apart() {
    for (const Line& a : lines_)
      for (const Line& b : lines_) {
        if (a.kind != LineKind::bond || b.kind != LineKind::bond || &a >= &b) continue;
        const auto shared = std::count_if(a.points.begin(), a.points.end(), [&](P p) {
          return std::any_of(b.points.begin(), b.points.end(), [&](P q) { return distance(p, q) < 1.5; });
        });
        if (shared > 12) found_.push_back(a.group + " lies on " + b.group + at(a.points[0]));
      }
  }

  Font sans_{"Liberation Sans"}, bold_{"Liberation Sans:bold"}, serif_{"Liberation Serif"};
  P low_, high_;
  std::string group_;
  bool bond_ = false, signal_ = false, frame_ = false, in_legend_ = false;
  int signals_ = 0;
  std::vector<TextBox> texts_;
  std::vector<Line> lines_;
  std::vector<std::string> found_;
};

std::string laid_out(const std::string& request) {
  const TemporaryFolder folder;
  folder.write("request.dot", request);
  return output_of("dot -Tplain '" + (folder.path() / "request.dot").string() + "'");
}

std::string drawn(const Model& model) {
  return drawing_svg(model, drawn_causality(model), read_layout(model, laid_out(layout_request(model))));
}

}  // namespace

std::vector<std::string> collisions_in(const std::string& svg) { return Picture(svg).collisions(); }

std::string drawn_by_dot(const std::string& model_json, const std::string& file) {
  return drawn(read_model_text(file, model_json));
}

std::string drawn_by_dot_from(const std::string& path) { return drawn(read_model(path)); }

}  // namespace bgsim::test
