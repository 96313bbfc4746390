// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/sdf_refusal.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <memory>
#include <string>

#include "base/config/xml_tree.hpp"
#include "base/error.hpp"
#include "base/read_file.hpp"

namespace cas::sim {

using base::XmlElement;

namespace {

namespace fs = std::filesystem;

/// Why an included file cannot be read: libsdformat keeps that to itself.
/// @param complaint  "Unable to read file[PATH]"
std::string reason_in(const std::string& complaint) {
  const std::size_t begin = complaint.find('[') + 1;
  const std::string file = complaint.substr(begin, complaint.rfind(']') - begin);
  try {
    base::parse_xml(base::read_file(file).value_or(""), file);
  } catch (const base::ConfigError& error) {
    return error.what();
  }
  const auto description = std::make_shared<sdf::SDF>();
  sdf::init(description);
  sdf::Errors errors;
  sdf::readFile(file, description, errors);
  for (const sdf::Error& error : errors) {
    if (error.LineNumber() && error.Code() != sdf::ErrorCode::URI_LOOKUP) {
      return fmt::format("{}:{}: {}", file, *error.LineNumber(), error.Message());
    }
  }
  return file + " is no model";
}

/// The first complaints with their lines.
std::string joined(const sdf::Errors& errors) {
  constexpr std::size_t kNamed = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(errors.size(), kNamed); ++i) {
    const auto line = errors[i].LineNumber();
    text +=
        (i == 0 ? "" : "; ") + (line ? fmt::format("line {}: ", *line) : "") + errors[i].Message();
    if (errors[i].Code() == sdf::ErrorCode::FILE_READ) {
      text += " (" + reason_in(errors[i].Message()) + ")";
    }
  }
  return text.empty() ? "it has no <world>" : text;
}

constexpr const char* kMendIt =
    "; mend that place: a world is <sdf version='1.9'><world name='w'> ... </world></sdf>, as in "
    "config/worlds/village.sdf";

/// The file as a tree. @throws base::ConfigError with the line of the error and the remedy
XmlElement parse_or_explain(const std::string& text, const fs::path& file) {
  try {
    return base::parse_xml(text, file.string());
  } catch (const base::ConfigError& error) {
    throw base::ConfigError(error.what() + std::string(kMendIt));
  }
}

}  // namespace

void refuse_sdf(const fs::path& file, const sdf::Errors& errors) {
  const std::string text = base::read_file(file).value_or("");
  const auto no_world = [&](const std::string& sentence) {
    return base::ConfigError(file.string() + ": holds no SDF world: " + sentence);
  };
  if (const auto sentence = base::template_language(text)) throw no_world(*sentence);
  const XmlElement root = parse_or_explain(text, file);
  if (root.name == "robot") {
    throw no_world("it is a URDF; a vehicle file names one, a world is an SDF file");
  }
  if (root.name == "COLLADA") {
    throw no_world("it is a COLLADA mesh; a <model> of an SDF file may name it");
  }
  if (root.name != "sdf" && root.name != "gazebo") {
    throw no_world("its outermost element is <" + root.name + ">, not <sdf>");
  }
  if (const XmlElement* const model = root.child("model")) {
    throw no_world("it is the model '" + std::string(model->attribute("name")) +
                   "' alone; write a world around it: <sdf version='1.9'><world "
                   "name='w'><include><uri>" +
                   fs::absolute(file).string() + "</uri></include></world></sdf>");
  }
  throw no_world(joined(errors) + kMendIt);
}

}  // namespace cas::sim
