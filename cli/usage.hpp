/// What a command line that is not understood gets to read: what is meant, as far as that can be known.
#pragma once

#include <span>
#include <string>

#include "command.hpp"

namespace bgsim::cli {

/// For a first argument that is neither a command nor a file: the nearest of both, and the list of commands; empty if
/// the argument may be a file (it exists, or looks like a path).
std::string unknown_command(const std::string& first, std::span<const std::string> commands);

/// For what CLI11 refuses: options that are not there, given twice or without their value.
/// @param message  CLI11's own, which is used where nothing better is known.
std::string unknown_argument(const ::CLI::App& app, const Arguments& arguments, const std::string& message);

}  // namespace bgsim::cli
