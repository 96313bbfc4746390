// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/run_settings.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <exception>
#include <system_error>

#include "base/config/config.hpp"

namespace cas::hils {

namespace fs = std::filesystem;

namespace {

/// What an entry of a list is called: its name or plugin, else its place.
std::string name_in_list(const YAML::Node& element, std::size_t place) {
  if (element.IsMap()) {
    for (const char* key : {"name", "plugin"}) {
      if (element[key] && element[key].IsScalar()) return element[key].Scalar();
    }
  }
  return std::to_string(place);
}

void add_settings(const std::string& path, const YAML::Node& value,
                  std::map<std::string, std::string>& settings) {
  if (value.IsMap()) {
    for (const auto& entry : value) {
      add_settings(path + "." + entry.first.Scalar(), entry.second, settings);
    }
  } else if (value.IsSequence()) {
    for (std::size_t i = 0; i < value.size(); ++i) {
      add_settings(fmt::format("{}[{}]", path, name_in_list(value[i], i)), value[i], settings);
    }
  } else if (value.IsScalar()) {
    settings[path] = value.Scalar();
  }
}

}  // namespace

std::map<std::string, std::string> run_settings(const fs::path& folder) {
  std::map<std::string, std::string> settings;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder / "run", none)) {
    const std::string name = entry.path().stem().string();
    const bool is_read = name == "hilsim" || name.starts_with("fcu");
    if (!is_read || entry.path().extension() != ".yaml" || !entry.is_regular_file(none)) continue;
    try {
      add_settings(name, YAML::Load(base::ConfigNode::load(entry.path()).dump()), settings);
    } catch (const std::exception&) {  // the run is shown without it
    }
  }
  return settings;
}

}  // namespace cas::hils
