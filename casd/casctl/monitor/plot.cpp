// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/plot.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "casd/casctl/monitor/dot_canvas.hpp"
#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

/// Room at the left of a plot; labels are at most as wide, in exponents where they must.
constexpr std::size_t kWidestLabel = 11;

/// 1, 2 or 5 times a power of ten, not below `least`.
double round_step(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

}  // namespace

std::string Axis::label(double value) const {
  std::string text = fixed(value == 0 ? 0 : value, decimals);
  return columns(text) <= kWidestLabel ? text : fmt::format("{:.4g}", value);
}

Axis round_axis(double low, double high) {
  constexpr double kSteps = 4;        // at least, from end to end
  constexpr double kSmallest = 1e-6;  // of the values, that a float still tells apart
  const double size = std::max(std::abs(low), std::abs(high));
  const double span = std::max({high - low, size * kSmallest, 1e-12});
  const bool flat = high - low < span;
  const double step = round_step(flat && size < 1e-9 ? 1 : span / kSteps);
  Axis axis{.low = std::floor(low / step) * step,
            .high = std::ceil(high / step) * step,
            .decimals = std::clamp(static_cast<int>(-std::floor(std::log10(step) + 1e-9)), 0, 9)};
  if (axis.high - axis.low < step / 2) {
    axis.low -= step;
    axis.high += step;
  }
  return axis;
}

double plot_span_s(const std::deque<Sample>& samples, double now_s) {
  const double covered = samples.empty() ? 0 : now_s - samples.front().time_s;
  for (const double span : {10.0, 30.0, 60.0}) {
    if (covered <= span) return span;
  }
  return 120;
}

Block framed(const std::vector<std::string>& drawing, const std::string& high,
             const std::string& low, const std::string& first, const std::string& last,
             bool unicode) {
  const std::size_t room = std::max(columns(high), columns(low));
  Block block;
  for (std::size_t i = 0; i < drawing.size(); ++i) {
    const std::string label = i == 0 ? high : i + 1 == drawing.size() ? low : "";
    const char* edge = label.empty() ? (unicode ? "│" : "|") : (unicode ? "┤" : "+");
    ScreenLine line(right(label, room) + " " + edge, Style::kDim);
    block.push_back(line.add(drawing[i], Style::kGood));
  }
  const std::size_t width = drawing.empty() ? 0 : columns(drawing[0]);
  const std::size_t taken = columns(first) + columns(last);
  const std::string middle(width > taken ? width - taken : 1, ' ');
  block.emplace_back(std::string(room + 2, ' ') + first + middle + last, Style::kDim);
  return block;
}

Block plot(const std::deque<Sample>& samples, double now_s, std::size_t width, std::size_t rows,
           bool unicode) {
  constexpr double kLargest = 1e300;  // no axis has room for more, and its ends stay finite
  const double span_s = plot_span_s(samples, now_s);
  std::vector<Sample> shown;
  for (const Sample& sample : samples) {
    if (sample.time_s >= now_s - span_s && std::abs(sample.value) < kLargest) {
      shown.push_back(sample);
    }
  }
  double low = shown.empty() ? 0 : shown.front().value;
  double high = low;
  for (const Sample& sample : shown) {
    low = std::min(low, sample.value);
    high = std::max(high, sample.value);
  }
  const Axis axis = round_axis(low, high);
  const std::string high_text = axis.label(axis.high);
  const std::string low_text = axis.label(axis.low);
  const std::size_t label = std::max(columns(high_text), columns(low_text)) + 2;
  DotCanvas canvas(width - std::min(width, label), rows > 1 ? rows - 1 : 0);
  const auto x_of = [&](const Sample& sample) {
    return static_cast<int>(
        std::lround((1 - (now_s - sample.time_s) / span_s) * (canvas.width() - 1)));
  };
  const auto y_of = [&](const Sample& sample) {
    return static_cast<int>(
        std::lround((axis.high - sample.value) / (axis.high - axis.low) * (canvas.height() - 1)));
  };
  constexpr double kGap_s = 5;  // no line over a time in which nothing came
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const Sample& from =
        i > 0 && shown[i].time_s - shown[i - 1].time_s < kGap_s ? shown[i - 1] : shown[i];
    canvas.line(x_of(from), y_of(from), x_of(shown[i]), y_of(shown[i]));
  }
  return framed(canvas.lines(unicode), high_text, low_text, "-" + fixed(span_s, 0) + " s", "now",
                unicode);
}

std::string sparkline(const std::deque<Sample>& samples, std::size_t width, bool unicode) {
  constexpr const char* kBlocks[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  constexpr const char* kAscii[] = {"_", ".", "-", "~", "=", "+", "*", "#"};
  const std::size_t first = samples.size() > width ? samples.size() - width : 0;
  if (first >= samples.size()) return "";
  double low = samples[first].value;
  double high = low;
  for (std::size_t i = first; i < samples.size(); ++i) {
    low = std::min(low, samples[i].value);
    high = std::max(high, samples[i].value);
  }
  std::string text;
  for (std::size_t i = first; i < samples.size(); ++i) {
    const double span = high - low;
    const double part = span > 0 && std::isfinite(span) ? (samples[i].value - low) / span : 0;
    const auto step = static_cast<std::size_t>(std::lround(part * 7));
    text += unicode ? kBlocks[step] : kAscii[step];
  }
  return text;
}

}  // namespace cas::casctl
