// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/sdf_extent.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/read_file.hpp"
#include "libsim/core/load/sdf_headers.hpp"

namespace cas::sim {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = 64U << 20U;
constexpr std::size_t kMostKilobytes = 4'000'000;
constexpr std::size_t kDeepest = 200;
constexpr std::size_t kDeepestInclude = 20;

/// Kilobytes that libsdformat 12.3 was measured to take for an element: each has a copy of the
/// description of all that may be in it.
std::size_t kilobytes_of(std::string_view element) {
  constexpr std::array<std::pair<std::string_view, std::size_t>, 8> kLarge{{{"model", 1400},
                                                                            {"actor", 1400},
                                                                            {"link", 850},
                                                                            {"sensor", 550},
                                                                            {"joint", 500},
                                                                            {"collision", 150},
                                                                            {"visual", 150},
                                                                            {"surface", 70}}};
  constexpr std::size_t kOther = 5;
  for (const auto& [name, kilobytes] : kLarge) {
    if (name == element) return kilobytes;
  }
  return kOther;
}

/// Goes through the marks of a text.
class Marks {
 public:
  explicit Marks(std::string_view text) : rest_(text) {}

  SdfExtent run() {
    for (std::size_t at = rest_.find('<'); at != rest_.npos; at = rest_.find('<')) {
      rest_.remove_prefix(at);
      if (rest_.starts_with("<!--")) {
        skip_behind("-->");
      } else if (rest_.starts_with("<![CDATA[")) {
        skip_behind("]]>");
      } else if (rest_.starts_with("<?") || rest_.starts_with("<!")) {
        skip_behind(">");
      } else if (rest_.starts_with("</")) {
        depth_ -= depth_ > 0 ? 1 : 0;
        if (rest_.starts_with("</include")) in_include_ = false;
        skip_behind(">");
      } else {
        take_element();
      }
    }
    return std::move(extent_);
  }

 private:
  void take_element() {
    const std::string_view name = rest_.substr(1, rest_.find_first_of(" \t\r\n/>", 1) - 1);
    extent_.kilobytes += kilobytes_of(name);
    const bool is_empty = skip_tag();
    if (is_empty) return;
    extent_.deepest = std::max(extent_.deepest, ++depth_);
    if (name == "include") in_include_ = true;
    if (name == "uri" && in_include_) {
      std::string_view text = rest_.substr(0, rest_.find('<'));
      extent_.includes.emplace_back(base::next_word(text));
    }
  }

  /// To behind the '>' of a tag; those within quotes do not count. @return whether it is empty
  bool skip_tag() {
    char quote = 0;
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      const char c = rest_[i];
      if (quote == 0 && c == '>') {
        const bool is_empty = rest_[i - 1] == '/';
        rest_.remove_prefix(i + 1);
        return is_empty;
      }
      if (quote == 0 && (c == '"' || c == '\'')) {
        quote = c;
      } else if (c == quote) {
        quote = 0;
      }
    }
    rest_ = {};
    return true;
  }

  void skip_behind(std::string_view mark) {
    const std::size_t at = rest_.find(mark);
    rest_.remove_prefix(at == rest_.npos ? rest_.size() : at + mark.size());
  }

  std::string_view rest_;
  SdfExtent extent_;
  std::size_t depth_ = 0;
  bool in_include_ = false;
};

class Includes {
 public:
  explicit Includes(const FindFile& find) : find_(find) {}

  /// Of a file with its includes.
  std::size_t kilobytes_of(const fs::path& file, const char* kind, std::size_t depth) {
    if (const auto known = known_.find(file); known != known_.end()) {
      if (known->second) return *known->second;
      throw base::ConfigError(file.string() + ": the model includes itself");
    }
    if (depth > kDeepestInclude) {
      throw base::ConfigError(file.string() + ": models include each other more than " +
                              std::to_string(kDeepestInclude) + " deep");
    }
    known_[file] = std::nullopt;  // until its includes are counted
    const SdfExtent extent = sdf_extent(base::read_foreign_file(file, kind, kMostBytes));
    if (extent.deepest > kDeepest) {
      throw base::ConfigError(file.string() + ": elements lie more than " +
                              std::to_string(kDeepest) + " deep");
    }
    std::size_t kilobytes = extent.kilobytes;
    for (const std::string& uri : extent.includes) {
      if (const auto model = model_file(uri)) kilobytes += kilobytes_of(*model, "model", depth + 1);
      kilobytes = std::min(kilobytes, 1000 * kMostKilobytes);  // enough to be refused
    }
    known_[file] = kilobytes;
    return kilobytes;
  }

 private:
  /// The file that libsdformat reads for an <include>; nullopt for one that it will miss.
  std::optional<fs::path> model_file(const std::string& uri) const {
    const auto found = find_(uri);
    if (!found) return std::nullopt;
    std::error_code error;
    if (!fs::is_directory(*found, error)) return *found;
    const fs::path file = sdf::getModelFilePath(found->string());
    return fs::is_regular_file(file, error) ? std::optional(file) : std::nullopt;
  }

  const FindFile& find_;
  std::map<fs::path, std::optional<std::size_t>> known_;
};

}  // namespace

SdfExtent sdf_extent(std::string_view text) { return Marks(text).run(); }

void require_readable_extent(const fs::path& world, const FindFile& find) {
  const std::size_t kilobytes = Includes(find).kilobytes_of(world, "world", 0);
  if (kilobytes <= kMostKilobytes) return;
  throw base::ConfigError(
      world.string() + ": libsdformat takes about " + std::to_string(kilobytes / 1'000'000) +
      " GB for this world with all that it includes, and at most " +
      std::to_string(kMostKilobytes / 1'000'000) +
      " GB are read: a <model> takes 1.4 MB, a <link> 0.85, a <collision> 0.15; "
      "make one model, or one mesh, of many small ones");
}

}  // namespace cas::sim
