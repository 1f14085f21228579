#include "sweep_indices.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "bars.hpp"
#include "bgsim/csv.hpp"
#include "bgsim/text.hpp"
#include "table.hpp"

namespace bgsim::cli {

namespace {

using Json = nlohmann::ordered_json;

SweepPlan plan_of(const Json& identity) {
  SweepPlan plan;
  for (const auto& [name, values] : identity["vary"].items())
    plan.variations.push_back(parse_variation(name + "=" + values.get<std::string>()));
  const bool variance = identity["sampling"] == "saltelli";
  plan.sampling = variance ? Sampling::saltelli : Sampling::morris;
  plan.samples = identity["runs"].get<std::uint64_t>() / (plan.variations.size() + (variance ? 2 : 1));
  plan.seed = identity["seed"].get<std::uint64_t>();
  return plan;
}

std::string cell(double value, int digits) { return std::isnan(value) ? "" : number_text(value, digits); }

/// Indices from the largest on; those without a value last.
std::vector<std::size_t> by_size(std::size_t count, const auto& size) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto known = [&](std::size_t i) { return std::isnan(size(i)) ? -1.0 : size(i); };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return known(a) > known(b); });
  return order;
}

}  // namespace

bool SweepIndices::has(const Json& identity) {
  return identity["sampling"] == "saltelli" || identity["sampling"] == "morris";
}

SweepIndices::SweepIndices(const Json& identity, const SweepTable& table)
    : variance_(identity["sampling"] == "saltelli") {
  const SweepPoints points(plan_of(identity));
  samples_ = points.plan().samples;
  title_ = identity["model"].get<std::string>() + ", scene " + identity["scene"].get<std::string>() + ", " +
           std::to_string(table.runs.size()) + " runs";
  for (const Variation& variation : points.plan().variations) quantities_.push_back(variation.name);
  results_ = identity["results"].get<std::vector<std::string>>();
  const double tolerance = identity["relative"].get<double>();
  for (const std::string& name : results_) {
    const std::vector<double>& column = table.column(name);
    std::vector<double> values(points.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < column.size(); ++i) values[table.runs[i]] = column[i];
    double least = std::numeric_limits<double>::infinity(), most = -least;
    std::uint64_t present = 0;
    for (const double value : values) {
      if (!std::isfinite(value)) continue;
      least = std::min(least, value);
      most = std::max(most, value);
      ++present;
    }
    note_missing(name, present, variance_ ? "points" : "paths");
    // What the runs do not know of the result, they do not know of its changes.
    if (most > least && most - least <= 10.0 * tolerance * std::max(std::abs(least), std::abs(most)))
      notes_.push_back(short_name(name) + " changes by " + number_text(most - least, 3) +
                       " in all, no more than ten tolerances of the runs: its indices are those of their errors");
    if (variance_)
      shares_.push_back(variance_shares(points, values));
    else
      effects_.push_back(elementary_effects(points, values));
  }
  constexpr std::uint64_t kFewPoints = 64, kFewPaths = 4;
  if (samples_ < (variance_ ? kFewPoints : kFewPaths))
    notes_.push_back(std::to_string(samples_) + (variance_ ? " points are" : " paths are") +
                     " few: \"within\" itself is rough");
}

void SweepIndices::note_missing(const std::string& result, std::uint64_t present, const std::string& what) {
  const std::uint64_t runs = samples_ * (quantities_.size() + (variance_ ? 2 : 1));
  if (present == runs) return;
  notes_.push_back(short_name(result) + " has no value in " + std::to_string(runs - present) + " of " +
                   std::to_string(runs) + " runs: its indices are those of the " + what + " that have");
}

std::string SweepIndices::table() const {
  std::string text;
  for (std::size_t r = 0; r < results_.size(); ++r) {
    text += (r > 0 ? "\n" : "") + short_name(results_[r]);
    if (variance_) {
      const VarianceShares& all = shares_[r];
      text += all.points == 0        ? ": no value in any pair of runs\n"
              : all.deviation == 0.0 ? ": " + number_text(all.mean, 9) + " in all runs\n"
                                     : ": mean " + number_text(all.mean, 6) + ", standard deviation " +
                                           number_text(all.deviation, 6) + "\n";
      TextTable rows({"p", "first", "within", "total", "within"});
      for (const std::size_t i : by_size(all.of.size(), [&](std::size_t k) { return all.of[k].total; }))
        rows.add({quantities_[i], cell(all.of[i].first, 4), cell(all.of[i].first_within, 2), cell(all.of[i].total, 4),
                  cell(all.of[i].total_within, 2)});
      text += rows.text();
    } else {
      text += ": effects of going through the whole distribution\n";
      TextTable rows({"p", "mu*", "within", "mu", "sigma", "effects"});
      const auto& own = effects_[r];
      for (const std::size_t i : by_size(own.size(), [&](std::size_t k) { return own[k].magnitude; }))
        rows.add({quantities_[i], cell(own[i].magnitude, 4), cell(own[i].within, 2), cell(own[i].mean, 4),
                  cell(own[i].deviation, 4), std::to_string(own[i].effects)});
      text += rows.text();
    }
  }
  return text;
}

std::string SweepIndices::csv() const {
  std::string text = variance_ ? "result,quantity,first,first_within,total,total_within,mean,deviation,points\r\n"
                               : "result,quantity,mu_star,mu_star_within,mu,sigma,effects\r\n";
  for (std::size_t r = 0; r < results_.size(); ++r)
    for (std::size_t i = 0; i < quantities_.size(); ++i) {
      text += csv_field(results_[r]) + "," + csv_field(quantities_[i]);
      const auto add = [&text](std::initializer_list<double> values) {
        for (const double value : values) text += "," + cell(value, 17);
      };
      if (variance_) {
        const VarianceShare& own = shares_[r].of[i];
        add({own.first, own.first_within, own.total, own.total_within, shares_[r].mean, shares_[r].deviation});
        text += "," + std::to_string(own.points) + "\r\n";
      } else {
        const ElementaryEffect& own = effects_[r][i];
        add({own.magnitude, own.within, own.mean, own.deviation});
        text += "," + std::to_string(own.effects) + "\r\n";
      }
    }
  return text;
}

std::string SweepIndices::svg() const {
  constexpr std::size_t kMostPanels = 8, kMostRows = 30;
  const std::size_t panels = std::min(results_.size(), kMostPanels);
  std::vector<BarPanel> all;
  for (std::size_t r = 0; r < panels; ++r) {
    BarPanel panel{
        short_name(results_[r]) + (variance_ ? ": shares of the variance" : ": effects of whole distributions"),
        {},
        {}};
    panel.legend = variance_ ? std::vector<std::string>{"with all others (total)", "alone (first order)"}
                             : std::vector<std::string>{"mu*: mean magnitude", "sigma: spread"};
    std::vector<std::size_t> order = by_size(quantities_.size(), [&](std::size_t i) {
      return variance_ ? shares_[r].of[i].total : effects_[r][i].magnitude;
    });
    if (order.size() > kMostRows) order.resize(kMostRows);
    for (const std::size_t i : order) {
      BarRow row{quantities_[i], {}};
      if (variance_) {
        const VarianceShare& own = shares_[r].of[i];
        row.bars = {{0.0, own.total, own.total_within, 0}, {0.0, own.first, own.first_within, 1}};
      } else {
        const ElementaryEffect& own = effects_[r][i];
        row.bars = {{0.0, own.magnitude, own.within, 0}, {0.0, own.deviation, 0.0, 1}};
      }
      panel.rows.push_back(std::move(row));
    }
    all.push_back(std::move(panel));
  }
  return bars_svg(title_, all);
}

}  // namespace bgsim::cli
