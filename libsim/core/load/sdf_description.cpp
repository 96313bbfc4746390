// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/sdf_description.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <string_view>

namespace cas::sim {

namespace {

/// Elements that libsdformat may bring into a file: its conversions from older versions, and for
/// merged models.
constexpr std::array<std::string_view, 12> kBroughtIn{"angular_velocity",
                                                      "frame",
                                                      "friction",
                                                      "linear_acceleration",
                                                      "noise",
                                                      "range",
                                                      "script",
                                                      "specular",
                                                      "x",
                                                      "y",
                                                      "z",
                                                      "velocity_decay"};

bool is_kept(const sdf::Element& description, const SdfDescription::IsUsed& is_used) {
  const std::string& name = description.GetName();
  return description.GetElementDescriptionCount() == 0 || description.GetRequired() == "1" ||
         std::ranges::find(kBroughtIn, name) != kBroughtIn.end() || is_used(name);
}

/// An element's description without what is in it: Element::Clone() copies all.
sdf::ElementPtr copy_of(const sdf::Element& from) {
  auto copy = std::make_shared<sdf::Element>();
  copy->SetName(from.GetName());
  copy->SetRequired(from.GetRequired());
  copy->SetDescription(from.GetDescription());
  copy->SetCopyChildren(from.GetCopyChildren());
  copy->SetReferenceSDF(from.ReferenceSDF());
  for (std::size_t i = 0; i < from.GetAttributeCount(); ++i) {
    const sdf::ParamPtr key = from.GetAttribute(static_cast<unsigned int>(i));
    copy->AddAttribute(key->GetKey(), key->GetTypeName(), key->GetDefaultAsString(),
                       key->GetRequired(), key->GetDescription());
  }
  if (const sdf::ParamPtr value = from.GetValue()) {
    copy->AddValue(value->GetTypeName(), value->GetDefaultAsString(), value->GetRequired(),
                   value->GetMinValueAsString().value_or(""),
                   value->GetMaxValueAsString().value_or(""), value->GetDescription());
  }
  return copy;
}

sdf::ElementPtr reduced(const sdf::Element& from, const SdfDescription::IsUsed& is_used) {
  sdf::ElementPtr copy = copy_of(from);
  for (std::size_t i = 0; i < from.GetElementDescriptionCount(); ++i) {
    const sdf::ElementPtr part = from.GetElementDescription(static_cast<unsigned int>(i));
    if (!is_kept(*part, is_used)) continue;
    // libsdformat asks a sensor for the element of its type, and goes on without looking.
    const bool whole = part->GetName() == "sensor";
    copy->AddElementDescription(whole ? part : reduced(*part, is_used));
  }
  return copy;
}

/// @return the elements of `description`, itself among them
std::size_t count(const sdf::Element& description, std::map<std::string, std::size_t>& sizes) {
  std::size_t all = 1;
  for (std::size_t i = 0; i < description.GetElementDescriptionCount(); ++i) {
    all += count(*description.GetElementDescription(static_cast<unsigned int>(i)), sizes);
  }
  std::size_t& largest = sizes[description.GetName()];
  largest = std::max(largest, all);
  return all;
}

}  // namespace

SdfDescription::SdfDescription() : sdf_(std::make_shared<sdf::SDF>()) {
  sdf::init(sdf_);
  count(*sdf_->Root(), sizes_);
}

SdfDescription::SdfDescription(const SdfDescription& whole, const IsUsed& is_used)
    : sdf_(std::make_shared<sdf::SDF>()) {
  sdf_->Root(reduced(*whole.sdf_->Root(), is_used));
  count(*sdf_->Root(), sizes_);
}

std::size_t SdfDescription::kilobytes_of(const std::string& element) const {
  // Measured with libsdformat 12.3.
  constexpr std::size_t kElement_kB = 3;
  constexpr double kDescription_kB = 1.3;
  const auto found = sizes_.find(element);
  const std::size_t size = found == sizes_.end() ? 1 : found->second;
  return kElement_kB + static_cast<std::size_t>(kDescription_kB * static_cast<double>(size));
}

}  // namespace cas::sim
