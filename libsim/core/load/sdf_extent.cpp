// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/sdf_extent.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <map>
#include <utility>

#include "base/config/xml_tree.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/read_file.hpp"

namespace cas::sim {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = 64U << 20U;
constexpr std::size_t kMostKilobytes = 4'000'000;
constexpr std::size_t kDeepest = 200;
constexpr std::size_t kDeepestInclude = 20;

/// Goes through the marks of a text.
class Marks {
 public:
  explicit Marks(std::string_view text) : text_(text), rest_(text) {}

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
        leave_element();
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
    const bool is_nested = models_ > (name == "model" ? 0 : 1);
    ++(is_nested ? extent_.nested : extent_.elements)[std::string(name)];
    const bool is_empty = skip_tag();
    if (is_empty) return;
    extent_.deepest = std::max(extent_.deepest, ++depth_);
    if (name == "model") ++models_;
    if (name == "include") in_include_ = true;
    if (!in_include_) return;
    const std::string_view text = rest_.substr(0, rest_.find('<'));
    if (name == "pose") extent_.poses.push_back({std::string(text), line()});
    if (name == "uri") extent_.includes.push_back({std::string(base::without_space(text)), line()});
  }

  void leave_element() {
    const std::string_view name = rest_.substr(2, rest_.find_first_of(" \t\r\n>", 2) - 2);
    depth_ -= depth_ > 0 ? 1 : 0;
    if (name == "include") in_include_ = false;
    if (name == "model" && models_ > 0) --models_;
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

  /// Line of the place that has been reached.
  std::size_t line() {
    const std::size_t here = text_.size() - rest_.size();
    for (; counted_ < here; ++counted_) line_ += text_[counted_] == '\n' ? 1 : 0;
    return line_;
  }

  void skip_behind(std::string_view mark) {
    const std::size_t at = rest_.find(mark);
    rest_.remove_prefix(at == rest_.npos ? rest_.size() : at + mark.size());
  }

  std::string_view text_;
  std::string_view rest_;
  std::size_t counted_ = 0;  // characters of text_ whose lines are in line_
  std::size_t line_ = 1;
  SdfExtent extent_;
  std::size_t depth_ = 0;
  std::size_t models_ = 0;  // that are open
  bool in_include_ = false;
};

/// A pose has 6 numbers, 7 with a quaternion, or none.
void require_pose(const SdfWord& pose, const fs::path& file) {
  std::vector<double> numbers;
  const auto no_number = base::read_numbers(pose.text, numbers);
  if (!no_number && (numbers.empty() || numbers.size() == 6 || numbers.size() == 7)) return;
  throw base::ConfigError(
      fmt::format("{}:{}: the <pose> of an <include> {}", file.string(), pose.line,
                  no_number ? "is no pose: " + base::no_number(*no_number)
                            : fmt::format("has {} numbers instead of 6", numbers.size())));
}

/// Sums what libsdformat takes.
class Cost {
 public:
  explicit Cost(const FindFile& find) : find_(find) {}

  /// Kilobytes for the world's file with its includes.
  std::size_t of_world(const fs::path& file) {
    const SdfExtent extent = extent_of(file, "world");
    used_ = SdfDescription(whole_, [&extent](const std::string& element) {
      return extent.elements.contains(element) || extent.nested.contains(element);
    });
    known_[file] = std::nullopt;
    return of(extent.elements, used_) + of(extent.nested, whole_) + of_includes(extent, file, 1);
  }

  /// What has been met on the way.
  SdfContents contents() && {
    return {std::move(used_), std::move(included_), std::move(missing_)};
  }

 private:
  static SdfExtent extent_of(const fs::path& file, const char* kind) {
    SdfExtent extent = sdf_extent(base::read_foreign_file(file, kind, kMostBytes));
    if (extent.deepest <= kDeepest) return extent;
    throw base::ConfigError(
        fmt::format("{}: elements lie more than {} deep", file.string(), kDeepest));
  }

  static std::size_t of(const SdfExtent::Counts& elements, const SdfDescription& description) {
    std::size_t kilobytes = 0;
    for (const auto& [name, count] : elements) kilobytes += count * description.kilobytes_of(name);
    return kilobytes;
  }

  /// @param depth  of the included files: 1 for those that the world's own file names
  std::size_t of_includes(const SdfExtent& extent, const fs::path& file, std::size_t depth) {
    std::size_t kilobytes = 0;
    for (const SdfWord& pose : extent.poses) require_pose(pose, file);
    for (const SdfWord& uri : extent.includes) {
      const std::string place = fmt::format("{}:{}", file.string(), uri.line);
      if (const auto model = model_file(uri.text, file, place)) {
        kilobytes += of_model(*model, depth);
      } else if (depth > 1) {
        missing_.push_back({"model " + uri.text, place, uri.text, file.parent_path()});
      }
      kilobytes = std::min(kilobytes, 1000 * kMostKilobytes);  // enough to be refused
    }
    return kilobytes;
  }

  /// Kilobytes for an included file with its includes.
  std::size_t of_model(const fs::path& file, std::size_t depth) {
    if (const auto known = known_.find(file); known != known_.end()) {
      if (known->second) return *known->second;
      throw base::ConfigError(file.string() + ": the model includes itself");
    }
    if (depth > kDeepestInclude) {
      throw base::ConfigError(fmt::format("{}: models include each other more than {} deep",
                                          file.string(), kDeepestInclude));
    }
    known_[file] = std::nullopt;  // until its includes are counted
    const SdfExtent extent = extent_of(file, "model");
    const std::size_t kilobytes = of(extent.elements, whole_) + of(extent.nested, whole_) +
                                  of_includes(extent, file, depth + 1);
    known_[file] = kilobytes;
    return kilobytes;
  }

  /// The file that libsdformat reads for an <include>; nullopt for one that it will miss.
  std::optional<fs::path> model_file(const std::string& uri, const fs::path& file,
                                     const std::string& place) {
    const auto found = find_(uri, file.parent_path());
    if (!found) return std::nullopt;
    const fs::path& known = included_.emplace(uri, *found).first->second;
    if (known != *found) {
      throw base::ConfigError(place + ": the <uri> " + uri + " means " + found->string() +
                              " here, and in another file " + known.string() +
                              "; name one of them by a path of its own");
    }
    std::error_code error;
    if (!fs::is_directory(*found, error)) return *found;
    const fs::path model = sdf::getModelFilePath(found->string());
    return fs::is_regular_file(model, error) ? std::optional(model) : std::nullopt;
  }

  const FindFile& find_;
  const SdfDescription whole_;
  SdfDescription used_ = whole_;
  std::map<fs::path, std::optional<std::size_t>> known_;
  std::map<std::string, fs::path> included_;
  std::vector<MissingFile> missing_;
};

}  // namespace

SdfExtent sdf_extent(std::string_view text) { return Marks(text).run(); }

SdfContents require_readable_extent(const fs::path& world, const FindFile& find) {
  Cost cost(find);
  const std::size_t kilobytes = cost.of_world(world);
  if (kilobytes <= kMostKilobytes) return std::move(cost).contents();
  throw base::ConfigError(fmt::format(
      "{}: libsdformat takes about {} GB for this world with all that it includes, and at most {} "
      "GB are read: an included or nested <model> takes 1.5 MB, a <link> of it 0.9, a <collision> "
      "0.13, one of the world's own file less; make one model, or one mesh, of many small ones",
      world.string(), kilobytes / 1'000'000, kMostKilobytes / 1'000'000));
}

}  // namespace cas::sim
