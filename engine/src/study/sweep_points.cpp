// Which values the runs of a sweep have.
#include <algorithm>
#include <array>
#include <boost/math/distributions/normal.hpp>
#include <boost/random/sobol.hpp>
#include <charconv>
#include <cmath>
#include <limits>
#include <random>
#include <string_view>

#include "base/text.hpp"
#include "bgsim/sweep.hpp"
#include "bgsim/text.hpp"

namespace bgsim {

namespace {

constexpr double kMostRuns = 1e9;
constexpr std::uint64_t kMostSamples = 100'000'000;  // of a Latin hypercube the order of parts is in memory
constexpr const char* kForms =
    "write NAME=1,2,5 or NAME=1:5:9 or NAME=log(1:100:9); with --sample also NAME=1:5, log(1:100), normal(mean,sd), "
    "lognormal(median,s), uniform(a,b), triangular(a,mode,b)";

/// Reads the parts of what was written for one quantity; faults quote the whole.
class VariationReader {
 public:
  explicit VariationReader(const std::string& whole) : whole_(whole) {}

  Variation read() const {
    const auto equals = whole_.find('=');
    if (equals == std::string::npos) fault("it has no \"=\"", kForms);
    Variation result;
    result.name = trimmed(std::string_view(whole_).substr(0, equals));
    result.text = trimmed(std::string_view(whole_).substr(equals + 1));
    if (result.name.empty()) fault("it names nothing before \"=\"", kForms);
    if (result.text.empty()) fault("there is nothing behind \"=\"", kForms);
    read_values(result);
    return result;
  }

 private:
  [[noreturn]] void fault(const std::string& what, std::string help = {}) const {
    throw SweepError("--vary " + in_quotes(whole_) + ": " + what, std::move(help));
  }

  [[nodiscard]] double number(std::string_view text) const {
    text = trimmed(text);
    double value = 0.0;
    const std::string_view digits = text.starts_with('+') ? text.substr(1) : text;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (digits.empty() || error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value))
      fault(in_quotes(text) + " is no number", kForms);
    return value;
  }

  [[nodiscard]] std::vector<std::string_view> split(std::string_view text, char mark) const {
    std::vector<std::string_view> parts;
    while (true) {
      const auto at = text.find(mark);
      parts.push_back(text.substr(0, at));
      if (at == std::string_view::npos) return parts;
      text.remove_prefix(at + 1);
    }
  }

  [[nodiscard]] std::vector<double> numbers(std::string_view text, char mark) const {
    std::vector<double> result;
    for (const std::string_view part : split(text, mark)) result.push_back(number(part));
    return result;
  }

  void read_values(Variation& result) const {
    std::string_view text = result.text;
    const auto open = text.find('(');
    if (open == std::string_view::npos) {
      if (text.find(':') != std::string_view::npos) return read_range(result, text, false);
      result.numbers = numbers(text, ',');
      return;
    }
    if (text.back() != ')') fault("a bracket is not closed", kForms);
    const std::string_view function = trimmed(text.substr(0, open));
    text = text.substr(open + 1, text.size() - open - 2);
    if (function == "log") return read_range(result, text, true);
    read_distribution(result, function, text);
  }

  /// a:b, or a:b:n
  void read_range(Variation& result, std::string_view text, bool logarithmic) const {
    const std::vector<std::string_view> parts = split(text, ':');
    if (parts.size() != 2 && parts.size() != 3) fault("a range is START:STOP or START:STOP:COUNT", kForms);
    const double from = number(parts[0]), to = number(parts[1]);
    check_range(from, to);
    if (logarithmic && !(from > 0.0)) fault("a logarithmic range begins above 0");
    if (parts.size() == 2) {
      result.kind = logarithmic ? Variation::Kind::log_uniform : Variation::Kind::uniform;
      result.numbers = {from, to};
      return;
    }
    const double count = number(parts[2]);
    if (count != std::floor(count) || count < 2.0 || count > kMostRuns)
      fault("the number of values is " + std::string(trimmed(parts[2])) + ", not an integer from 2 to 1e9");
    const auto last = static_cast<std::size_t>(count) - 1;
    for (std::size_t i = 0; i <= last; ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(last);
      result.numbers.push_back(i == 0        ? from
                               : i == last   ? to
                               : logarithmic ? from * std::pow(to / from, share)
                                             : from + (to - from) * share);
    }
  }

  void check_range(double from, double to) const {
    if (from == to) fault("the range is empty: it begins and ends at " + number_text(from));
    if (from > to) fault("the start " + number_text(from) + " is above the stop " + number_text(to));
  }

  void read_distribution(Variation& result, std::string_view function, std::string_view text) const {
    struct Form {
      std::string_view name;
      Variation::Kind kind;
      std::size_t count;
      const char* arguments;
    };
    static constexpr std::array<Form, 4> kDistributions{{
        {"normal", Variation::Kind::normal, 2, "normal(mean,sd)"},
        {"lognormal", Variation::Kind::log_normal, 2, "lognormal(median,s), s the standard deviation of the logarithm"},
        {"uniform", Variation::Kind::uniform, 2, "uniform(a,b)"},
        {"triangular", Variation::Kind::triangular, 3, "triangular(a,mode,b)"},
    }};
    const auto* const form = std::find_if(kDistributions.begin(), kDistributions.end(),
                                          [&](const Form& known) { return known.name == function; });
    if (form == kDistributions.end()) fault("there is no distribution " + in_quotes(function), kForms);
    result.kind = form->kind;
    result.numbers = numbers(text, ',');
    const std::vector<double>& n = result.numbers;
    if (n.size() != form->count) fault(std::string("write ") + form->arguments);
    if (form->kind == Variation::Kind::uniform || form->kind == Variation::Kind::triangular)
      check_range(n.front(), n.back());
    if (form->kind == Variation::Kind::triangular && (n[1] < n[0] || n[1] > n[2]))
      fault("the mode " + number_text(n[1]) + " is outside of " + number_text(n[0]) + " to " + number_text(n[2]));
    if ((form->kind == Variation::Kind::normal || form->kind == Variation::Kind::log_normal) && !(n[1] > 0.0))
      fault("the standard deviation is " + number_text(n[1]) + ", not above 0");
    if (form->kind == Variation::Kind::log_normal && !(n[0] > 0.0))
      fault("the median is " + number_text(n[0]) + ", not above 0");
  }

  const std::string& whole_;
};

/// A generator that gives the n-th number without those before (the finalizer of SplitMix64; Steele, Lea, Flood, OOPSLA
/// 2014, from memory).
std::uint64_t mixed(std::uint64_t bits) {
  bits += 0x9e3779b97f4a7c15U;
  bits = (bits ^ (bits >> 30U)) * 0xbf58476d1ce4e5b9U;
  bits = (bits ^ (bits >> 27U)) * 0x94d049bb133111ebU;
  return bits ^ (bits >> 31U);
}

/// In (0, 1), never one of its ends.
double unit_number(std::uint64_t bits) {
  return (static_cast<double>(bits >> 11U) + 0.5) * 0x1p-53;  // 53 bits
}

/// Where a share @p u of the distribution lies below.
double quantile(const Variation& variation, double u) {
  const std::vector<double>& n = variation.numbers;
  const auto between = [u](double a, double b) { return a + (b - a) * u; };
  const auto standard = [u] { return boost::math::quantile(boost::math::normal(), u); };
  switch (variation.kind) {
    case Variation::Kind::list:
      return n[std::min(static_cast<std::size_t>(u * static_cast<double>(n.size())), n.size() - 1)];
    case Variation::Kind::uniform:
      return between(n[0], n[1]);
    case Variation::Kind::log_uniform:
      return n[0] * std::pow(n[1] / n[0], u);
    case Variation::Kind::normal:
      return n[0] + n[1] * standard();
    case Variation::Kind::log_normal:
      return n[0] * std::exp(n[1] * standard());
    case Variation::Kind::triangular: {
      const double low = n[1] - n[0], high = n[2] - n[1], whole = n[2] - n[0];
      return u * whole < low ? n[0] + std::sqrt(u * whole * low) : n[2] - std::sqrt((1.0 - u) * whole * high);
    }
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

Variation parse_variation(const std::string& text) { return VariationReader(text).read(); }

void parse_sampling(const std::string& text, SweepPlan& plan) {
  const auto fault = [&text](const std::string& what) {
    throw SweepError(
        "--sample " + in_quotes(text) + ": " + what,
        "write sobol:1000, lhs:1000 or random:1000; for indices of sensitivity saltelli:1024 or morris:20");
  };
  const auto colon = text.find(':');
  const std::string_view way = std::string_view(text).substr(0, colon);
  if (way == "sobol")
    plan.sampling = Sampling::sobol;
  else if (way == "lhs")
    plan.sampling = Sampling::latin_hypercube;
  else if (way == "random")
    plan.sampling = Sampling::random;
  else if (way == "saltelli")
    plan.sampling = Sampling::saltelli;
  else if (way == "morris")
    plan.sampling = Sampling::morris;
  else
    fault("there is no such way to sample");
  const std::string_view count = colon == std::string::npos ? "" : std::string_view(text).substr(colon + 1);
  std::uint64_t samples = 0;
  const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), samples);
  if (count.empty() || error != std::errc() || end != count.data() + count.size()) fault("it says no number of runs");
  if (samples == 0) fault("a sample of size 0 has no runs");
  if (samples > kMostSamples) fault("at most 1e8 runs");
  // One point has no variance, one path no spread.
  if (samples == 1 && plan.sampling == Sampling::saltelli)
    fault("the variance of one point is none; take at least two");
  if (samples == 1 && plan.sampling == Sampling::morris) fault("the spread of one path is none; take at least two");
  plan.samples = samples;
}

struct SweepPoints::Inside {
  SweepPlan plan;
  std::uint64_t size = 0;
  std::vector<std::uint64_t> shift;                 ///< of Sobol's sequence, by variation
  std::vector<std::vector<std::uint32_t>> part_of;  ///< of a Latin hypercube, by variation and run
  std::optional<boost::random::sobol> sequence;     ///< at its second point

  [[nodiscard]] std::uint64_t random_bits(std::size_t variation, std::uint64_t index) const {
    return mixed(mixed(mixed(plan.seed) ^ variation) ^ index);
  }

  /// The shares of point @p index of Sobol's sequence.
  [[nodiscard]] std::vector<double> sobol_shares(std::uint64_t index) const {
    std::vector<double> shares(shift.size());
    std::optional<boost::random::sobol> own;
    if (index > 0) {  // the first point is 0, which Boost leaves out
      own = sequence;
      own->discard((index - 1) * shift.size());
    }
    for (std::size_t i = 0; i < shift.size(); ++i) shares[i] = unit_number((own ? (*own)() : 0U) ^ shift[i]);
    return shares;
  }

  void prepare_sobol(std::size_t dimensions) {
    constexpr std::size_t kMostDimensions = 3667;
    if (dimensions > kMostDimensions)
      throw SweepError("Sobol's sequence has at most 3667 dimensions, and this takes " + std::to_string(dimensions),
                       "take --sample lhs:N, or vary fewer quantities");
    sequence.emplace(static_cast<unsigned>(dimensions));
    for (std::size_t i = 0; i < dimensions; ++i) shift.push_back(random_bits(i, 0));
  }

  /// @param runs  of one sample
  void take_size(std::size_t runs) {
    const double product = static_cast<double>(plan.samples) * static_cast<double>(runs);
    if (product > kMostRuns)
      throw SweepError("this sample has " + number_text(product, 3) + " runs, more than 1e9", "take a smaller one");
    size = plan.samples * runs;
  }

  /// A path of Morris: where each quantity begins, of four levels, and in which order they move.
  struct Path {
    std::vector<unsigned> level;
    std::vector<std::size_t> order;
  };
  [[nodiscard]] Path path(std::uint64_t number) const {
    const std::size_t count = plan.variations.size();
    Path path{std::vector<unsigned>(count), std::vector<std::size_t>(count)};
    for (std::size_t i = 0; i < count; ++i) {
      path.level[i] = static_cast<unsigned>(random_bits(i, number) >> 62U);
      path.order[i] = i;
    }
    for (std::size_t i = count; i > 1; --i)
      std::swap(path.order[i - 1], path.order[random_bits(count + i, number) % i]);
    return path;
  }
};

SweepPoints::SweepPoints(SweepPlan plan) {
  auto inside = std::make_unique<Inside>();
  inside->plan = std::move(plan);
  const SweepPlan& own = inside->plan;
  if (own.variations.empty()) throw SweepError("nothing is varied", "add --vary NAME=...");
  for (std::size_t i = 0; i < own.variations.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (own.variations[i].name == own.variations[j].name)
        throw SweepError("--vary names " + in_quotes(own.variations[i].name) + " twice");
  const std::size_t count = own.variations.size();
  double product = 1.0;
  switch (own.sampling) {
    case Sampling::grid:
      for (const Variation& variation : own.variations) {
        if (variation.kind != Variation::Kind::list)
          throw SweepError(
              "--vary " + in_quotes(variation.name + "=" + variation.text) + " is a distribution",
              "say how many values, as in " + variation.name + "=1:5:9, or how to sample: --sample sobol:1000");
        product *= static_cast<double>(variation.numbers.size());
      }
      if (product > kMostRuns)
        throw SweepError("the grid has " + number_text(product, 3) + " runs, more than 1e9",
                         "take fewer values, or --sample");
      inside->size = static_cast<std::uint64_t>(product);
      break;
    case Sampling::sobol:
      inside->prepare_sobol(count);
      inside->size = own.samples;
      break;
    case Sampling::saltelli:
      inside->prepare_sobol(2 * count);
      inside->take_size(count + 2);
      break;
    case Sampling::morris:
      inside->take_size(count + 1);
      break;
    case Sampling::latin_hypercube:
      for (std::size_t i = 0; i < count; ++i) {
        std::vector<std::uint32_t> part(own.samples);
        for (std::size_t k = 0; k < part.size(); ++k) part[k] = static_cast<std::uint32_t>(k);
        // Fisher and Yates. The bias of the remainder is below 1e-11 for 1e8 parts.
        for (std::size_t k = part.size(); k > 1; --k)
          std::swap(part[k - 1], part[inside->random_bits(count + i, k) % k]);
        inside->part_of.push_back(std::move(part));
      }
      [[fallthrough]];
    case Sampling::random:
      inside->size = own.samples;
      break;
  }
  inside_ = std::move(inside);
}

SweepPoints::~SweepPoints() = default;

const SweepPlan& SweepPoints::plan() const { return inside_->plan; }
std::uint64_t SweepPoints::size() const { return inside_->size; }

std::vector<double> SweepPoints::at(std::uint64_t index) const {
  const SweepPlan& plan = inside_->plan;
  const std::size_t count = plan.variations.size();
  std::vector<double> values(count);
  if (plan.sampling == Sampling::grid) {
    for (std::size_t i = count; i-- > 0;) {
      const std::vector<double>& own = plan.variations[i].numbers;
      values[i] = own[index % own.size()];
      index /= own.size();
    }
    return values;
  }
  std::vector<double> shares(count);
  switch (plan.sampling) {
    case Sampling::grid:
      break;  // above
    case Sampling::sobol:
      shares = inside_->sobol_shares(index);
      break;
    case Sampling::latin_hypercube:
      for (std::size_t i = 0; i < count; ++i)
        shares[i] = (inside_->part_of[i][index] + unit_number(inside_->random_bits(i, index))) /
                    static_cast<double>(plan.samples);
      break;
    case Sampling::random:
      for (std::size_t i = 0; i < count; ++i) shares[i] = unit_number(inside_->random_bits(i, index));
      break;
    case Sampling::saltelli: {
      const std::vector<double> both = inside_->sobol_shares(index / (count + 2));
      const std::uint64_t member = index % (count + 2);
      for (std::size_t i = 0; i < count; ++i) shares[i] = both[member == 1 || member == i + 2 ? count + i : i];
      break;
    }
    case Sampling::morris: {
      Inside::Path path = inside_->path(index / (count + 1));
      for (std::uint64_t moved = 0; moved < index % (count + 1); ++moved) path.level[path.order[moved]] ^= 2U;
      for (std::size_t i = 0; i < count; ++i) shares[i] = (path.level[i] + 0.5) / 4.0;
      break;
    }
  }
  for (std::size_t i = 0; i < count; ++i) values[i] = quantile(plan.variations[i], shares[i]);
  return values;
}

SweepPoints::Move SweepPoints::move_after(std::uint64_t index) const {
  const std::size_t count = inside_->plan.variations.size();
  const Inside::Path path = inside_->path(index / (count + 1));
  const std::size_t variation = path.order.at(index % (count + 1));
  return {variation, path.level[variation] < 2 ? 0.5 : -0.5};
}

}  // namespace bgsim
