/// Pieces of HTML.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace bgsim::cli {

/// A table with a header; cells are HTML already. The first cell of each row heads it. Wide tables scroll by
/// themselves.
/// @param numeric  columns to be set flush right.
std::string html_table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows,
                       const std::vector<std::size_t>& numeric = {});

/// A section of a page with its title; @p inside is HTML.
std::string html_section(const std::string& id, std::string_view title, std::string_view inside);

/// A part that can be folded away.
/// @param summary,inside  HTML.
std::string folded(std::string_view summary, std::string_view inside, bool open = false);

/// A paragraph, and one that is a note; @p inside is HTML.
std::string paragraph(std::string_view inside);
std::string note_paragraph(std::string_view inside);

/// Lines as they stand, which scroll by themselves.
std::string preformatted(std::string_view text, std::string_view css_class = {});

std::string badge(bool good, std::string_view text);

/// What is wider than the page scrolls by itself.
std::string scrolling(std::string_view inside);

/// JSON as the content of a <script> element, which it cannot end.
std::string script_json(const nlohmann::ordered_json& json);

/// Bytes, and little-endian doubles, in base 64 (RFC 4648).
std::string base64(std::string_view bytes);
std::string base64(std::span<const double> values);

/// A picture that is part of the page, and shares no names with it.
/// @param about  what it shows, for those who do not see it.
std::string svg_image(std::string_view svg, std::string_view about);

/// A style sheet or script as the content of its element.
/// @throws std::logic_error if it would end the element.
std::string_view raw_text(std::string_view text, std::string_view element);

}  // namespace bgsim::cli
