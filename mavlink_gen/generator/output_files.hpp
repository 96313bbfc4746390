// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace cas::mav::gen {

/// Generated files: path relative to the output folder -> text.
using Files = std::map<std::string, std::string>;

/// Writes the files. A file with the same text is not touched; the others are written beside their
/// place and renamed into it, so no reader sees half a file.
/// @return an error sentence; nullopt: all are written
std::optional<std::string> write_files(const std::filesystem::path& folder, const Files& files);

/// The headers below generated code, by the names it includes them by. The build puts their text
/// into the program, so one that was copied somewhere alone still has them.
const Files& runtime_files();

}  // namespace cas::mav::gen
