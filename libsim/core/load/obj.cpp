// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/obj.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <utility>

#include "base/byte_order_mark.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cas::sim {

namespace {

/// What has no surface that could be touched.
constexpr std::array<std::string_view, 16> kWithoutSurface{
    "vn",     "vt",     "vp", "g", "o",      "s",   "mg",         "usemtl",
    "mtllib", "usemap", "l",  "p", "maplib", "lod", "shadow_obj", "trace_obj"};

class ObjReader {
 public:
  ObjReader(std::string_view bytes, const std::string& file, const MeshOptions& options)
      : rest_(base::without_byte_order_mark(bytes)),
        file_(file),
        options_(options),
        ends_a_line_(bytes.ends_with('\n') || bytes.ends_with('\r')) {}

  TriangleMesh run() {
    while (next_line()) take_line();
    ends_a_line_ = true;  // what follows is no fault of the last line
    if (last_named_ > mesh_.vertices.size()) {
      line_ = last_named_line_;
      fail_index(std::to_string(last_named_));
    }
    if (!names_others_) require_faces();
    return std::move(mesh_);
  }

 private:
  /// The next line, with those that it is continued on by a backslash, and without its comment.
  bool next_line() {
    if (rest_.empty()) return false;
    line_ += std::exchange(lines_, 0);
    text_.clear();
    for (bool goes_on = true; goes_on && !rest_.empty();) {
      std::string_view piece = rest_.substr(0, rest_.find_first_of("\r\n"));
      rest_.remove_prefix(piece.size());
      rest_.remove_prefix(rest_.starts_with("\r\n") ? 2 : std::min<std::size_t>(1, rest_.size()));
      ++lines_;
      piece = piece.substr(0, piece.find('#'));
      while (piece.ends_with('\t') || piece.ends_with(' ')) piece.remove_suffix(1);
      goes_on = piece.ends_with('\\');
      if (goes_on) piece.remove_suffix(1);
      text_ += piece;
      text_ += ' ';
    }
    words_ = text_;
    return true;
  }

  void take_line() {
    const std::string_view word = base::next_word(words_);
    if (word == "v") {
      take_vertex();
    } else if (word == "f" || word == "fo") {
      take_face();
    } else if (!word.empty()) {
      const bool known = std::ranges::find(kWithoutSurface, word) != kWithoutSurface.end();
      names_others_ = names_others_ || !known || word == "l" || word == "p";
      if (known || unknown_.size() == kNamed || !unknown_.emplace(word.substr(0, 20)).second)
        return;
      options_.warn(place() + ": '" + std::string(word.substr(0, 20)) +
                    "' is left out: of an OBJ file the faces are read");
    }
  }

  void take_vertex() {
    Eigen::Vector3d v;
    for (int i = 0; i < 3; ++i) {
      const std::string_view word = base::next_word(words_);
      if (word.empty()) fail(fmt::format("a vertex has three numbers, this one {}", i));
      const auto value = base::number_of<double>(word);
      if (!value) fail(base::no_number(word));
      v[i] = *value;
    }
    mesh_.vertices.push_back(v);  // behind it: a weight, or a colour, even of 'nan'
    if (mesh_.vertices.size() > 3 * kMostTriangles) {
      fail(fmt::format("here the mesh grows beyond {} vertices", 3 * kMostTriangles));
    }
  }

  void take_face() {
    std::vector<std::uint32_t> face;
    for (auto word = base::next_word(words_); !word.empty(); word = base::next_word(words_)) {
      face.push_back(index_of(word));
      if (mesh_.triangles.size() + face.size() > kMostTriangles + 2) {
        fail(fmt::format("here the mesh grows beyond {} triangles", kMostTriangles));
      }
    }
    if (face.size() < 3 && (is_cut_here() || !std::exchange(has_thin_faces_, true))) {
      options_.warn(place() + ": faces of fewer than three corners are left out" + cut_hint());
    }
    for (std::size_t i = 2; i < face.size(); ++i) {
      mesh_.triangles.push_back({face[0], face[i - 1], face[i]});
    }
  }

  /// The faces come last in a file, and are what it lacks when it is cut.
  void require_faces() const {
    if (mesh_.vertices.empty()) return;
    if (mesh_.triangles.empty()) fail("the file ends without a face: is it cut?");
    std::vector<bool> named(mesh_.vertices.size());
    for (const auto& triangle : mesh_.triangles) {
      for (const std::uint32_t corner : triangle) named[corner] = true;
    }
    const auto unnamed = std::ranges::count(named, false);
    if (unnamed == 0) return;
    const auto first = std::ranges::find(named, false) - named.begin() + 1;
    options_.warn(
        fmt::format("{}: vertices of no face are left out: {} (the first is vertex {}); "
                    "is the file cut here?",
                    place(), unnamed, first));
  }

  /// "7", "7/1/3", "7//3" or "-1": the vertex's number, counted from 1 or, of those so far, from
  /// the end. It may come later in the file.
  std::uint32_t index_of(std::string_view word) {
    const std::string_view digits = word.substr(0, word.find('/'));
    const auto number = base::number_of<std::int64_t>(digits);
    for (std::string_view rest = word.substr(digits.size()); !rest.empty();) {
      rest.remove_prefix(1);  // the slash
      const std::string_view part = rest.substr(0, rest.find('/'));
      rest.remove_prefix(part.size());
      if (!part.empty() && !base::number_of<std::int64_t>(part)) fail_index(word);
    }
    if (!number || *number == 0) fail_index(word);
    const auto so_far = static_cast<std::int64_t>(mesh_.vertices.size());
    const std::int64_t index = *number < 0 ? so_far + *number : *number - 1;
    if (index < 0 || index >= kMostVertices) fail_index(word);
    if (static_cast<std::size_t>(index) >= last_named_) {
      last_named_ = static_cast<std::size_t>(index) + 1;
      last_named_line_ = line_;
    }
    return static_cast<std::uint32_t>(index);
  }

  /// Whether the line that is being read ends with the file, and without an end of its own.
  bool is_cut_here() const { return rest_.empty() && !ends_a_line_; }
  std::string cut_hint() const {
    return is_cut_here() ? "; the file ends within this line: is it cut?" : "";
  }
  std::string place() const { return fmt::format("{}:{}", file_, line_); }
  [[noreturn]] void fail(const std::string& sentence) const {
    throw base::ConfigError(place() + ": " + sentence + cut_hint());
  }
  [[noreturn]] void fail_index(std::string_view word) const {
    fail("face names no vertex: " + std::string(word.substr(0, 40)));
  }

  static constexpr std::int64_t kMostVertices = UINT32_MAX;
  static constexpr std::size_t kNamed = 3;  // unknown elements

  std::string_view rest_;
  const std::string& file_;
  const MeshOptions& options_;
  bool ends_a_line_;            // the file
  std::string text_;            // of this line
  std::string_view words_;      // of text_, still to be read
  std::size_t line_ = 1;        // first of text_
  std::size_t lines_ = 0;       // of text_
  std::size_t last_named_ = 0;  // largest number of a vertex that a face names, from 1
  std::size_t last_named_line_ = 0;
  std::set<std::string> unknown_;
  bool has_thin_faces_ = false;
  bool names_others_ = false;  // vertices, by lines, points or unknown elements
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh parse_obj(std::string_view bytes, const std::string& file,
                       const MeshOptions& options) {
  return ObjReader(bytes, file, options).run();
}

}  // namespace cas::sim
