// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/obj.hpp"

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
      : rest_(base::without_byte_order_mark(bytes)), file_(file), options_(options) {}

  TriangleMesh run() {
    while (next_line()) take_line();
    if (last_named_ > mesh_.vertices.size()) {
      line_ = last_named_line_;
      fail_index(std::to_string(last_named_));
    }
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
    } else if (!word.empty() && std::ranges::find(kWithoutSurface, word) == kWithoutSurface.end() &&
               unknown_.size() < kNamed && unknown_.emplace(word.substr(0, 20)).second) {
      options_.warn(place() + ": '" + std::string(word.substr(0, 20)) +
                    "' is left out: of an OBJ file the faces are read");
    }
  }

  void take_vertex() {
    std::vector<double> v;  // x y z, then a weight or a colour
    if (const auto word = base::read_numbers(words_, v)) fail(base::no_number(*word));
    if (v.size() < 3) fail("a vertex has three numbers, this one " + std::to_string(v.size()));
    mesh_.vertices.emplace_back(v[0], v[1], v[2]);
  }

  void take_face() {
    std::vector<std::uint32_t> face;
    for (auto word = base::next_word(words_); !word.empty(); word = base::next_word(words_)) {
      face.push_back(index_of(word));
    }
    if (face.size() < 3 && !std::exchange(has_thin_faces_, true)) {
      options_.warn(place() + ": faces of fewer than three corners are left out");
    }
    for (std::size_t i = 2; i < face.size(); ++i) {
      mesh_.triangles.push_back({face[0], face[i - 1], face[i]});
    }
    if (mesh_.triangles.size() > kMostTriangles) {
      fail("here the mesh grows beyond " + std::to_string(kMostTriangles) + " triangles");
    }
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

  std::string place() const { return file_ + ":" + std::to_string(line_); }
  [[noreturn]] void fail(const std::string& sentence) const {
    throw base::ConfigError(place() + ": " + sentence);
  }
  [[noreturn]] void fail_index(std::string_view word) const {
    fail("face names no vertex: " + std::string(word.substr(0, 40)));
  }

  static constexpr std::int64_t kMostVertices = UINT32_MAX;
  static constexpr std::size_t kNamed = 3;  // unknown elements

  std::string_view rest_;
  const std::string& file_;
  const MeshOptions& options_;
  std::string text_;            // of this line
  std::string_view words_;      // of text_, still to be read
  std::size_t line_ = 1;        // first of text_
  std::size_t lines_ = 0;       // of text_
  std::size_t last_named_ = 0;  // largest number of a vertex that a face names, from 1
  std::size_t last_named_line_ = 0;
  std::set<std::string> unknown_;
  bool has_thin_faces_ = false;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh parse_obj(std::string_view bytes, const std::string& file,
                       const MeshOptions& options) {
  return ObjReader(bytes, file, options).run();
}

}  // namespace cas::sim
