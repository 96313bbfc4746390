// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/plot.hpp"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

namespace cas::hils {

namespace {

constexpr double kWidth = 720;
constexpr double kAreaHeight = 172;  ///< between the axes
constexpr double kMapHeight = 420;   ///< the same with equal scales
constexpr double kLeft = 64;
constexpr double kRight = 14;
constexpr double kBottom = 42;
constexpr double kLegendTop = 34;  ///< base line of its first row
constexpr double kLegendRow = 15;
constexpr double kMarkRow = 12;
constexpr double kLegendCharacter = 7.4;  ///< width at 13 px, which it has on a narrow page
constexpr double kMarkCharacter = 7.2;    ///< the same, of the usual words
constexpr std::array<std::string_view, 8> kColors{"#0b6bcb", "#d9480f", "#2b8a3e", "#862e9c",
                                                  "#e0a100", "#0c8599", "#a61e4d", "#495057"};
/// Colours stand in attributes, for programs that know no style sheets; this overrides them. Inside
/// HTML it holds for the whole page, hence the class.
constexpr std::string_view kDarkStyle =
    "<style>@media screen and (prefers-color-scheme:dark){"
    ".cas-plot{fill:#ced4da}.cas-plot .paper{fill:#1c2024;stroke:#1c2024}"
    ".cas-plot .grid{stroke:#343a40}.cas-plot .axis{stroke:#868e96}"
    ".cas-plot .c0{stroke:#4dabf7}.cas-plot .c1{stroke:#ff922b}.cas-plot .c2{stroke:#51cf66}"
    ".cas-plot .c3{stroke:#cc5de8}.cas-plot .c4{stroke:#ffd43b}.cas-plot .c5{stroke:#3bc9db}"
    ".cas-plot .c6{stroke:#f783ac}.cas-plot .c7{stroke:#adb5bd}.cas-plot .reference{stroke:#f1f3f5}"
    ".cas-plot .phase{stroke:#868e96}.cas-plot text.phase{fill:#adb5bd;stroke:#1c2024}"
    ".cas-plot .fault{stroke:#ff6b6b}.cas-plot text.fault{fill:#ff8787;stroke:#1c2024}"
    "}</style>\n";

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void make_wide(bool from_zero) {
    if (low > high || (from_zero && low == 0 && high == 0)) *this = {0, 1};
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

std::vector<double> decades(Range range) {
  std::vector<double> values;
  for (double decade = std::floor(range.low); decade <= range.high + 1e-9; decade += 1) {
    if (decade >= range.low - 1e-9) values.push_back(decade);
  }
  return values;
}

std::vector<double> multiples(Range range, double step) {
  std::vector<double> values;
  for (double index = std::ceil(range.low / step); index * step <= range.high * (1 + 1e-12) + 1e-15;
       index += 1) {
    values.push_back(index * step);
  }
  return values;
}

/// The value at a tick; zero has no sign.
std::string tick_text(double tick, bool log) {
  const double value = log ? std::pow(10.0, tick) : tick;
  return fmt::format("{:.6g}", std::abs(value) < 1e-12 ? 0.0 : value);
}

/// Place of a mark's text.
struct MarkText {
  double left = 0;
  double right = 0;
  std::size_t row = 0;  ///< from the top
};

class Canvas {
 public:
  explicit Canvas(const Plot& plot) : plot_(plot) {
    for (const Series& series : plot.series) {
      for (const auto& [x, y] : series.points) {
        x_.add(to_axis(x));
        y_.add(to_axis_y(y));
      }
    }
    if (plot.from_zero) y_.add(0);
    x_.make_wide(false);
    y_.make_wide(plot.from_zero);
    const double margin = 0.04 * (y_.high - y_.low);
    if (!plot.from_zero || y_.low < 0) y_.low -= margin;
    y_.high += margin;
    if (plot.equal_scales) equalise();
    place_legend();
    place_mark_texts();
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
  double to_axis_y(double y) const { return plot_.log_y ? std::log10(y) : y; }
  double area_width() const { return kWidth - kLeft - kRight; }
  double area_height() const { return plot_.equal_scales ? kMapHeight : kAreaHeight; }
  double bottom() const { return top_ + area_height(); }
  double height() const { return bottom() + kBottom; }
  double px(double axis_x) const {
    return kLeft + (axis_x - x_.low) / (x_.high - x_.low) * area_width();
  }
  double py(double y) const { return bottom() - (y - y_.low) / (y_.high - y_.low) * area_height(); }
  bool is_inside(const Mark& mark) const {
    const double x = px(to_axis(mark.x));
    return x >= kLeft && x <= kWidth - kRight;
  }

  /// Widens the axis that has room until a unit is as long in both.
  void equalise() {
    const double x_margin = 0.04 * (x_.high - x_.low);
    x_.low -= x_margin;
    x_.high += x_margin;
    const double per_pixel =
        std::max((x_.high - x_.low) / area_width(), (y_.high - y_.low) / area_height());
    const auto widen = [](Range& range, double length) {
      const double middle = (range.low + range.high) / 2;
      range = {middle - length / 2, middle + length / 2};
    };
    widen(x_, per_pixel * area_width());
    widen(y_, per_pixel * area_height());
  }

  /// Names in rows that break before the right edge.
  void place_legend() {
    double x = kLeft;
    double y = kLegendTop;
    for (const Series& series : plot_.series) {
      const double width = 40 + kLegendCharacter * static_cast<double>(series.name.size());
      if (x > kLeft && x + width - 17 > kWidth - kRight && !series.name.empty()) {
        x = kLeft;
        y += kLegendRow;
      }
      legend_.emplace_back(x, y);
      if (!series.name.empty()) x += width;
    }
    marks_top_ = y + 6;
  }

  /// Each text in the first row where it overlaps no other, within the edges.
  void place_mark_texts() {
    std::size_t rows = 0;
    for (const Mark& mark : plot_.marks) {
      MarkText place;
      if (!mark.text.empty() && is_inside(mark)) {
        const double width = kMarkCharacter * static_cast<double>(mark.text.size());
        place.left =
            std::clamp(px(to_axis(mark.x)) + 3, kLeft, std::max(kLeft, kWidth - 2 - width));
        place.right = place.left + width + 4;
        const auto overlaps = [&place](const MarkText& other) {
          return other.row == place.row && other.left < place.right && place.left < other.right;
        };
        while (std::ranges::any_of(mark_texts_, overlaps)) ++place.row;
        rows = std::max(rows, place.row + 1);
      }
      mark_texts_.push_back(place);
    }
    top_ = marks_top_ + kMarkRow * static_cast<double>(rows) + 6;
  }

  void open() {
    out_ += fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:g} {1:g}\" role=\"img\" "
        "class=\"cas-plot\" font-family=\"system-ui, sans-serif\" font-size=\"11\" "
        "fill=\"#343a40\">\n<title>{2}</title>\n{3}"
        "<rect width=\"{0:g}\" height=\"{1:g}\" fill=\"#fff\" class=\"paper\"/>\n"
        "<text x=\"{4:g}\" y=\"16\" font-size=\"13\" font-weight=\"600\">{2}</text>\n",
        kWidth, height(), escape_xml(plot_.title), kDarkStyle, kLeft);
  }

  void shade() {
    const auto [begin, end] = plot_.shaded;
    if (end <= begin) return;
    const double left = std::clamp(px(begin), kLeft, kWidth - kRight);
    const double right = std::clamp(px(end), kLeft, kWidth - kRight);
    out_ += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:g}\" width=\"{:.1f}\" height=\"{:g}\" "
        "fill=\"#0b6bcb\" fill-opacity=\"0.06\"/>\n",
        left, top_, right - left, area_height());
  }

  void axes() {
    const double y_step = plot_.equal_scales ? tick_step(x_, 9) : tick_step(y_, 5);
    for (const double y : plot_.log_y ? decades(y_) : multiples(y_, y_step)) {
      out_ += fmt::format(
          "<path d=\"M{:g} {:.1f}H{:g}\" stroke=\"#e9ecef\" class=\"grid\"/>"
          "<text x=\"{:g}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n",
          kLeft, py(y), kWidth - kRight, kLeft - 6, py(y) + 4, tick_text(y, plot_.log_y));
    }
    for (const double x : plot_.log_x ? decades(x_) : multiples(x_, tick_step(x_, 9))) {
      out_ += fmt::format(
          "<path d=\"M{:.1f} {:g}V{:g}\" stroke=\"#e9ecef\" class=\"grid\"/>"
          "<text x=\"{:.1f}\" y=\"{:g}\" text-anchor=\"middle\">{}</text>\n",
          px(x), top_, bottom(), px(x), bottom() + 15, tick_text(x, plot_.log_x));
    }
    out_ += fmt::format(
        "<path d=\"M{0:g} {1:g}V{2:g}H{3:g}\" fill=\"none\" stroke=\"#868e96\" class=\"axis\"/>\n",
        kLeft, top_, bottom(), kWidth - kRight);
    out_ += fmt::format("<text x=\"{:g}\" y=\"{:g}\" text-anchor=\"middle\">{}</text>\n",
                        (kLeft + kWidth - kRight) / 2, height() - 8, escape_xml(plot_.x_label));
    out_ += fmt::format(
        "<text transform=\"translate(14 {:g}) rotate(-90)\" "
        "text-anchor=\"middle\">{}</text>\n",
        (top_ + bottom()) / 2, escape_xml(plot_.y_label));
  }

  using Pixels = std::vector<std::pair<double, double>>;

  Pixels thinned(const Series& series) const {
    Pixels pixels;
    for (const auto& [x, y] : series.points) {
      const double axis_y = to_axis_y(y);
      if (std::isfinite(axis_y)) pixels.emplace_back(px(to_axis(x)), py(axis_y));
    }
    if (plot_.equal_scales) return thinned_by_distance(pixels);
    if (pixels.size() < 4 * static_cast<std::size_t>(kWidth)) return pixels;
    return thinned_by_column(pixels);
  }

  /// Points at least half a pixel from the one before, and the last.
  static Pixels thinned_by_distance(const Pixels& pixels) {
    constexpr double kLeastPixels = 0.5;
    Pixels result;
    for (const auto& [x, y] : pixels) {
      if (!result.empty() &&
          std::hypot(x - result.back().first, y - result.back().second) < kLeastPixels) {
        continue;
      }
      result.emplace_back(x, y);
    }
    if (!pixels.empty()) result.push_back(pixels.back());
    return result;
  }

  /// First, lowest, highest and last point of each pixel column.
  static Pixels thinned_by_column(const Pixels& pixels) {
    Pixels result;
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

  /// Attributes of a curve's line: references are dashed and of one colour, others count through.
  static std::string line_style(const Series& series, std::size_t index) {
    if (series.dashed) return "stroke=\"#212529\" class=\"reference\" stroke-dasharray=\"5 3\"";
    const std::size_t color = index % kColors.size();
    return fmt::format("stroke=\"{}\" class=\"c{}\"", kColors[color], color);
  }

  void curve(const Series& series, std::size_t index) {
    std::string
        path;  // a report has ten thousands of points: their format is parsed at compile time
    const auto end = std::back_inserter(path);
    double previous_y = 0;
    for (const auto& [x, y] : thinned(series)) {
      if (series.dots) {
        fmt::format_to(end, FMT_COMPILE("M{:.1f} {:.1f}h0"), x, y);
      } else if (path.empty()) {
        fmt::format_to(end, FMT_COMPILE("M{:.1f} {:.1f}"), x, y);
      } else if (series.steps) {
        fmt::format_to(end, FMT_COMPILE("H{:.1f}V{:.1f}"), x, y);
      } else {
        fmt::format_to(end, FMT_COMPILE("L{:.1f} {:.1f}"), x, y);
      }
      previous_y = y;
    }
    if (series.steps && !path.empty()) path += fmt::format("V{:.1f}", previous_y);
    out_ +=
        fmt::format("<path d=\"{}\" fill=\"none\" stroke-width=\"{}\" {}/>\n", path,
                    series.dots ? "7\" stroke-linecap=\"round" : "1.4", line_style(series, index));
  }

  void marks() {
    std::string texts;  // above the lines of other marks, which end behind them
    for (std::size_t i = 0; i < plot_.marks.size(); ++i) {
      const Mark& mark = plot_.marks[i];
      if (!is_inside(mark)) continue;
      const double baseline =
          marks_top_ + kMarkRow * static_cast<double>(mark_texts_[i].row + 1) - 2;
      const double x = px(to_axis(mark.x));
      const bool under_text = mark_texts_[i].left < x;  // pushed back from the right edge
      const double begin = mark.text.empty() ? top_ : under_text ? baseline + 2 : baseline - 8;
      const char* const kind = mark.fault ? "fault" : "phase";
      const char* const color = mark.fault ? "#c92a2a" : "#868e96";
      out_ += fmt::format(
          "<path d=\"M{:.1f} {:g}V{:g}\" stroke=\"{}\" class=\"{}\" stroke-dasharray=\"{}\"/>\n", x,
          begin, bottom(), color, kind, mark.fault ? "none" : "2 3");
      if (mark.text.empty()) continue;
      texts += fmt::format(
          "<text x=\"{:.1f}\" y=\"{:g}\" fill=\"{}\" class=\"{}\" font-size=\"10\" stroke=\"#fff\" "
          "stroke-width=\"3\" paint-order=\"stroke\">{}</text>\n",
          mark_texts_[i].left, baseline, color, kind, escape_xml(mark.text));
    }
    out_ += texts;
  }

  void legend() {
    for (std::size_t i = 0; i < plot_.series.size(); ++i) {
      const Series& series = plot_.series[i];
      if (series.name.empty()) continue;
      const auto& [x, y] = legend_[i];
      out_ += fmt::format(
          "<path d=\"M{:.0f} {:g}h18\" stroke-width=\"2\" {}/>"
          "<text x=\"{:.0f}\" y=\"{:g}\">{}</text>\n",
          x, y - 4, line_style(series, i), x + 23, y, escape_xml(series.name));
    }
  }

  const Plot& plot_;
  Range x_;
  Range y_;
  double marks_top_ = 0;                           ///< of the rows of their texts
  double top_ = 0;                                 ///< of the area between the axes
  std::vector<std::pair<double, double>> legend_;  ///< where each name begins
  std::vector<MarkText> mark_texts_;               ///< of each mark
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
      const bool is_space = c == '\n' || c == '\t';
      const bool is_control = std::iscntrl(static_cast<unsigned char>(c)) != 0;
      result += is_control && !is_space ? '?' : c;  // XML has no place for it
    } else {
      result += escape->second;
    }
  }
  return result;
}

std::string to_svg(const Plot& plot) { return Canvas(plot).draw(); }

}  // namespace cas::hils
