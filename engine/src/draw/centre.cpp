// Symmetry: Graphviz makes bonds short, and places a node arbitrarily that may be anywhere between two
// others.
#include <algorithm>
#include <cmath>
#include <map>

#include "draw/plan.hpp"

namespace bgsim {

namespace {

Box box_of(Point at, const Extent& extent) {
  return {{at.x - extent.left, at.y - extent.top}, {at.x + extent.right, at.y + extent.bottom}};
}

class Centring {
 public:
  Centring(const Model& model, const std::vector<Standing>& standings, const std::vector<Extent>& extents,
           std::vector<Point>& at)
      : model_(model), standings_(standings), extents_(extents), at_(at), next_to_(model.elements.size()) {
    for (std::size_t i = 0; i < at.size(); ++i)
      if (standings[i].side == Side::none) hosts_.push_back(i);
    for (const ModelBond& bond : model.bonds) {
      const std::size_t a = standings[bond.from.element.index()].host.index();
      const std::size_t b = standings[bond.to.element.index()].host.index();
      if (a == b) continue;
      next_to_[a].push_back(b);
      next_to_[b].push_back(a);
    }
    hung_.resize(at.size());
    for (std::size_t i = 0; i < at.size(); ++i)
      if (standings[i].side != Side::none) hung_[standings[i].host.index()].push_back(i);
  }

  void run() {
    widen();
    turn_over();
    centre_all();
  }

 private:
  void move(std::size_t host, double by) {
    at_[host].y += by;
    for (const std::size_t i : hung_[host]) at_[i].y += by;
  }

  /// Moves what can be moved to the middle. @return how many found no room there.
  std::size_t centre_all() {
    find_frames();
    constexpr int kRounds = 3;
    std::size_t blocked = 0;
    for (int round = 0; round < kRounds; ++round) {
      blocked = 0;
      for (const std::size_t host : hosts_) blocked += centre(host) ? 0U : 1U;
    }
    return blocked;
  }

  /// Makes the drawing higher if more finds its middle then.
  void widen() {
    const std::vector<Point> before = at_;
    std::size_t least = centre_all();
    std::vector<Point> best = at_;
    for (const double stretch : {1.1, 1.2, 1.3, 1.4}) {
      if (least == 0) break;
      at_ = before;
      for (const std::size_t host : hosts_) move(host, (stretch - 1.0) * at_[host].y);
      const std::size_t blocked = centre_all();
      if (blocked >= least) continue;
      least = blocked;
      best = at_;
    }
    at_ = best;
  }

  /// Whether later declarations are mostly above earlier ones.
  bool upside_down() const {
    double order = 0.0, height = 0.0, same = 0.0, size = 0.0;
    for (const std::size_t host : hosts_) {
      order += static_cast<double>(host);
      height += at_[host].y;
    }
    const auto count = static_cast<double>(hosts_.size());
    for (const std::size_t host : hosts_) {
      const double down = (static_cast<double>(host) - order / count) * (at_[host].y - height / count);
      same += down;
      size += std::abs(down);
    }
    constexpr double kClearly = 0.2;  // of an order from top to bottom
    return same < -kClearly * size;
  }

  /// Straight bonds stay straight; where something that hangs would then cover something else, nothing is turned.
  void turn_over() {
    if (!upside_down()) return;
    const std::vector<Point> before = at_;
    double low = 0.0;
    for (const std::size_t host : hosts_) low = std::min(low, -at_[host].y - extents_[host].top);
    for (const std::size_t host : hosts_) move(host, -low - 2.0 * at_[host].y);
    find_frames();
    for (const std::size_t host : hosts_)
      if (!free(host, box_of(at_[host], extents_[host]), 6.0)) {
        at_ = before;
        return;
      }
  }

  void find_frames() {
    frames_.clear();
    for (const std::size_t host : hosts_) {
      const std::string& name = model_.elements[host].name;
      for (std::string scope = scope_of(name); !scope.empty(); scope = scope_of(scope.substr(0, scope.size() - 1))) {
        const Box box = grown(box_of(at_[host], extents_[host]), kFrame);
        const auto [frame, fresh] = frames_.emplace(scope, box);
        if (!fresh) frame->second = united(frame->second, box);
      }
    }
  }

  /// Where half of the neighbours are above and half below, and those on the same side straight beside it are none. ///
  /// To the middle of the stretch in which the bonds' heights add up to the same. @return false if something is there.
  bool centre(std::size_t host) {
    std::vector<double> heights;
    for (const std::size_t other : next_to_[host]) heights.push_back(at_[other].y);
    if (heights.size() < 2 || heights.size() % 2 != 0) return true;
    std::sort(heights.begin(), heights.end());
    const double low = heights[heights.size() / 2 - 1], high = heights[heights.size() / 2];
    const double wanted = (low + high) / 2;
    // Graphviz leaves what goes straight through a little beside the line where names below make a node uneven.
    constexpr double kBeside = 0.5 * kDrop;
    const bool straight = high - low < 1.0 && std::abs(at_[host].y - wanted) < kBeside;
    if (!straight && (at_[host].y <= low + 1.0 || at_[host].y >= high - 1.0))
      return true;  // straight beside one of them
    const Point there{at_[host].x, wanted};
    if (!free(host, box_of(there, extents_[host]), 12.0)) return false;
    move(host, wanted - at_[host].y);
    return true;
  }

  /// Whether nothing else is there or @p apart px beside, and no frame's border between.
  bool free(std::size_t host, const Box& box, double apart) const {
    const Box wide = grown(box, apart);
    for (const std::size_t other : hosts_)
      if (other != host && shared_area(wide, box_of(at_[other], extents_[other])) > 0.0) return false;
    const std::string& name = model_.elements[host].name;
    return std::all_of(frames_.begin(), frames_.end(), [&](const auto& frame) {
      const bool inside = shared_area(box, frame.second) > 0.99 * box.width() * box.height();
      return name.starts_with(frame.first) ? inside : shared_area(wide, frame.second) == 0.0;
    });
  }

  static constexpr double kFrame = 22.0;  // around what is in a frame
  const Model& model_;
  const std::vector<Standing>& standings_;
  const std::vector<Extent>& extents_;
  std::vector<Point>& at_;
  std::vector<std::size_t> hosts_;
  std::vector<std::vector<std::size_t>> next_to_, hung_;
  std::map<std::string, Box> frames_;
};

}  // namespace

void centre(const Model& model, const std::vector<Standing>& standings, const std::vector<Extent>& extents,
            std::vector<Layout::Point>& at) {
  constexpr std::size_t kMost = 1500;  // each may be held against each
  if (model.elements.size() <= kMost) Centring(model, standings, extents, at).run();
}

}  // namespace bgsim
