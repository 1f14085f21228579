// Between a model and Graphviz: what it is asked, what it answers.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numeric>
#include <sstream>
#include <stdexcept>

#include "draw/plan.hpp"

namespace bgsim {

namespace {

/// A number without trailing zeros, to a hundredth.
std::string number(double value) {
  std::ostringstream text;
  text << std::round(100.0 * value) / 100.0;
  return text.str();
}

/// A node as large as its drawing, with a port `c` at the host's centre, at which Graphviz lets bonds end.
std::string node_text(ElementId id, const Extent& extent) {
  const auto cell = [](double width, double height, const char* port = "") {
    return "<TD FIXEDSIZE=\"TRUE\" WIDTH=\"" + number(std::round(std::max(1.0, width))) + "\" HEIGHT=\"" +
           number(std::round(std::max(1.0, height))) + "\"" + port + "></TD>";
  };
  const auto row = [&](double height, const char* port = "") {
    return "<TR>" + cell(extent.left - 1, height) + cell(2, height, port) + cell(extent.right - 1, height) + "</TR>";
  };
  return "n" + std::to_string(id.value) +
         " [label=<<TABLE BORDER=\"0\" CELLBORDER=\"0\" CELLPADDING=\"0\" CELLSPACING=\"0\">" + row(extent.top - 1) +
         row(2, " PORT=\"c\"") + row(extent.bottom - 1) + "</TABLE>>];\n";
}

std::string edge_text(ElementId from, ElementId to, int weight) {
  return "n" + std::to_string(from.value) + ":c -> n" + std::to_string(to.value) +
         ":c [weight=" + std::to_string(weight) + "];\n";
}

/// Hosts by their submodel, clusters nested as the submodels are.
void add_nodes(std::ostringstream& text, const Model& model, const std::vector<Standing>& standing,
               const std::vector<Extent>& extent) {
  std::map<std::string, std::vector<ElementId>> by_scope;
  for (std::size_t i = 0; i < standing.size(); ++i) {
    std::string scope = scope_of(model.elements[i].name);
    if (standing[i].side == Side::none) by_scope[scope].push_back(ElementId(i));
    // A submodel that holds submodels only is a cluster as well.
    for (; !scope.empty(); scope = scope_of(scope.substr(0, scope.size() - 1))) by_scope[scope];
  }
  // In order of names, "a." comes before "a.b.": a stack of what is open is enough.
  std::vector<std::string> open;
  const auto close_until = [&](const std::string& scope) {
    while (!open.empty() && !scope.starts_with(open.back())) {
      open.pop_back();
      text << "}\n";
    }
  };
  for (const auto& [scope, hosts] : by_scope) {
    close_until(scope);
    if (!scope.empty()) {
      text << "subgraph \"cluster_" << scope << "\" {\nmargin=22;\n";
      open.push_back(scope);
    }
    for (const ElementId host : hosts) text << node_text(host, extent[host.index()]);
  }
  close_until("");
  while (!open.empty()) {
    open.pop_back();
    text << "}\n";
  }
}

/// The bonded parts of the graph, as numbers by ElementId.
std::vector<std::size_t> parts_of(const Model& model) {
  std::vector<std::size_t> parent(model.elements.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const ModelBond& bond : model.bonds) parent[root(bond.from.element.index())] = root(bond.to.element.index());
  for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = root(i);
  return parent;
}

/// Whether signals join what no bonds do: such parts need room between them.
bool signals_between_parts(const Model& model) {
  const std::vector<std::size_t> part = parts_of(model);
  const std::vector<ReadSignal> signals = read_signals(model);
  return std::any_of(signals.begin(), signals.end(), [&](const ReadSignal& signal) {
    const ElementId from = signal.from.valid() ? signal.from : model.bonds[signal.from_bond.index()].from.element;
    return part[from.index()] != part[signal.to.index()];
  });
}

/// Where rows of a folded layout may be cut, and what a cut severs.
struct Cut {
  double x = 0.0;
  std::size_t severed = 0;
};

std::vector<Cut> cuts_of(const Model& model, const std::vector<Standing>& standing, const std::vector<Extent>& extent,
                         const std::vector<Point>& at) {
  std::vector<std::pair<double, int>> bounds;  // of hosts and of frames: nothing is cut through
  std::map<std::string, Box> frames;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (standing[i].side != Side::none) continue;
    const Box box{{at[i].x - extent[i].left, 0.0}, {at[i].x + extent[i].right, 0.0}};
    bounds.insert(bounds.end(), {{box.low.x, 1}, {box.high.x, -1}});
    const std::string& name = model.elements[i].name;
    const std::size_t dot = name.find('.');
    if (dot == std::string::npos) continue;
    const auto [frame, fresh] = frames.emplace(name.substr(0, dot), box);
    if (!fresh) frame->second = united(frame->second, box);
  }
  for (const auto& [name, box] : frames) bounds.insert(bounds.end(), {{box.low.x - 30.0, 1}, {box.high.x + 30.0, -1}});
  std::sort(bounds.begin(), bounds.end());
  std::vector<std::pair<double, double>> bonds;
  for (const ModelBond& bond : model.bonds)
    bonds.push_back(std::minmax(at[bond.from.element.index()].x, at[bond.to.element.index()].x));
  std::vector<Cut> cuts;
  int open = 0;
  for (std::size_t i = 0; i + 1 < bounds.size(); ++i) {
    open += bounds[i].second;
    if (open != 0 || bounds[i + 1].first <= bounds[i].first) continue;
    Cut cut{(bounds[i].first + bounds[i + 1].first) / 2, 0};
    for (const auto& [low, high] : bonds) cut.severed += low < cut.x && cut.x < high ? 1U : 0U;
    cuts.push_back(cut);
  }
  return cuts;
}

/// Folds a strip into rows, alternately from left to right and back, where a row ends at few bonds.
void fold(const Model& model, const std::vector<Standing>& standing, const std::vector<Extent>& extent,
          std::vector<Point>& at, double width, double height) {
  constexpr double kWideEnough = 1600.0, kRatio = 3.6, kWanted = 1.7, kGap = 40.0;
  constexpr std::size_t kMostSevered = 2;
  if (width < kWideEnough || width < kRatio * height) return;
  const double rows = std::round(std::sqrt(width / (kWanted * (height + kGap))));
  const std::vector<Cut> cuts = cuts_of(model, standing, extent, at);
  std::vector<double> ends;
  for (double row = 1.0; row < rows; row += 1.0) {
    const double wanted = row * width / rows, reach = 0.4 * width / rows;
    const Cut* best = nullptr;
    const auto cost = [&](const Cut& cut) { return std::pair(cut.severed, std::abs(cut.x - wanted)); };
    for (const Cut& cut : cuts)
      if (std::abs(cut.x - wanted) < reach && cut.severed <= kMostSevered && (!best || cost(cut) < cost(*best)))
        best = &cut;
    if (best == nullptr) return;
    ends.push_back(best->x);
  }
  std::vector<double> starts{0.0};
  for (const double end : ends) starts.push_back(end);
  // A row begins above or below where the former one ends.
  std::vector<double> left{0.0};
  double turn = 0.0;
  for (std::size_t row = 0; row < starts.size(); ++row) {
    const double length = (row < ends.size() ? ends[row] : width) - starts[row];
    left.resize(row + 1);
    left[row] = turn;
    turn += row % 2 == 0 ? length : -length;
  }
  double least = 0.0;
  for (Point& point : at) {
    const auto row = static_cast<std::size_t>(std::upper_bound(ends.begin(), ends.end(), point.x) - ends.begin());
    const double along = point.x - starts[row];
    point = {left[row] + (row % 2 == 0 ? along : -along), point.y + static_cast<double>(row) * (height + kGap)};
    least = std::min(least, point.x);
  }
  for (Point& point : at) point.x -= least;
}

/// Puts parts that nothing bonds together one below the other in the model's order, where each has a band of its own.
void restack(const Model& model, const std::vector<Standing>& standing, const std::vector<Extent>& extent,
             std::vector<Point>& at) {
  const std::vector<std::size_t> part = parts_of(model);
  struct Band {
    double top = 0.0, bottom = 0.0, moved = 0.0;
  };
  std::map<std::size_t, Band> bands;
  std::vector<std::size_t> wanted;  // parts in the model's order
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (standing[i].side != Side::none) continue;
    if (model.elements[i].name.find('.') != std::string::npos) return;  // a frame may hold several parts
    const Band here{at[i].y - extent[i].top, at[i].y + extent[i].bottom, 0.0};
    const auto [band, fresh] = bands.emplace(part[i], here);
    if (fresh) wanted.push_back(part[i]);
    band->second.top = std::min(band->second.top, here.top);
    band->second.bottom = std::max(band->second.bottom, here.bottom);
  }
  std::vector<Band> down;
  for (const auto& [id, band] : bands) down.push_back(band);
  std::sort(down.begin(), down.end(), [](const Band& a, const Band& b) { return a.top < b.top; });
  for (std::size_t k = 1; k < down.size(); ++k)
    if (down[k].top < down[k - 1].bottom) return;
  double top = down.front().top;
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    Band& band = bands[wanted[k]];
    band.moved = top - band.top;
    top += band.bottom - band.top + (k + 1 < down.size() ? down[k + 1].top - down[k].bottom : 0.0);
  }
  for (std::size_t i = 0; i < at.size(); ++i) at[i].y += bands[part[i]].moved;
}

}  // namespace

std::string layout_request(const Model& model) {
  const std::vector<Standing> standing = standings(model);
  const Flow flow = flow_of(model, standing);
  std::ostringstream text;
  text << "digraph bonds {\nrankdir=LR; splines=false; overlap=false; "
       << (signals_between_parts(model) ? "nodesep=0.8; ranksep=1.4;" : "nodesep=0.3; ranksep=0.8;")
       << "\nnode [shape=plain]; edge [dir=none];\n";
  add_nodes(text, model, standing, extents(model, standing, flow.hands));
  for (const Rank& rank : flow.ranks) text << edge_text(rank.left, rank.right, rank.weight);
  text << "}\n";
  return text.str();
}

Layout read_layout(const Model& model, const std::string& plain) {
  const std::vector<Standing> standing = standings(model);
  const std::vector<Extent> extent = extents(model, standing, flow_of(model, standing).hands);
  constexpr double kPixels = 72.0;  // a point of Graphviz is drawn as a pixel
  Layout layout;
  layout.elements.resize(model.elements.size());
  std::vector<bool> placed(model.elements.size(), false);
  std::istringstream lines(plain);
  std::string line;
  double width = 0.0, height = 0.0;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string what, name;
    double x = 0.0, y = 0.0;
    if (!(words >> what)) continue;
    if (what == "graph") {
      double scale = 1.0;
      words >> scale >> width >> height;
      width *= kPixels;
      height *= kPixels;
    } else if (what == "node" && words >> name >> x >> y) {
      std::size_t id = 0;
      const char* end = name.data() + name.size();
      if (std::from_chars(name.data() + 1, end, id).ptr != end || id >= placed.size())
        throw std::invalid_argument("no such node: " + name);
      const Extent& e = extent[id];
      layout.elements[id] = {kPixels * x + (e.left - e.right) / 2, height - kPixels * y + (e.top - e.bottom) / 2};
      placed[id] = true;
    }
  }
  for (std::size_t i = 0; i < placed.size(); ++i)
    if (standing[i].side == Side::none && !placed[i])
      throw std::invalid_argument("element \"" + model.elements[i].name + "\" has no place");
  for (std::size_t i = 0; i < placed.size(); ++i)
    if (standing[i].side != Side::none)
      layout.elements[i] =
          layout.elements[standing[i].host.index()] + Point{0.0, standing[i].side == Side::above ? -kDrop : kDrop};
  restack(model, standing, extent, layout.elements);
  centre(model, standing, extent, layout.elements);
  fold(model, standing, extent, layout.elements, width, height);
  return layout;
}

}  // namespace bgsim
