#include "trade_picture.hpp"

#include <array>
#include <cstdio>
#include <map>
#include <sstream>
#include <vector>

#include "bgsim/text.hpp"
#include "bgsim/xml.hpp"
#include "command.hpp"
#include "gnuplot.hpp"
#include "html.hpp"

namespace bgsim::cli {

namespace {

/// A curve's look: colour by family, one of few brightnesses within it.
struct Look {
  const char* colour;
  int dash, point;
};

Look look_of(const TradeSetting& setting) {
  static const std::map<std::string, Look> looks{
      {"bdf", {"#1f4e9c", 1, 7}},      {"bdf of order up to 2", {"#7ba3e0", 1, 6}},
      {"adams", {"#10899e", 1, 5}},    {"ida", {"#5b4a9e", 1, 4}},
      {"erk2", {"#f6c28b", 1, 8}},     {"erk3", {"#f0a04b", 1, 9}},
      {"erk4", {"#e07b16", 1, 10}},    {"erk5", {"#c25a00", 1, 11}},
      {"erk6", {"#96400a", 1, 12}},    {"erk8", {"#5e2705", 1, 13}},
      {"dirk2", {"#a9d49b", 1, 8}},    {"dirk3", {"#6fb35c", 1, 9}},
      {"dirk4", {"#3a8f2a", 1, 10}},   {"dirk5", {"#1e5c14", 1, 11}},
      {"radau", {"#b8860b", 1, 2}},    {"radau9", {"#8f6a08", 1, 12}},
      {"radau13", {"#5c4405", 1, 13}}, {"rodas5p", {"#7a5c00", 1, 3}},
      {"euler", {"#b0b0b0", 2, 1}},    {"implicit_euler", {"#808080", 2, 2}},
      {"rk4", {"#c03060", 2, 3}},      {"verlet", {"#8c1d8c", 2, 4}}};
  const auto found = looks.find(curve_name(setting));
  return found == looks.end() ? Look{"#000000", 1, 1} : found->second;
}

struct Curve {
  TradeSetting setting;
  std::vector<const TradeRow*> rows;
};

/// Rows that can be drawn, by curve: the stable ones.
std::vector<Curve> curves_of(const Trade& trade) {
  std::vector<Curve> curves;
  for (const TradeRow& row : trade.rows) {
    if (row.verdict != TradeVerdict::stable || !(row.max_error > 0.0) || !(row.cpu_seconds > 0.0)) continue;
    if (curves.empty() || curve_name(curves.back().setting) != curve_name(row.setting))
      curves.push_back({row.setting, {}});
    curves.back().rows.push_back(&row);
  }
  return curves;
}

std::string script(const Trade& trade, std::optional<std::size_t> picked) {
  const std::vector<Curve> curves = curves_of(trade);
  if (curves.empty()) throw UsageError("no setting came to the end of the scene: there is nothing to draw");
  std::ostringstream text;
  const auto block = [&](const std::string& name, auto&& rows) {
    text << "$" << name << " << EOD\n";
    for (const TradeRow* row : rows)
      text << number_text(row->cpu_seconds, 9) << ' ' << number_text(row->max_error, 9) << '\n';
    text << "EOD\n";
  };
  for (std::size_t i = 0; i < curves.size(); ++i) block("c" + std::to_string(i), curves[i].rows);
  std::vector<const TradeRow*> front;
  for (const TradeRow& row : trade.rows)
    if (row.pareto) front.push_back(&row);
  std::sort(front.begin(), front.end(), [](auto* a, auto* b) { return a->cpu_seconds < b->cpu_seconds; });
  block("front", front);
  if (picked) block("picked", std::vector<const TradeRow*>{&trade.rows[*picked]});
  text << "set terminal svg size 900,540 dynamic noenhanced font 'Helvetica,13' background '#ffffff'\n"
          "set logscale xy\nset format x '10^{%T}'\nset format '%.0e'\n"
          "set xlabel 'processor time of a run in s'\nset ylabel 'largest error / range of the output'\n"
          "set key outside right top vertical samplen 2 spacing 1.1\nset grid lc rgb '#dddddd' lt 1\n"
       << "set title " << gnuplot_string(trade.model + ", scene " + trade.scene) << "\n"
       << "set arrow from graph 0, first " << number_text(std::max(trade.reference.error, 1e-16), 6)
       << " to graph 1, first " << number_text(std::max(trade.reference.error, 1e-16), 6)
       << " nohead lc rgb '#888888' dashtype 3\n"
       << "set label \"reference's own error\" at graph 0.01, first "
       << number_text(1.25 * std::max(trade.reference.error, 1e-16), 6) << " tc rgb '#666666' font ',10'\n"
       << "plot $front with lines lc rgb '#000000' lw 5 dashtype 1 title 'Pareto front'";
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const Look look = look_of(curves[i].setting);
    text << ", $c" << i << " with linespoints lc rgb '" << look.colour << "' lw 1.6 dashtype " << look.dash << " pt "
         << look.point << " ps 0.7 title " << gnuplot_string(curve_name(curves[i].setting));
  }
  text << ", $front with points pt 6 ps 1.5 lw 1.5 lc rgb '#000000' notitle";
  if (picked) text << ", $picked with points pt 3 ps 2 lw 2 lc rgb '#d00000' title 'picked'";
  text << "\n";
  return text.str();
}

std::string html_row(const TradeRow& row) {
  std::string cells;
  const auto cell = [&](const std::string& text) { cells += xml_text_element("td", text); };
  const bool known = !row.errors.empty();
  cell(setting_flags(row.setting));
  cell(known ? number_text(row.max_error, 3) : "");
  cell(known ? number_text(row.rms_error, 3) : "");
  cell(number_text(row.cpu_seconds, 3));
  for (const std::uint64_t count : {row.steps, row.rates, row.jacobians, row.factorizations})
    cell(std::to_string(count));
  cell(row.energy_residual ? number_text(*row.energy_residual, 3) : "");
  cell(std::string(verdict_text(row.verdict)) + (row.why.empty() ? "" : ": " + row.why));
  XmlAttributes attributes;
  if (row.pareto)
    attributes = {{"class", "front"}};
  else if (row.verdict != TradeVerdict::stable)
    attributes = {{"class", "bad"}};
  return xml_element("tr", attributes, cells) + "\n";
}

}  // namespace

std::string trade_svg(const Trade& trade, std::optional<std::size_t> picked) {
  return svg_from_gnuplot(script(trade, picked));
}

std::string trade_html(const Trade& trade, const std::string& svg) {
  const std::string title = trade.model + ", scene " + trade.scene;
  const char* const style =
      "body{font-family:sans-serif;max-width:75em;margin:2em auto;padding:0 1em}"
      "svg{width:100%;height:auto}table{border-collapse:collapse;font-size:85%}"
      "td,th{padding:.2em .6em;border-bottom:1px solid #ddd;text-align:right}"
      "td:first-child,th:first-child,td:last-child,th:last-child{text-align:left}"
      ".front{font-weight:bold}.bad{color:#888}";
  const auto code = [](const TradeSetting& setting) { return xml_text_element("code", setting_flags(setting)); };
  std::string body = xml_text_element("h1", title) + "\n" + (svg.empty() ? svg : svg.substr(svg.find("<svg"))) + "\n";
  body +=
      paragraph("Errors are relative to each output's range, the largest over outputs and output times. Reference: " +
                code(trade.reference.setting) + "; its own error, by " + code(trade.reference.second) + ": " +
                number_text(trade.reference.error, 3) +
                ". Processor time: median of repeated runs without audit. Bold: on the Pareto front.");
  for (const TradeOutput& output : trade.outputs)
    if (!output.judged()) body += paragraph(xml_text(output.name + " is not judged: " + output.why_not + "."));
  for (const std::string& note : trade.notes) body += paragraph(xml_text(note + "."));
  std::string titles;
  for (const char* const name : {"setting", "max error", "RMS error", "time in s", "steps", "rates", "Jacobians",
                                 "factorizations", "energy residual", "stable"})
    titles += xml_text_element("th", name);
  std::string rows = xml_element("tr", titles) + "\n";
  for (const TradeRow& row : trade.rows) rows += html_row(row);
  body += xml_element("table", rows) + "\n";
  const std::string head = xml_empty("meta", {{"charset", "utf-8"}}) +
                           xml_text_element("title", "bgsim trade: " + title) + "\n" + xml_element("style", style);
  return "<!DOCTYPE html>\n" +
         xml_element("html", {{"lang", "en"}}, xml_element("head", head) + "\n" + xml_element("body", body)) + "\n";
}

}  // namespace bgsim::cli
