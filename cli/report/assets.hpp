/// What the report's page is made of beside its content, embedded at build time (cmake/Web.cmake).
#pragma once

#include <string_view>

namespace bgsim::cli {

extern const std::string_view kPageStyle;     ///< cli/web/report.css
extern const std::string_view kPageScript;    ///< cli/web/report.js
extern const std::string_view kUplotStyle;    ///< uPlot, a plotting library, at the version that
extern const std::string_view kUplotScript;   ///< cli/web/package-lock.json pins; empty: the build could not get it
extern const std::string_view kUplotLicense;  ///< to go with every copy

}  // namespace bgsim::cli
