// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/success_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>

#include "hils/report/plot.hpp"

namespace cas::hils {

namespace {

std::optional<double> number_of(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// The bin of each row by the place of its value among those that there are.
Bins by_value(const std::string& name, const std::vector<std::string>& values,
              std::vector<std::string> distinct) {
  Bins bins{.name = name, .labels = std::move(distinct), .bin_of = {}};
  for (const std::string& value : values) {
    const auto at = std::ranges::find(bins.labels, value);
    bins.bin_of.push_back(static_cast<std::size_t>(at - bins.labels.begin()));
  }
  return bins;
}

/// An end of a bin in three digits, without a power of ten where it is a few thousand.
std::string end_text(double value) {
  const double size = std::abs(value);
  return size >= 1000 && size < 1e6 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

constexpr double kLeastCellWidth = 56;
constexpr double kCharacter = 6.2;  ///< width of one at 11 px
constexpr double kCellHeight = 30;
constexpr double kLeft = 120;
constexpr double kTop = 34;
constexpr double kBottom = 52;

/// From orange (never) by grey to blue (always): the colour-blind see it, too.
std::string colour(double share) {
  constexpr std::array<std::array<double, 3>, 3> kColours{
      {{217, 72, 15}, {233, 236, 239}, {11, 107, 203}}};
  const double at = std::clamp(share, 0.0, 1.0) * 2;
  const std::size_t low = at < 1 ? 0 : 1;
  const double rest = at - static_cast<double>(low);
  std::string text = "#";
  for (std::size_t i = 0; i < 3; ++i) {
    const double value = kColours[low][i] + rest * (kColours[low + 1][i] - kColours[low][i]);
    text += fmt::format("{:02x}", std::lround(value));
  }
  return text;
}

std::string line(double x1, double y1, double x2, double y2) {
  return fmt::format("<path d=\"M{} {}L{} {}\" stroke=\"currentColor\" stroke-width=\"3\"/>", x1,
                     y1, x2, y2);
}

std::string text_at(double x, double y, const std::string& anchor, const std::string& text,
                    const std::string& fill = "currentColor") {
  return fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"{}\" fill=\"{}\">{}</text>", x, y,
                     anchor, fill, escape_xml(text));
}

/// The parts of a map, as SVG.
class MapDrawing {
 public:
  MapDrawing(const Bins& x, const Bins& y, const std::vector<ShareCell>& cells)
      : x_(x), y_(y), cells_(cells) {
    for (const std::string& label : x.labels) {
      cell_width_ = std::max(cell_width_, kCharacter * static_cast<double>(label.size() + 1));
    }
  }

  std::string head() const {
    const double width = left_of(x_.labels.size()) + 20;
    return fmt::format(
               "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-size=\"11\" "
               "font-family=\"system-ui,sans-serif\" style=\"max-width:{}px\">\n",
               width, bottom() + kBottom, 1.4 * width) +
           text_at(kLeft, 18, "start", "Stays up, %");
  }

  /// A coloured rectangle for each cell, with its share.
  std::string shares() const {
    std::string svg;
    for (std::size_t j = 0; j < y_.labels.size(); ++j) {
      for (std::size_t i = 0; i < x_.labels.size(); ++i) svg += share(i, j);
      svg += "\n";
    }
    return svg;
  }

  /// Lines between the cells that stay up and the others.
  std::string border() const {
    std::string svg;
    for (std::size_t j = 0; j < y_.labels.size(); ++j) {
      for (std::size_t i = 0; i < x_.labels.size(); ++i) {
        if (i + 1 < x_.labels.size() && ends_between(cell(i, j), cell(i + 1, j))) {
          svg += line(left_of(i + 1), top_of(j), left_of(i + 1), top_of(j) + kCellHeight);
        }
        if (j + 1 < y_.labels.size() && ends_between(cell(i, j), cell(i, j + 1))) {
          svg += line(left_of(i), top_of(j), left_of(i) + cell_width_, top_of(j));
        }
      }
    }
    return svg;
  }

  std::string labels() const {
    std::string svg;
    for (std::size_t i = 0; i < x_.labels.size(); ++i) {
      svg += text_at(left_of(i) + cell_width_ / 2, bottom() + 15, "middle", x_.labels[i]);
    }
    for (std::size_t j = 0; j < y_.labels.size(); ++j) {
      svg += text_at(kLeft - 6, top_of(j) + kCellHeight / 2 + 4, "end", y_.labels[j]);
    }
    return svg + text_at(left_of(0), bottom() + 36, "start", x_.name) +
           text_at(kLeft - 6, 18, "end", y_.name);
  }

 private:
  static bool ends_between(const ShareCell& a, const ShareCell& b) {
    return a.trials > 0 && b.trials > 0 && (a.side() == 1) != (b.side() == 1);
  }

  std::string share(std::size_t i, std::size_t j) const {
    const ShareCell& here = cell(i, j);
    const ShareInterval range = here.interval();
    const std::string fill = here.trials > 0 ? colour(here.share()) : "none";
    const std::string rect = fmt::format(
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\" "
        "stroke=\"#868e96\" stroke-width=\"0.5\"><title>{}</title></rect>",
        left_of(i), top_of(j), cell_width_, kCellHeight, fill,
        escape_xml(fmt::format("{} {}, {} {}: {} of {} stay up, 95 % interval "
                               "{:.1f} to {:.1f} %",
                               x_.name, x_.labels[i], y_.name, y_.labels[j], here.successes,
                               here.trials, range.low * 100, range.high * 100)));
    if (here.trials == 0) return rect;
    const bool dark = here.share() < 0.2 || here.share() > 0.75;
    return rect + text_at(left_of(i) + cell_width_ / 2, top_of(j) + kCellHeight / 2 + 4, "middle",
                          fmt::format("{:.0f}{}", here.share() * 100, here.side() == 0 ? " ?" : ""),
                          dark ? "#fff" : "#212529");
  }

  const ShareCell& cell(std::size_t i, std::size_t j) const {
    return cells_[j * x_.labels.size() + i];
  }
  double left_of(std::size_t i) const { return kLeft + cell_width_ * static_cast<double>(i); }
  /// The first bin of y is at the bottom, as in a plot.
  double top_of(std::size_t j) const {
    return kTop + kCellHeight * static_cast<double>(y_.labels.size() - 1 - j);
  }
  double bottom() const { return kTop + kCellHeight * static_cast<double>(y_.labels.size()); }

  const Bins& x_;
  const Bins& y_;
  const std::vector<ShareCell>& cells_;
  double cell_width_ = kLeastCellWidth;
};

}  // namespace

Bins Bins::of(const std::string& name, const std::vector<std::string>& values, bool log,
              std::size_t most) {
  std::vector<std::string> distinct;
  std::set<std::string> seen;
  bool numbers = true;
  for (const std::string& value : values) {
    if (!seen.insert(value).second) continue;
    distinct.push_back(value);
    numbers = numbers && number_of(value);
  }
  if (numbers) {
    std::ranges::sort(distinct, {}, [](const std::string& text) { return *number_of(text); });
  }
  if (!numbers || distinct.size() <= most) return by_value(name, values, std::move(distinct));

  log = log && *number_of(distinct.front()) > 0;  // a drawn value may have been rounded to 0
  const auto scale = [log](double value) { return log ? std::log(value) : value; };
  const double low = scale(*number_of(distinct.front()));
  const double width = (scale(*number_of(distinct.back())) - low) / static_cast<double>(most);
  Bins bins{.name = name, .labels = {}, .bin_of = {}};
  for (std::size_t i = 0; i < most; ++i) {
    const auto end = [&](std::size_t at) {
      const double value = low + width * static_cast<double>(at);
      return log ? std::exp(value) : value;
    };
    bins.labels.push_back(end_text(end(i)) + ".." + end_text(end(i + 1)));
  }
  for (const std::string& value : values) {
    const double at = (scale(*number_of(value)) - low) / width;
    bins.bin_of.push_back(std::min(static_cast<std::size_t>(std::max(at, 0.0)), most - 1));
  }
  return bins;
}

int ShareCell::side() const {
  if (trials == 0) return 0;
  const ShareInterval range = interval();
  if (range.low > 0.5) return 1;
  return range.high < 0.5 ? -1 : 0;
}

std::vector<ShareCell> count_by(const Bins& bins, const std::vector<std::optional<bool>>& success) {
  std::vector<ShareCell> cells(bins.labels.size());
  for (std::size_t row = 0; row < success.size(); ++row) {
    if (!success[row]) continue;
    ShareCell& cell = cells[bins.bin_of[row]];
    ++cell.trials;
    if (*success[row]) ++cell.successes;
  }
  return cells;
}

std::vector<ShareCell> count_by(const Bins& x, const Bins& y,
                                const std::vector<std::optional<bool>>& success) {
  Bins both{.name = {}, .labels = {}, .bin_of = {}};
  both.labels.resize(x.labels.size() * y.labels.size());
  for (std::size_t row = 0; row < success.size(); ++row) {
    both.bin_of.push_back(y.bin_of[row] * x.labels.size() + x.bin_of[row]);
  }
  return count_by(both, success);
}

std::string success_map(const Bins& x, const Bins& y, const std::vector<ShareCell>& cells) {
  const MapDrawing map(x, y, cells);
  return map.head() + map.shares() + map.border() + map.labels() + "</svg>";
}

}  // namespace cas::hils
