// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

namespace cas::hils {

namespace {

constexpr double kWidth = 720;
constexpr double kHeight = 260;
constexpr double kLeft = 64;
constexpr double kRight = 14;
constexpr double kTop = 46;
constexpr double kBottom = 42;
constexpr std::array<std::string_view, 8> kColors{"#0b6bcb", "#d9480f", "#2b8a3e", "#862e9c",
                                                  "#e0a100", "#0c8599", "#a61e4d", "#495057"};

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void make_wide() {
    if (low > high) *this = {0, 1};
    if (high - low < 1e-12 * std::max(1.0, std::abs(high))) {
      low -= 0.5;
      high += 0.5;
    }
  }
};

/// 1, 2 or 5 times a power of ten: about `count` of them fit into the range.
double tick_step(Range range, int count) {
  const double rough = (range.high - range.low) / count;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) return factor * power;
  }
  return 10 * power;
}

std::vector<double> ticks(Range range, bool log, int count) {
  std::vector<double> values;
  if (log) {
    for (double decade = std::floor(range.low); decade <= range.high + 1e-9; decade += 1) {
      if (decade >= range.low - 1e-9) values.push_back(decade);
    }
    return values;
  }
  const double step = tick_step(range, count);
  for (double index = std::ceil(range.low / step); index * step <= range.high * (1 + 1e-12) + 1e-15;
       index += 1) {
    values.push_back(index * step);
  }
  return values;
}

class Canvas {
 public:
  explicit Canvas(const Plot& plot) : plot_(plot) {
    for (const Series& series : plot.series) {
      for (const auto& [x, y] : series.points) {
        x_.add(to_axis(x));
        y_.add(y);
      }
    }
    if (plot.from_zero) y_.add(0);
    x_.make_wide();
    y_.make_wide();
    const double margin = 0.04 * (y_.high - y_.low);
    if (!plot.from_zero || y_.low < 0) y_.low -= margin;
    y_.high += margin;
  }

  std::string draw() {
    open();
    shade();
    axes();
    for (std::size_t i = 0; i < plot_.series.size(); ++i) curve(plot_.series[i], i);
    marks();
    legend();
    return out_ + "</svg>\n";
  }

 private:
  double to_axis(double x) const { return plot_.log_x ? std::log10(x) : x; }
  double px(double axis_x) const {
    return kLeft + (axis_x - x_.low) / (x_.high - x_.low) * (kWidth - kLeft - kRight);
  }
  double py(double y) const {
    return kHeight - kBottom - (y - y_.low) / (y_.high - y_.low) * (kHeight - kTop - kBottom);
  }

  void open() {
    out_ += fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:g} {:g}\" role=\"img\" "
        "font-family=\"system-ui, sans-serif\" font-size=\"11\" fill=\"#343a40\">\n"
        "<title>{}</title>\n<rect width=\"{:g}\" height=\"{:g}\" fill=\"#fff\"/>\n"
        "<text x=\"{:g}\" y=\"16\" font-size=\"13\" font-weight=\"600\">{}</text>\n",
        kWidth, kHeight, escape_xml(plot_.title), kWidth, kHeight, kLeft, escape_xml(plot_.title));
  }

  void shade() {
    const auto [begin, end] = plot_.shaded;
    if (end <= begin) return;
    out_ += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:g}\" width=\"{:.1f}\" height=\"{:g}\" "
        "fill=\"#0b6bcb\" fill-opacity=\"0.06\"/>\n",
        px(begin), kTop, px(end) - px(begin), kHeight - kTop - kBottom);
  }

  void axes() {
    for (const double y : ticks(y_, false, 5)) {
      out_ += fmt::format(
          "<path d=\"M{:g} {:.1f}H{:g}\" stroke=\"#e9ecef\"/>"
          "<text x=\"{:g}\" y=\"{:.1f}\" text-anchor=\"end\">{:.6g}</text>\n",
          kLeft, py(y), kWidth - kRight, kLeft - 6, py(y) + 4, std::abs(y) < 1e-12 ? 0.0 : y);
    }
    for (const double x : ticks(x_, plot_.log_x, 9)) {
      const double value = plot_.log_x ? std::pow(10.0, x) : x;
      out_ += fmt::format(
          "<path d=\"M{:.1f} {:g}V{:g}\" stroke=\"#e9ecef\"/>"
          "<text x=\"{:.1f}\" y=\"{:g}\" text-anchor=\"middle\">{:.6g}</text>\n",
          px(x), kTop, kHeight - kBottom, px(x), kHeight - kBottom + 15, value);
    }
    out_ += fmt::format("<path d=\"M{0:g} {1:g}V{2:g}H{3:g}\" fill=\"none\" stroke=\"#868e96\"/>\n",
                        kLeft, kTop, kHeight - kBottom, kWidth - kRight);
    out_ += fmt::format("<text x=\"{:g}\" y=\"{:g}\" text-anchor=\"middle\">{}</text>\n",
                        (kLeft + kWidth - kRight) / 2, kHeight - 8, escape_xml(plot_.x_label));
    out_ += fmt::format(
        "<text transform=\"translate(14 {:g}) rotate(-90)\" "
        "text-anchor=\"middle\">{}</text>\n",
        (kTop + kHeight - kBottom) / 2, escape_xml(plot_.y_label));
  }

  /// First, lowest, highest and last point of each pixel column.
  std::vector<std::pair<double, double>> thinned(const Series& series) const {
    std::vector<std::pair<double, double>> pixels;
    for (const auto& [x, y] : series.points) {
      if (std::isfinite(y)) pixels.emplace_back(px(to_axis(x)), py(y));
    }
    if (pixels.size() < 4 * static_cast<std::size_t>(kWidth)) return pixels;
    std::vector<std::pair<double, double>> result;
    for (std::size_t begin = 0; begin < pixels.size();) {
      std::size_t end = begin;
      while (end < pixels.size() &&
             std::floor(pixels[end].first) == std::floor(pixels[begin].first))
        ++end;
      const auto by_y = [](const auto& a, const auto& b) { return a.second < b.second; };
      const auto first = pixels.begin() + static_cast<std::ptrdiff_t>(begin);
      const auto last = pixels.begin() + static_cast<std::ptrdiff_t>(end);
      const auto [low, high] = std::minmax_element(first, last, by_y);
      result.push_back(*first);
      result.push_back(low < high ? *low : *high);
      result.push_back(low < high ? *high : *low);
      result.push_back(*(last - 1));
      begin = end;
    }
    return result;
  }

  void curve(const Series& series, std::size_t index) {
    std::string path;
    double previous_y = 0;
    for (const auto& [x, y] : thinned(series)) {
      if (path.empty()) {
        path = fmt::format("M{:.1f} {:.1f}", x, y);
      } else if (series.steps) {
        path += fmt::format("H{:.1f}V{:.1f}", x, y);
      } else {
        path += fmt::format("L{:.1f} {:.1f}", x, y);
      }
      previous_y = y;
    }
    if (series.steps && !path.empty()) path += fmt::format("V{:.1f}", previous_y);
    out_ += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.4\"{}/>\n",
                        path, kColors[index % kColors.size()],
                        series.dashed ? " stroke-dasharray=\"5 3\"" : "");
  }

  void marks() {
    for (const Mark& mark : plot_.marks) {
      const double x = px(to_axis(mark.x));
      if (!(x >= kLeft && x <= kWidth - kRight)) continue;
      out_ += fmt::format(
          "<path d=\"M{0:.1f} {1:g}V{2:g}\" stroke=\"{6}\" "
          "stroke-dasharray=\"{7}\"/><text x=\"{3:.1f}\" y=\"{4:g}\" "
          "fill=\"{6}\" font-size=\"10\">{5}</text>\n",
          x, kTop, kHeight - kBottom, x + 3, kTop + (mark.fault ? 22 : 10), escape_xml(mark.text),
          mark.fault ? "#c92a2a" : "#868e96", mark.fault ? "none" : "2 3");
    }
  }

  void legend() {
    double x = kLeft;
    for (std::size_t i = 0; i < plot_.series.size(); ++i) {
      const Series& series = plot_.series[i];
      if (series.name.empty()) continue;
      out_ += fmt::format(
          "<path d=\"M{:.0f} 30h18\" stroke=\"{}\" stroke-width=\"2\"{}/>"
          "<text x=\"{:.0f}\" y=\"34\">{}</text>\n",
          x, kColors[i % kColors.size()], series.dashed ? " stroke-dasharray=\"5 3\"" : "", x + 23,
          escape_xml(series.name));
      x += 40 + 6.3 * static_cast<double>(series.name.size());
    }
  }

  const Plot& plot_;
  Range x_;
  Range y_;
  std::string out_;
};

}  // namespace

std::string escape_xml(const std::string& text) {
  static const std::map<char, std::string_view> kEscapes{
      {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&apos;"}};
  std::string result;
  for (const char c : text) {
    const auto escape = kEscapes.find(c);
    if (escape == kEscapes.end()) {
      result += c;
    } else {
      result += escape->second;
    }
  }
  return result;
}

std::string to_svg(const Plot& plot) { return Canvas(plot).draw(); }

}  // namespace cas::hils
