// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "hils/runs/run_list.hpp"

namespace cas::hils {

/// runs.html: the runs as a table that can be sorted and filtered, and any two side by side, with
/// what differs between their configurations and figures. One file that needs no other; its links
/// lead to the reports and replays below `folder`, where the page is to lie. Without the built page
/// (runs.js) it is a plain table.
std::string runs_page(const std::filesystem::path& folder, const RunList& list);

}  // namespace cas::hils
