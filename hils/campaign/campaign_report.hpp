// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "hils/campaign/matrix.hpp"
#include "hils/report/document.hpp"

namespace cas::hils {

/// The matrix, a row for each cell that is not as expected; on a page also all flights.
/// @param again  folder with the shown flights' reports and replays, row_N each; those that are
///               there are linked, from the page's own folder
Document campaign_report(const CampaignMatrix& matrix, const std::filesystem::path& again);

/// A test case for each cell.
std::string campaign_junit(const CampaignMatrix& matrix);

/// Every flight with its figures, and the verdict of each cell.
std::string campaign_json(const CampaignMatrix& matrix);
/// A line for each flight.
std::string campaign_csv(const CampaignMatrix& matrix);

}  // namespace cas::hils
