// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "hils/judgement.hpp"
#include "hils/measurement.hpp"

namespace cas::hils {

/// Verdict and figures for people: tables as [HILS] Tables 4 and 5, with its rows below ours.
std::string text_report(const Measurement& figures, const Verdict& verdict);

/// The same figures for programs, as JSON (docs/config.md names the fields).
std::string summary_json(const Measurement& figures, const Verdict& verdict);

/// Writes a text file beside its place and renames it. @throws base::ConfigError
void write_text(const std::filesystem::path& file, const std::string& text);

}  // namespace cas::hils
