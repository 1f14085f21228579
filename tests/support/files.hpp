/// Whole files as text.
#pragma once

#include <filesystem>
#include <string>

namespace bgsim::test {

/// The file's bytes; empty if there is no such file.
std::string file_text(const std::filesystem::path& path);
void write_file(const std::filesystem::path& path, const std::string& text);

/// Whether goldens are to be written instead of compared: BGSIM_UPDATE_GOLDEN is in the environment.
bool update_goldens();

}  // namespace bgsim::test
