/// Text in CSV.
#pragma once

#include <string>
#include <string_view>

namespace bgsim {

/// @p text as a field of a record (RFC 4180): in quotes, with doubled quotes inside, where it holds a comma, a quote or
/// a line break, else as it is. It is never altered, so that it reads back the same; that a spreadsheet takes a field
/// that begins with =, +, - or @ for a formula is a matter of the spreadsheet (docs/design/writers.md).
std::string csv_field(std::string_view text);

}  // namespace bgsim
