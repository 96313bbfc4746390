// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/sdf_include.hpp"

#include "base/config/model_body.hpp"
#include "base/config/model_uri.hpp"
#include "base/read_file.hpp"

namespace cas::base {
namespace {

namespace fs = std::filesystem;

/// The SDF of a model's folder: the last that its model.config names, else model.sdf.
fs::path sdf_in(const fs::path& folder) {
  const fs::path config = folder / "model.config";
  std::error_code error;
  if (!fs::exists(config, error)) return folder / "model.sdf";
  const XmlElement root =
      parse_xml(read_foreign_file(config, "model.config", kMaxModelBytes), config.string());
  std::string_view name = "model.sdf";
  for (const XmlElement& child : root.children) {
    if (child.name == "sdf") name = without_space(child.text);
  }
  return folder / name;
}

[[noreturn]] void fail_missing_file(const XmlElement& include, const fs::path& path) {
  std::error_code error;
  const fs::path form = path.string() + ".jinja";
  include.fail("the included file " + path.string() + " is not there" +
               (fs::exists(form, error)
                    ? "; " + form.string() + " is a template, which a build fills in"
                    : ""));
}

[[noreturn]] void fail_missing(const XmlElement& include, const std::string& uri,
                               const fs::path& file) {
  include.fail("the included model " + uri + " is nowhere to be found; looked for it at " +
               searched_places(uri, file.parent_path(), {}) +
               ". Name its folder in GZ_SIM_RESOURCE_PATH, or leave it out by `parts: {" +
               (include.child("name") != nullptr ? std::string(include.child_text("name"))
                                                 : fs::path(uri).filename().string()) +
               ": left_out}` in the vehicle file");
}

}  // namespace

SdfFile read_sdf_include(const XmlElement& include, const fs::path& file) {
  const std::string uri(include.child_text("uri"));
  if (uri.empty()) include.fail("<include> has no <uri>");
  const auto found = find_model_file(uri, file.parent_path(), {});
  if (!found) fail_missing(include, uri, file);
  std::error_code error;
  const fs::path path = fs::is_directory(*found, error) ? sdf_in(*found) : *found;
  if (!fs::exists(path, error)) fail_missing_file(include, path);
  const std::string text = read_foreign_file(path, "included model", kMaxModelBytes);
  if (const auto sentence = template_language(text)) {
    include.fail(path.string() + ", which is included, is no SDF: " + *sentence);
  }
  SdfFile result{parse_xml(text, path.string()), path};
  if (result.root.name != "sdf") {
    result.root.fail("is included as a model, but its outermost element is <" + result.root.name +
                     ">, not <sdf>");
  }
  return result;
}

}  // namespace cas::base
