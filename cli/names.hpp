/// Names as they are given on the command line.
#pragma once

#include <string>
#include <vector>

namespace bgsim::cli {

/// Parts between commas, as they are written. Commas in double quotes separate nothing, nor do those in brackets where
/// the parts may be expressions.
std::vector<std::string> parts_of_list(const std::string& list, bool expressions = false);
/// Where NAME ends in NAME=...: the first equals sign outside of double quotes, or npos.
std::string::size_type end_of_name(const std::string& text);
/// A name without the blanks around it. One in double quotes is what is between them, two of these standing for one.
std::string name_of(const std::string& text);
/// The opposite: in double quotes if it holds a comma, an equals sign or a double quote.
std::string quoted_name(const std::string& name);

}  // namespace bgsim::cli
