/// Where results go, and which files must not be overwritten.
#pragma once

#include <string>
#include <vector>

#include "bgsim/model.hpp"

namespace bgsim::cli {

/// A file that a command reads or writes, and what it is to it: "it is the model itself", "-o".
struct NamedFile {
  std::string path, role;
};

/// What a model read: itself, its submodels, its data files, the references of its scenes.
std::vector<NamedFile> files_of(const Model& model);

/// Refuses an output that is one of the files that the command reads, or another output of it, by whatever name, also
/// where only its partial file is: before any work. Terminals and /dev/null may be named several times.
/// @throws UsageError
/// @note Time linear in the number of files.
void check_outputs(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs);

/// @p name as a file name in the working folder: "/", what has no shape, and a dot or hyphen at its head become "_"; of
/// one beyond 200 bytes the beginning and a checksum.
std::string file_name(const std::string& name);

}  // namespace bgsim::cli
