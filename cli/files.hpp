/// Where results go: named files or standard output, with every failure to write told by name.
#pragma once

#include <functional>
#include <ostream>
#include <string>

namespace bgsim::cli {

/// Refuses a place that cannot be written to, or that is one of @p inputs, before a long run rather than after it.
/// @throws UsageError
void check_writable(const std::string& path, const std::string& input);

/// Lets @p write fill the file @p path ("-": standard output), which is replaced when all is written (OutputFile).
/// @throws UsageError with the system's reason: no such folder, no permission, disk full, closed pipe.
void write_file(const std::string& path, const std::function<void(std::ostream&)>& write);

/// @p name as a file name in the working folder: "/", what has no shape, and a dot or hyphen at its head become "_"; of
/// one beyond 200 bytes the beginning and a checksum.
std::string file_name(const std::string& name);

}  // namespace bgsim::cli
