/// The trade as a picture (gnuplot) and as a page.
#pragma once

#include <string>

#include "bgsim/trade.hpp"

namespace bgsim::cli {

/// Error against processor time, both logarithmic: one curve a method, the Pareto front marked.
/// @param picked  row to be marked, if any.
/// @throws UsageError if gnuplot is not there or fails.
std::string trade_svg(const Trade& trade, std::optional<std::size_t> picked);

/// One self-contained page: the picture, what it was measured against, the table.
std::string trade_html(const Trade& trade, const std::string& svg);

}  // namespace bgsim::cli
