// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cas::mav::xml {

/// A place in one of the files that were read. Lines and columns count from 1; columns count
/// characters.
struct Position {
  std::uint32_t file{};  ///< index into Diagnostics::files()
  std::uint32_t line{};
  std::uint32_t column{};
};

enum class Severity : std::uint8_t { kError, kWarning };

struct Diagnostic {
  Severity severity{};
  Position position;
  std::string text;  ///< one sentence without a full stop
};

/// A file that was read, and the <include> that brought it in.
struct SourceFile {
  std::string path;
  bool included{};
  Position included_at;
};

/// Collects errors and warnings of a dialect, in the order found.
class Diagnostics final {
 public:
  /// Errors beyond this number are counted, not kept; so are warnings.
  static constexpr std::size_t kMaxKept = 100;

  void error(Position position, std::string text);
  void warning(Position position, std::string text);

  /// suggestion() while another diagnostic of that severity would be kept, else nothing: a file
  /// full of misspelt words costs no more than a hundred searches.
  std::string suggest(Severity severity, std::string_view word,
                      const std::vector<std::string_view>& candidates) const;

  std::uint32_t add_file(SourceFile file);
  const std::vector<SourceFile>& files() const { return files_; }
  const std::vector<Diagnostic>& all() const { return diagnostics_; }
  std::size_t error_count() const { return error_count_; }
  std::size_t warning_count() const { return warning_count_; }

  /// `file:line:column`
  std::string describe(Position position) const;

  /// Every diagnostic as `file:line:column: error: text`, each led by the chain of includes that
  /// brought its file in.
  std::string render() const;

 private:
  void add(Severity severity, Position position, std::string text);

  std::vector<SourceFile> files_;
  std::vector<Diagnostic> diagnostics_;
  std::size_t error_count_{};
  std::size_t warning_count_{};
};

/// `; did you mean X?` for the nearest candidate, or an empty string.
std::string suggestion(std::string_view word, const std::vector<std::string_view>& candidates);

}  // namespace cas::mav::xml
