// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/urdf_body.hpp"

#include <expat.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "base/number_text.hpp"

namespace cas::base {
namespace {

/// The text is no URDF that can be read here.
struct NotReadable {};

struct Link {
  int line = 0;
  std::optional<Inertial> inertial;
};

struct Joint {
  std::string parent;
  std::string child;
  bool continuous = false;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();  // of the child in the parent
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();      // the URDF's default
  int line = 0;
};

using Attributes = std::map<std::string, std::string, std::less<>>;

std::vector<double> numbers(const std::string& text) {
  std::vector<double> values;
  if (read_numbers(text, values)) throw NotReadable{};
  return values;
}

double number(const Attributes& attributes, std::string_view key) {
  const auto found = attributes.find(key);
  if (found == attributes.end()) return 0;
  const std::vector<double> values = numbers(found->second);
  if (values.size() != 1) throw NotReadable{};
  return values[0];
}

Eigen::Vector3d vector(const Attributes& attributes, std::string_view key,
                       const Eigen::Vector3d& fallback) {
  const auto found = attributes.find(key);
  if (found == attributes.end()) return fallback;
  const std::vector<double> values = numbers(found->second);
  if (values.size() != 3) throw NotReadable{};
  return {values[0], values[1], values[2]};
}

std::string text(const Attributes& attributes, std::string_view key) {
  const auto found = attributes.find(key);
  return found == attributes.end() ? std::string() : found->second;
}

/// Roll, pitch, yaw about fixed axes.
Eigen::Isometry3d pose(const Attributes& attributes) {
  const Eigen::Vector3d rpy = vector(attributes, "rpy", Eigen::Vector3d::Zero());
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = vector(attributes, "xyz", Eigen::Vector3d::Zero());
  X.linear() = (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  return X;
}

/// Links and joints of a file, by the path of open elements: "/robot/link/inertial/mass".
class Reader {
 public:
  explicit Reader(const std::string& xml) : parser_(XML_ParserCreate(nullptr), &XML_ParserFree) {
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(parser_.get(), &Reader::on_start, &Reader::on_end);
    const bool whole = XML_Parse(parser_.get(), xml.data(), static_cast<int>(xml.size()),
                                 XML_TRUE) == XML_STATUS_OK;
    if (!whole || failed_) throw NotReadable{};
  }

  std::map<std::string, Link> links;
  std::vector<Joint> joints;

 private:
  // An exception must not pass through the parser, which is C.
  static void on_start(void* user, const XML_Char* name, const XML_Char** pairs) {
    Reader& self = *static_cast<Reader*>(user);
    self.path_ += '/';
    self.path_ += name;
    Attributes attributes;
    for (; *pairs != nullptr; pairs += 2) attributes[pairs[0]] = pairs[1];
    try {
      self.open(attributes, static_cast<int>(XML_GetCurrentLineNumber(self.parser_.get())));
    } catch (const NotReadable&) {
      self.failed_ = true;
    }
  }
  static void on_end(void* user, const XML_Char*) {
    std::string& path = static_cast<Reader*>(user)->path_;
    path.resize(path.rfind('/'));
  }

  void open(const Attributes& attributes, int line) {
    if (path_ == "/robot/link") {
      link_ = &links[text(attributes, "name")];
      link_->line = line;
    } else if (path_ == "/robot/joint") {
      joints.emplace_back().line = line;
      joints.back().continuous = text(attributes, "type") == "continuous";
    } else if (path_.starts_with("/robot/link/inertial")) {
      open_inertial(attributes, line);
    } else if (path_ == "/robot/joint/origin") {
      joints.back().X = pose(attributes);
    } else if (path_ == "/robot/joint/axis") {
      joints.back().axis = vector(attributes, "xyz", Eigen::Vector3d::UnitX());
    } else if (path_ == "/robot/joint/parent") {
      joints.back().parent = text(attributes, "link");
    } else if (path_ == "/robot/joint/child") {
      joints.back().child = text(attributes, "link");
    }
  }

  void open_inertial(const Attributes& attributes, int line) {
    if (path_ == "/robot/link/inertial") {
      link_->inertial.emplace().line = line;
    } else if (path_ == "/robot/link/inertial/mass") {
      link_->inertial->mass_kg = number(attributes, "value");
    } else if (path_ == "/robot/link/inertial/origin") {
      link_->inertial->X = pose(attributes);
    } else if (path_ == "/robot/link/inertial/inertia") {
      const double ixy = number(attributes, "ixy");
      const double ixz = number(attributes, "ixz");
      const double iyz = number(attributes, "iyz");
      link_->inertial->inertia_kg_m2 << number(attributes, "ixx"), ixy, ixz, ixy,
          number(attributes, "iyy"), iyz, ixz, iyz, number(attributes, "izz");
    }
  }

  std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser_;
  std::string path_;
  Link* link_ = nullptr;
  bool failed_ = false;
};

/// Walks the tree of links once.
class Assembler {
 public:
  Assembler(const Reader& reader, ModelBody& body) : reader_(reader), body_(body) {}

  void run() {
    visit(root(), Eigen::Isometry3d::Identity(), nullptr);
    if (body_.links.size() != reader_.links.size()) throw NotReadable{};  // of several trees
    sum_.finish(body_);
  }

 private:
  std::string root() const {
    for (const auto& [name, link] : reader_.links) {
      if (std::ranges::none_of(
              reader_.joints, [&name = name](const Joint& joint) { return joint.child == name; })) {
        return name;
      }
    }
    throw NotReadable{};
  }

  void visit(const std::string& name, const Eigen::Isometry3d& X_RL, const Joint* joint) {
    const auto found = reader_.links.find(name);
    // A ring of joints would never end.
    if (found == reader_.links.end() || body_.links.size() >= reader_.links.size()) {
      throw NotReadable{};
    }
    const Link& link = found->second;
    ModelLink& placed = body_.links.emplace_back();
    placed.name = name;
    placed.line = joint != nullptr ? joint->line : link.line;
    placed.position_R_m = X_RL.translation();
    if (joint != nullptr && joint->continuous && joint->axis.norm() > 0) {
      placed.axis_R = (X_RL.linear() * joint->axis).normalized();
    }
    if (link.inertial) {
      if (link.inertial->mass_kg < 0) throw NotReadable{};
      sum_.add(*link.inertial, X_RL);
    }
    for (const Joint& next : reader_.joints) {
      if (next.parent == name) visit(next.child, X_RL * next.X, &next);
    }
  }

  const Reader& reader_;
  ModelBody& body_;
  BodySum sum_;
};

}  // namespace

std::optional<ModelBody> read_urdf_body(const std::string& xml) {
  ModelBody body;
  try {
    const Reader reader(xml);
    Assembler(reader, body).run();
  } catch (const NotReadable&) {
    return std::nullopt;
  }
  return body;
}

}  // namespace cas::base
