// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace cas::hils {

/// gzip of a text, the same bytes for the same text.
std::string gzip(std::string_view text);
/// @throws base::ConfigError unless the bytes are gzip, whole, and inflate to at most 1 GiB
void check_gzip(std::string_view bytes);
/// The inflated text. @throws base::ConfigError as check_gzip() does
std::string gunzip(std::string_view bytes);

/// The page that replays records without a server: replay.html of the built page with the records
/// in it.
///
/// @param records  gzip of replay_record(); the first is shown, the second beside it
/// @param sources  one for each record, or none: where it is from
/// @throws base::ConfigError where the page was not built, or is damaged
std::string replay_page(std::span<const std::string> records,
                        std::span<const std::filesystem::path> sources = {});

/// Whether replay_page() has a page to put records into.
bool has_page();
/// Why there is none: a sentence, with the cause that the build left.
std::string why_no_page();

/// Where a run's folder has its record.
std::filesystem::path record_file(const std::filesystem::path& out);

}  // namespace cas::hils
