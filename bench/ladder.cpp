#include "ladder.hpp"

namespace bgsim::bench {

namespace {

void append_section(std::string& elements, std::string& bonds, std::size_t i) {
  const std::string n = std::to_string(i);
  const std::string before = i == 0 ? "source" : "node" + std::to_string(i - 1);
  elements += ",\n    \"loop" + n + "\": { \"kind\": \"1\" }, \"node" + n + "\": { \"kind\": \"0\" }";
  elements += ", \"R" + n + "\": { \"kind\": \"R\", \"resistance\": \"R\" }";
  elements += ", \"C" + n + "\": { \"kind\": \"C\", \"capacitance\": \"C\" }";
  const auto bond = [&bonds](const std::string& from, const std::string& to) {
    bonds += bonds.empty() ? "\n    " : ",\n    ";
    bonds += "{ \"from\": \"" + from + "\", \"to\": \"" + to + "\" }";
  };
  bond(before, "loop" + n);
  bond("loop" + n, "R" + n);
  bond("loop" + n, "node" + n);
  bond("node" + n, "C" + n);
}

}  // namespace

std::string ladder_json(std::size_t sections, std::size_t samples) {
  std::string elements = "    \"source\": { \"kind\": \"Se\", \"effort\": \"1\" }";
  std::string bonds;
  for (std::size_t i = 0; i < sections; ++i) append_section(elements, bonds, i);
  return "{\n  \"bgsim\": 1,\n  \"name\": \"ladder\",\n  \"parameters\": { \"R\": 1, \"C\": 1 },\n  \"elements\": {\n" +
         elements + "\n  },\n  \"bonds\": [" + bonds + "\n  ],\n  \"outputs\": { \"e\": \"node0.e\" },\n" +
         "  \"scenes\": { \"charge\": { \"stop\": 1, \"samples\": " + std::to_string(samples) + " } }\n}\n";
}

}  // namespace bgsim::bench
