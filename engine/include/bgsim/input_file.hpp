/// Files that are read: what a user or a model may name, without waiting for ever and without filling the memory.
#pragma once

#include <string>
#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

/// Who named a file: what a user names may be a pipe or a terminal, what a model names is a regular file.
enum class NamedBy : bool { user, model };

/// A file's bytes, or what is wrong with it ("there is no such file").
struct InputText {
  std::string text, fault;
};

/// Reads a file whole. What it is, is known before it is opened: a folder, a device, a socket and, where a model names
/// it, a pipe are refused, and nothing is waited for. Files of 4 GiB and more are refused; so is more than 1 GiB from a
/// pipe, or from a file that states no length (as those of /proc).
/// @param first  if not '\0': reading from a pipe stops early at a first character, blanks aside, that is another.
InputText read_input(const std::string& path, NamedBy by, char first = '\0');

/// The folder in which the files that @p path names are looked for: the file's own, and the working folder for what has
/// none (/dev/stdin, /dev/fd/63).
std::string folder_of(const std::string& path);

/// Whether @p path lies below one of @p roots, links followed on both sides. True for a path that cannot be followed
/// (no permission, a circle of links): opening it tells why.
bool is_below(const std::string& path, const std::vector<std::string>& roots);

/// @p options with the folder of the model @p path as the first of the roots, and its search path behind them.
ReadOptions with_folder_of(const std::string& path, const ReadOptions& options);

/// Whether a model read with @p options may name the file @p path.
inline bool may_be_named(const std::string& path, const ReadOptions& options) {
  return options.allow_outside || is_below(path, options.roots);
}

/// Refuses a reference that the model read from @p path may not name: before read_reference.
/// @throws ModelError BG170
void check_reference(const Model& model, const std::string& path, const Reference& reference,
                     const ReadOptions& options);

inline constexpr const char* kOutsideRule =
    "files named by a model lie in its folder or below, after links are resolved: a model from another person reads "
    "nothing else";
inline constexpr const char* kOutsideHelp = "move the file there, or run with --allow-outside if you trust the model";

}  // namespace bgsim
