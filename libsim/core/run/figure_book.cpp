// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/figure_book.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "base/error.hpp"
#include "base/text.hpp"

namespace cas::sim {

namespace {

constexpr std::size_t kMostFigureNameBytes = 48;

/// Length of the UTF-8 character that `text` begins with; 0 when there is none. Overlong forms,
/// surrogates and control characters are none.
std::size_t character_bytes(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  if (lead < 0x80) return lead < 0x20 || lead == 0x7F ? 0 : 1;
  const std::size_t size = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < size) return 0;
  unsigned code = lead & (0xFFU >> (size + 1));
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
    code = code << 6U | (byte(i) & 0x3FU);
  }
  constexpr std::array<unsigned, 5> kLeast{0, 0, 0xA0, 0x800, 0x10000};  // C1 controls are below
  const bool noncharacter = (code & 0xFFFEU) == 0xFFFEU || (code >= 0xFDD0 && code <= 0xFDEF);
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  return code < kLeast[size] || code > 0x10FFFF || surrogate || noncharacter ? 0 : size;
}

bool is_shown(std::string_view text) {
  if (text.size() > kMostFigureNameBytes) return false;
  while (!text.empty()) {
    const std::size_t size = character_bytes(text);
    if (size == 0) return false;
    text.remove_prefix(size);
  }
  return true;
}

/// Only text that is_shown() accepts gets here.
std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

/// The shortest text that is read as the same number; "null" for a non-finite value, which JSON
/// lacks.
std::string number(double value) {
  if (!std::isfinite(value)) return "null";
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

}  // namespace

FigureRecord::FigureRecord(FigureSpec spec) : spec_(std::move(spec)) {
  if (spec_.kind == FigureKind::kSeries) points_.reserve(kMostPoints);
}

void FigureRecord::add(const FigureSample& sample) {
  if (!std::isfinite(sample.value)) {
    ++not_finite_;
    return;
  }
  last_ = sample.value;
  least_ = samples_ == 0 ? last_ : std::min(least_, last_);
  greatest_ = samples_ == 0 ? last_ : std::max(greatest_, last_);
  sum_ += last_;
  ++samples_;
  if (spec_.kind == FigureKind::kScalar) return;
  if (!points_.empty() && sample.time < points_.back().first + period_) return;
  if (points_.size() == kMostPoints) {
    for (std::size_t i = 0; 2 * i < points_.size(); ++i) points_[i] = points_[2 * i];
    points_.resize(points_.size() / 2);
    period_ *= 2;
  }
  points_.emplace_back(sample.time, sample.value);
}

void FigureRecord::reset() {
  samples_ = not_finite_ = 0;
  least_ = greatest_ = sum_ = last_ = 0;
  period_ = kPointPeriod;
  points_.clear();
}

std::string FigureRecord::json() const {
  const bool series = spec_.kind == FigureKind::kSeries;
  const auto value = [this](double v) { return samples_ == 0 ? "null" : number(v); };
  std::string text;
  const auto field = [&text](std::string_view key, const std::string& written) {
    text.append(text.empty() ? "{" : ",").append(in_quotes(key)).append(":").append(written);
  };
  field("vehicle", in_quotes(spec_.vehicle));
  field("plugin", in_quotes(spec_.plugin));
  field("name", in_quotes(spec_.name));
  field("unit", in_quotes(spec_.unit));
  field("kind", in_quotes(series ? "series" : "scalar"));
  field("samples", std::to_string(samples_));
  field("not_finite", std::to_string(not_finite_));
  field("last", value(last_));
  if (!series) return text + "}";
  field("min", value(least_));
  field("max", value(greatest_));
  field("mean", value(sum_ / static_cast<double>(std::max<std::uint64_t>(samples_, 1))));
  field("points", "[" + base::joined(points_, ",", [](const auto& point) {
                    return "[" + number(base::to_seconds(point.first)) + "," +
                           number(point.second) + "]";
                  }) + "]");
  return text + "}";
}

Publisher<FigureSample> FigureBook::add(TopicBus& bus, FigureSpec spec) {
  if (spec.name.empty() || !is_shown(spec.name)) {
    throw base::ConfigError(
        "the name of a figure has 1 to 48 bytes of UTF-8 without control characters");
  }
  if (!is_shown(spec.unit)) {
    throw base::ConfigError("the unit of figure '" + spec.name +
                            "' has 0 to 48 bytes of UTF-8 without control characters");
  }
  const auto of_plugin = std::ranges::count_if(records_, [&](const auto& record) {
    return record->spec().vehicle == spec.vehicle && record->spec().plugin == spec.plugin;
  });
  if (static_cast<std::size_t>(of_plugin) == kMostOfAPlugin) {
    throw base::ConfigError("a plugin has at most " + std::to_string(kMostOfAPlugin) + " figures");
  }
  const std::string topic = spec.vehicle + "/figure/" + spec.plugin + "/" + spec.name;
  Publisher<FigureSample> publisher = bus.advertise<FigureSample>(topic);
  FigureRecord* record =
      records_.emplace_back(std::make_unique<FigureRecord>(std::move(spec))).get();
  subscriptions_.push_back(bus.subscribe<FigureSample>(
      topic, [record](const FigureSample& sample) { record->add(sample); }));
  return publisher;
}

void FigureBook::reset() {
  for (const auto& record : records_) record->reset();
}

std::string FigureBook::json() const {
  return "{\"schema\":1,\"figures\":[" +
         base::joined(records_, ",\n", [](const auto& record) { return record->json(); }) + "]}\n";
}

}  // namespace cas::sim
