// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/parser/diagnostics.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace cas::mav::xml {

void Diagnostics::error(Position position, std::string text) {
  ++error_count_;
  add(Severity::kError, position, std::move(text));
}

void Diagnostics::warning(Position position, std::string text) {
  ++warning_count_;
  add(Severity::kWarning, position, std::move(text));
}

void Diagnostics::add(Severity severity, Position position, std::string text) {
  const auto same_kind = severity == Severity::kError ? error_count_ : warning_count_;
  if (same_kind <= kMaxKept) diagnostics_.push_back({severity, position, std::move(text)});
}

std::uint32_t Diagnostics::add_file(SourceFile file) {
  files_.push_back(std::move(file));
  return static_cast<std::uint32_t>(files_.size() - 1);
}

std::string Diagnostics::describe(Position position) const {
  const auto& path = position.file < files_.size() ? files_[position.file].path : std::string("?");
  return path + ':' + std::to_string(position.line) + ':' + std::to_string(position.column);
}

std::string Diagnostics::render() const {
  std::string out;
  auto last_file = static_cast<std::uint32_t>(-1);
  for (const auto& diagnostic : diagnostics_) {
    // Like a compiler: the chain stands once above a run of diagnostics of one file.
    auto file = diagnostic.position.file;
    if (file != last_file) {
      last_file = file;
      const char* lead = "in file included from ";
      while (file < files_.size() && files_[file].included) {
        out += lead + describe(files_[file].included_at) + '\n';
        lead = "                 from ";
        file = files_[file].included_at.file;
      }
    }
    out += describe(diagnostic.position);
    out += diagnostic.severity == Severity::kError ? ": error: " : ": warning: ";
    out += diagnostic.text + '\n';
  }
  if (error_count_ > kMaxKept) {
    out += std::to_string(error_count_ - kMaxKept) + " more errors are not shown\n";
  }
  return out;
}

namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    auto diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const auto replace = diagonal + (a[i] == b[j] ? 0U : 1U);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replace, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string_view nearest(std::string_view word, const std::vector<std::string_view>& candidates) {
  constexpr std::size_t kLongestWord = 128;
  if (word.empty() || word.size() > kLongestWord) return {};
  std::string_view best;
  auto best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const auto candidate : candidates) {
    if (candidate.size() > word.size() + best_distance) continue;
    const auto distance = edit_distance(word, candidate);
    if (distance < best_distance && distance < candidate.size()) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

std::string suggestion(std::string_view word, const std::vector<std::string_view>& candidates) {
  const auto best = nearest(word, candidates);
  return best.empty() ? std::string() : "; did you mean " + std::string(best) + '?';
}

}  // namespace cas::mav::xml
