// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/parser/diagnostics.hpp"

#include <utility>

#include "base/suggestion.hpp"

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

std::string Diagnostics::suggest(Severity severity, std::string_view word,
                                 const std::vector<std::string_view>& candidates) const {
  const auto same_kind = severity == Severity::kError ? error_count_ : warning_count_;
  return same_kind < kMaxKept ? suggestion(word, candidates) : std::string();
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
    // Like a compiler: the include chain is printed once above consecutive diagnostics of one file.
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
  if (warning_count_ > kMaxKept) {
    out += std::to_string(warning_count_ - kMaxKept) + " more warnings are not shown\n";
  }
  return out;
}

std::string suggestion(std::string_view word, const std::vector<std::string_view>& candidates) {
  const std::string best = base::nearest_word(word, candidates);
  return best.empty() ? std::string() : "; did you mean " + best + '?';
}

}  // namespace cas::mav::xml
