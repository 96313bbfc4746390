// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/model_form.hpp"

#include <string_view>
#include <vector>

namespace cas::base {
namespace {

std::string_view text(const XmlElement& form, FormValues values, std::string_view key) {
  const std::string_view found =
      values == FormValues::kElements ? form.child_text(key) : form.attribute(key);
  if (!found.empty()) return found;
  if (values == FormValues::kElements) form.need(key).fail("<" + std::string(key) + "> is empty");
  form.fail("<" + form.name + "> has no attribute '" + std::string(key) + "'");
}

std::vector<double> numbers(const XmlElement& form, FormValues values, std::string_view key,
                            std::size_t count) {
  if (values == FormValues::kElements) return form.need(key).numbers(count);
  text(form, values, key);
  return form.numbers(key, count);
}

bool has(const XmlElement& form, FormValues values, std::string_view key) {
  return values == FormValues::kElements ? form.child(key) != nullptr
                                         : form.attributes.contains(key);
}

}  // namespace

void take_model_form(const XmlElement& form, FormValues values, ModelShape& shape) {
  using Form = ModelShape::Form;
  const auto vector = [&](std::string_view key) {
    return Eigen::Vector3d(numbers(form, values, key, 3).data());
  };
  const auto number = [&](std::string_view key) { return numbers(form, values, key, 1)[0]; };
  shape.word = form.name;
  shape.place = form.place();
  if (form.name == "box") {
    shape.form = Form::kBox;
    shape.size = vector("size");
  } else if (form.name == "sphere") {
    shape.form = Form::kSphere;
    shape.size.setConstant(number("radius"));
  } else if (form.name == "cylinder") {
    shape.form = Form::kCylinder;
    const double radius = number("radius");
    shape.size = {radius, radius, number("length")};
  } else if (form.name == "mesh") {
    shape.form = Form::kMesh;
    shape.uri = text(form, values, values == FormValues::kElements ? "uri" : "filename");
    shape.size = has(form, values, "scale") ? vector("scale") : Eigen::Vector3d::Ones();
  }
}

}  // namespace cas::base
