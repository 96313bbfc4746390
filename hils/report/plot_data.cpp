// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/plot_data.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/read_file.hpp"
#include "hils/measure/column.hpp"

namespace cas::hils {

namespace {

using OrderedJson = nlohmann::ordered_json;
using Points = std::vector<std::pair<double, double>>;

constexpr std::size_t kMostPoints = 3000;  // of a curve: three for each pixel
constexpr std::string_view kClass = "class=\"plot\"";
constexpr double kFineness = 1e-5;  // of an axis

std::optional<std::filesystem::path> script_folder() {
  const auto folder = base::web_dir();
  if (!folder || !std::filesystem::exists(*folder / "report.js")) return std::nullopt;
  return folder;
}

/// The least and the greatest of each stretch of so many points.
void add_thinned(std::span<const Points::value_type> points, std::size_t stretch, Points& kept) {
  if (stretch <= 2) {
    kept.insert(kept.end(), points.begin(), points.end());
    return;
  }
  for (std::size_t begin = 0; begin < points.size(); begin += stretch) {
    const auto first = points.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last =
        points.begin() + static_cast<std::ptrdiff_t>(std::min(points.size(), begin + stretch));
    auto [low, high] = std::minmax_element(
        first, last, [](const auto& a, const auto& b) { return a.second < b.second; });
    if (high < low) std::swap(low, high);
    kept.push_back(*low);
    if (low != high) kept.push_back(*high);
  }
}

/// Drawable points, thinned; between two stretches one point without a value.
Points drawn_points(const Points& points, const Plot& plot) {
  constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
  const std::size_t stretch = (2 * points.size() + kMostPoints - 1) / kMostPoints;
  Points kept;
  Points whole;  // up to the next gap
  for (const auto& [at, value] : points) {
    if (!std::isfinite(at) || (plot.log_x && at <= 0)) continue;
    if (std::isfinite(value) && (!plot.log_y || value > 0)) {
      whole.emplace_back(at, value);
    } else if (!whole.empty()) {
      add_thinned(whole, stretch, kept);
      whole.clear();
      kept.emplace_back(at, kGap);
    }
  }
  add_thinned(whole, stretch, kept);
  return kept;
}

/// As finely as any zoom shows: a power of ten below a hundred thousandth of the range, or of the
/// smallest value where the axis has decades.
OrderedJson column(const std::vector<double>& values, bool logarithmic) {
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    most = std::max(most, std::abs(value));
    if (value != 0) least = std::min(least, std::abs(value));
  }
  const double range = logarithmic ? 100 * least : most;
  const bool known = std::isfinite(range) && range > 0;
  return column_json(values, known ? std::pow(10.0, std::floor(std::log10(range * kFineness))) : 1);
}

OrderedJson curve_json(const Series& series, const Plot& plot) {
  std::vector<double> x;
  std::vector<double> y;
  for (const auto& [at, value] : drawn_points(series.points, plot)) {
    x.push_back(at);
    y.push_back(value);
  }
  OrderedJson y_column = column(y, plot.log_y);
  for (std::size_t i = 0; i < y.size(); ++i) {
    if (!std::isfinite(y[i])) y_column["d"][i] = nullptr;
  }
  return {{"name", series.name}, {"dashed", series.dashed},    {"steps", series.steps},
          {"dots", series.dots}, {"x", column(x, plot.log_x)}, {"y", std::move(y_column)}};
}

std::string content_of(const std::filesystem::path& file) {
  std::optional<std::string> text = base::read_file(file);
  if (!text) throw base::ConfigError(file.string() + ": cannot be read");
  return *std::move(text);
}

}  // namespace

std::string plot_block(const Plot& plot) {
  if (plot.equal_scales || !script_folder()) return {};
  OrderedJson data{{"title", plot.title}, {"x_label", plot.x_label}, {"y_label", plot.y_label},
                   {"log_x", plot.log_x}, {"log_y", plot.log_y},     {"from_zero", plot.from_zero}};
  data["series"] = OrderedJson::array();
  for (const Series& series : plot.series) data["series"].push_back(curve_json(series, plot));
  data["marks"] = OrderedJson::array();
  for (const Mark& mark : plot.marks) {
    data["marks"].push_back({{"x", mark.x}, {"text", mark.text}, {"fault", mark.fault}});
  }
  const auto& [begin, end] = plot.shaded;
  if (end > begin) data["shaded"] = {begin, end};
  std::string text = data.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
  // No text of a run ends the element.
  for (std::size_t i = 0; (i = text.find('<', i)) != std::string::npos;) {
    text.replace(i, 1, "\\u003c");
  }
  return "<script type=\"application/json\" " + std::string(kClass) + ">" + text + "</script>";
}

std::string with_plot_script(std::string html) {
  const auto folder = script_folder();
  if (!folder || html.find(kClass) == std::string::npos) return html;
  const std::size_t end = std::min(html.rfind("</body>"), html.size());
  return html.insert(end, "<style>" + content_of(*folder / "report.css") + "</style>\n<script>" +
                              content_of(*folder / "report.js") + "</script>\n");
}

}  // namespace cas::hils
