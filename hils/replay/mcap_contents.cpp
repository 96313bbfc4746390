// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/mcap_contents.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "base/earth/frames.hpp"
#include "base/error.hpp"
#include "base/printable.hpp"
#include "base/rpc/base64.hpp"
#include "hils/mcap/read_mcap.hpp"
#include "hils/replay/logged_messages.hpp"
#include "hils/replay/logged_series.hpp"
#include "hils/replay/reference_columns.hpp"
#include "hils/replay/truth_columns.hpp"
#include "libsim/core/body/shape.hpp"
#include "libsim/core/load/visuals.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink_gen/json/message_codec.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::hils {

namespace {

using OrderedJson = nlohmann::ordered_json;
using Eigen::Vector3d;

constexpr std::size_t kMostMcapTextBytes = std::size_t{16} << 20U;  // of a message
constexpr std::size_t kMostMcapLevels = 64;
constexpr std::size_t kMostMcapRows = 1'000'000;  // of truth and reference
constexpr std::size_t kMostMcapVehicles = 256;
constexpr std::size_t kMostMcapFields = 256;          // of a message
constexpr std::size_t kMostMcapElements = 16;         // of an array
constexpr std::size_t kMostSceneParts = 10'000;       // of all scenes
constexpr std::size_t kMostSceneTriangles = 100'000;  // of a world and vehicles
constexpr std::size_t kMostMcapNumbers = 3'000'000;

/// Whether a text nests deeper than a reader should follow.
bool is_too_deep_json(std::string_view text) {
  std::size_t depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c == '\\') ++i;
      quoted = c != '"';
    } else if (c == '"') {
      quoted = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMostMcapLevels) return true;
    } else if (c == '}' || c == ']') {
      depth -= depth > 0 ? 1 : 0;
    }
  }
  return false;
}

/// An object; null for anything else.
OrderedJson json_object_of(std::string_view text) {
  if (text.size() > kMostMcapTextBytes || is_too_deep_json(text)) return nullptr;
  OrderedJson value = OrderedJson::parse(text, nullptr, false);
  return value.is_object() ? value : OrderedJson(nullptr);
}

const OrderedJson& json_member(const OrderedJson& object, const char* key) {
  static const OrderedJson kNone;
  const auto found = object.is_object() ? object.find(key) : object.end();
  return found == object.end() ? kNone : *found;
}
/// NaN where there is no such number.
double json_number(const OrderedJson& object, const char* key) {
  const OrderedJson& value = json_member(object, key);
  return value.is_number() ? value.get<double>() : std::nan("");
}
std::string json_word(const OrderedJson& object, const char* key) {
  const OrderedJson& value = json_member(object, key);
  return value.is_string() ? value.get<std::string>() : "";
}
const OrderedJson& json_list(const OrderedJson& object, const char* key) {
  static const OrderedJson kEmpty = OrderedJson::array();
  const OrderedJson& value = json_member(object, key);
  return value.is_array() ? value : kEmpty;
}
Vector3d json_vector(const OrderedJson& object, const char* key) {
  const OrderedJson& value = json_member(object, key);
  return {json_number(value, "x"), json_number(value, "y"), json_number(value, "z")};
}
bool all_finite(std::span<const double> values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

/// First reading: when the file begins.
class FirstMcapTime final : public McapListener {
 public:
  void on_message(const McapChannel&, std::uint64_t time_ns, std::string_view) override {
    ++messages_;
    first_ = std::min(first_, time_ns);
    if (time_ns > 0) first_beyond_ = std::min(first_beyond_, time_ns);
  }
  /// Some recorders give what stands from the begin on the time 0, and the rest that of the day.
  std::uint64_t ns() const {
    constexpr std::uint64_t kDay = 86'400'000'000'000;
    const bool leaps = first_beyond_ != kNone && first_beyond_ > kDay;
    return leaps ? first_beyond_ : first_;
  }
  std::uint64_t messages() const { return messages_; }

 private:
  static constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t messages_ = 0;
  std::uint64_t first_ = kNone;
  std::uint64_t first_beyond_ = kNone;
};

/// Shapes of SceneUpdates by their frames, as a record has them.
class SceneParts {
 public:
  struct Parts {
    OrderedJson parts = OrderedJson::array();
    OrderedJson meshes = OrderedJson::array();
  };

  void on_update(const OrderedJson& update) {
    for (const OrderedJson& entity : json_list(update, "entities")) {
      // As it was first: a recorder may repeat it as often as it likes.
      if (parts_ == kMostSceneParts || !ids_.insert(json_word(entity, "id")).second) continue;
      const std::string frame = json_word(entity, "frame_id");
      for (const OrderedJson& cube : json_list(entity, "cubes")) add_box(frame, entity, cube);
      for (const OrderedJson& ball : json_list(entity, "spheres")) add_sphere(frame, entity, ball);
      for (const OrderedJson& each : json_list(entity, "cylinders"))
        add_cylinder(frame, entity, each);
      for (const OrderedJson& mesh : json_list(entity, "triangles")) add_mesh(frame, entity, mesh);
    }
  }

  /// Shapes in a frame; nullptr: it has none.
  const Parts* in(const std::string& frame) const {
    const auto found = frames_.find(frame);
    return found == frames_.end() ? nullptr : &found->second;
  }

 private:
  /// Adds a shape with its pose and its entity's name, where all of it is a number.
  void add(const std::string& frame, const OrderedJson& entity, const OrderedJson& primitive,
           OrderedJson part, std::span<const double> sizes) {
    const Vector3d p = json_vector(json_member(primitive, "pose"), "position");
    const OrderedJson& turn = json_member(json_member(primitive, "pose"), "orientation");
    const std::array numbers{p.x(),
                             p.y(),
                             p.z(),
                             json_number(turn, "w"),
                             json_number(turn, "x"),
                             json_number(turn, "y"),
                             json_number(turn, "z")};
    if (parts_ == kMostSceneParts || !all_finite(numbers) || !all_finite(sizes)) return;
    ++parts_;
    part["p"] = {numbers[0], numbers[1], numbers[2]};
    part["q"] = {numbers[3], numbers[4], numbers[5], numbers[6]};
    std::string id = json_word(entity, "id");
    if (id.starts_with("world/")) id.erase(0, 6);
    part["name"] = id;
    frames_[frame].parts.push_back(std::move(part));
  }

  void add_box(const std::string& frame, const OrderedJson& entity, const OrderedJson& cube) {
    const Vector3d size = json_vector(cube, "size");
    add(frame, entity, cube, {{"shape", "box"}, {"size_m", {size.x(), size.y(), size.z()}}},
        {size.data(), 3});
  }
  void add_sphere(const std::string& frame, const OrderedJson& entity, const OrderedJson& ball) {
    const double radius = json_vector(ball, "size").x() / 2;
    add(frame, entity, ball, {{"shape", "sphere"}, {"radius_m", radius}}, {&radius, 1});
  }
  void add_cylinder(const std::string& frame, const OrderedJson& entity,
                    const OrderedJson& cylinder) {
    const Vector3d size = json_vector(cylinder, "size");
    add(frame, entity, cylinder,
        {{"shape", "cylinder"}, {"radius_m", size.x() / 2}, {"length_m", size.z()}},
        {size.data(), 3});
  }
  void add_mesh(const std::string& frame, const OrderedJson& entity, const OrderedJson& mesh) {
    sim::TriangleMesh triangles;
    for (const OrderedJson& point : json_list(mesh, "points")) {
      triangles.vertices.emplace_back(json_number(point, "x"), json_number(point, "y"),
                                      json_number(point, "z"));
      if (!triangles.vertices.back().allFinite()) return;
    }
    std::vector<std::uint32_t> corners;
    for (const OrderedJson& index : json_list(mesh, "indices")) {
      if (!index.is_number_unsigned() || index.get<std::uint64_t>() >= triangles.vertices.size()) {
        return;
      }
      corners.push_back(index.get<std::uint32_t>());
    }
    if (corners.empty()) {
      for (std::uint32_t i = 0; i < triangles.vertices.size(); ++i) corners.push_back(i);
    }
    if (points_ + corners.size() > 3 * kMostSceneTriangles) return;
    points_ += corners.size();
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
      triangles.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
    }
    OrderedJson& meshes = frames_[frame].meshes;
    const std::string place = std::to_string(meshes.size());
    const std::size_t before = parts_;
    add(frame, entity, mesh, {{"shape", "mesh"}, {"mesh", place}}, {});
    if (parts_ > before) meshes.push_back(base::rpc::to_base64(sim::mesh_bytes(triangles)));
  }

  std::map<std::string, Parts> frames_;
  std::set<std::string> ids_;  ///< of entities so far
  std::size_t parts_ = 0;
  std::size_t points_ = 0;
};

static_assert(10'000 * (kMostMcapFields + 1) < kMostMcapNumbers,
              "one of each channel can always be shown");

/// A channel whose numbers are shown as they are: "a.b", "list[2]".
class ShownChannel {
 public:
  /// @return how many numbers it took
  /// @param parse  gives the message, where its numbers are wanted
  template <class Parse>
  std::size_t add(double t_s, const Parse& parse) {
    if (!series_.take(t_s)) return 0;
    found_.clear();
    collect(parse(), "");
    if (names_.empty()) {
      for (const auto& [name, value] : found_) names_.push_back(name);
    }
    // The fields are those of its first message: one that comes and goes has gaps.
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const auto at = i < found_.size() && found_[i].first == names_[i]
                          ? found_.begin() + static_cast<std::ptrdiff_t>(i)
                          : std::ranges::find(found_, names_[i], &Found::first);
      series_.add(names_[i], "", at == found_.end() ? std::nan("") : at->second, true);
    }
    return names_.size() + 1;
  }
  LoggedSeries& series() { return series_; }

 private:
  using Found = std::pair<std::string, double>;

  void collect(const OrderedJson& value, const std::string& name) {
    if (found_.size() == kMostMcapFields || name.size() > kMostNameBytes) return;
    if (value.is_number() || value.is_boolean()) {
      const double real = value.is_boolean() ? (value.get<bool>() ? 1 : 0) : value.get<double>();
      if (!name.empty()) found_.emplace_back(name, real);
    } else if (value.is_object()) {
      for (const auto& [key, inner] : value.items()) {
        if (key != "timestamp") collect(inner, name.empty() ? key : name + "." + key);
      }
    } else if (value.is_array()) {
      for (std::size_t i = 0; i < std::min(value.size(), kMostMcapElements); ++i) {
        collect(value[i], fmt::format("{}[{}]", name, i));
      }
    }
  }

  static constexpr std::size_t kMostNameBytes = 256;
  LoggedSeries series_;
  std::vector<std::string> names_;
  std::vector<Found> found_;
};

/// What the file says of one vehicle.
struct ReplayedVehicle {
  OrderedJson facts;  ///< cas.Vehicle
  TruthColumns truth;
  std::vector<double> rotors;  ///< newest speeds
  ReferenceColumns reference;
};

/// Second reading: collects the contents of the page.
class McapContents final : public McapListener {
 public:
  explicit McapContents(std::uint64_t first_ns) : first_ns_(first_ns) {}

  void on_metadata(std::string_view name,
                   const std::map<std::string, std::string>& facts) override {
    if (name == "cas") facts_ = facts;
  }

  void on_message(const McapChannel& channel, std::uint64_t time_ns,
                  std::string_view data) override {
    if (channel.encoding != "json") {
      if (others_.size() < kMostEncodings || others_.contains(channel.encoding)) {
        ++others_[channel.encoding];
      }
      return;
    }
    ++shown_;
    // A whole number of microseconds gives the time that every other log has for it.
    const std::uint64_t since_ns = time_ns > first_ns_ ? time_ns - first_ns_ : 0;
    const double t_s = 1e-6 * (static_cast<double>(since_ns) / 1e3);
    newest_s_ = std::max(newest_s_, t_s);
    if (channel.topic.starts_with(kMavlink) && on_mavlink(t_s, channel, data)) return;
    if (channel.schema == "foxglove.SceneUpdate") return scene_.on_update(parsed(data));
    if (channel.schema == "foxglove.FrameTransform") return;  // a mix of frames is no curve
    if (channel.schema.starts_with("cas.")) on_own(t_s, channel.schema, parsed(data));
    if (channel.schema != "cas.Vehicle") show(t_s, channel.topic, data);
  }

  McapLoss loss(std::optional<std::size_t> cut_at) const {
    return {.cut_at = cut_at, .unreadable = unreadable_, .other_encodings = others_};
  }
  bool empty() const { return shown_ == 0; }

  OrderedJson take(const std::string& name) {
    OrderedJson all{{"name", fact("scenario", "")},
                    {"description", fact("description", "")},
                    {"architecture", fact("architecture", "")},
                    {"duration_s", newest_s_}};
    const std::string seed = fact("seed", "");
    std::uint64_t number = 0;
    const auto read = std::from_chars(seed.data(), seed.data() + seed.size(), number);
    if (!seed.empty() && read.ptr == seed.data() + seed.size() && read.ec == std::errc()) {
      all["seed"] = number;
    }
    if (const auto* world = scene_.in("world")) {
      all["world"] = {{"parts", world->parts}, {"meshes", world->meshes}};
    }
    if (vehicles_.empty()) {
      vehicles_[name].facts = {{"vehicle", name}, {"system", autopilot_ == 0 ? 1 : autopilot_}};
    }
    OrderedJson& listed = all["vehicles"] = OrderedJson::array();
    for (const auto& [own, vehicle] : vehicles_) {
      listed.push_back(vehicle_json(own, vehicle, listed.empty()));
    }
    return all;
  }

 private:
  static constexpr std::string_view kMavlink = "/mavlink/";
  static constexpr std::size_t kMostEncodings = 16;

  std::string fact(const char* key, const char* otherwise) const {
    const auto found = facts_.find(key);
    return found == facts_.end() ? otherwise : found->second;
  }

  /// The object of a message; null, and counted, where it is none.
  OrderedJson parsed(std::string_view data) {
    OrderedJson object = json_object_of(data);
    unreadable_ += object.is_null() ? 1 : 0;
    return object;
  }

  /// @return false for a message of another dialect or another form
  bool on_mavlink(double t_s, const McapChannel& channel, std::string_view data) {
    OrderedJson message = json_object_of(data);
    const double system = json_number(message, "system");
    const double component = json_number(message, "component");
    if (!(system >= 0 && system <= 255 && component >= 0 && component <= 255)) return false;
    message.erase("system");
    message.erase("component");
    message["message"] = channel.topic.substr(kMavlink.size());
    const mav::Source source{static_cast<std::uint8_t>(system),
                             static_cast<std::uint8_t>(component)};
    try {
      const mav::PacketBuffer bytes = codec_.from_json(message, source, 0);
      const mav::PacketView packet = mav::view_packet(bytes.view());
      const auto heartbeat = mav::decode<mavlink::common::Heartbeat>(packet);
      if (autopilot_ == 0 && heartbeat &&
          heartbeat->autopilot != mavlink::common::MavAutopilot::kInvalid) {
        autopilot_ = source.system;
      }
      logs_[source.system].on_packet(t_s, packet);
      return true;
    } catch (const std::invalid_argument&) {
      return false;
    }
  }

  void on_own(double t_s, std::string_view schema, const OrderedJson& message) {
    const std::string name = json_word(message, "vehicle");
    if (name.empty() || (vehicles_.size() == kMostMcapVehicles && !vehicles_.contains(name)))
      return;
    ReplayedVehicle& vehicle = vehicles_[name];
    if (schema == "cas.Vehicle") vehicle.facts = message;
    if (schema == "cas.Motors") {
      vehicle.rotors.clear();
      for (const OrderedJson& speed : json_list(message, "speeds_rad_s")) {
        if (speed.is_number() && vehicle.rotors.size() < kMostMcapElements) {
          vehicle.rotors.push_back(speed.get<double>());
        }
      }
    }
    if (schema == "cas.Truth") on_truth(t_s, message, vehicle);
    if (schema == "cas.Reference") on_reference(t_s, message, vehicle);
  }

  void on_truth(double t_s, const OrderedJson& message, ReplayedVehicle& vehicle) {
    const Vector3d p_W = json_vector(message, "position");
    const Vector3d v_W = json_vector(message, "velocity");
    const Vector3d w_D = base::swap_BD(json_vector(message, "angular_velocity"));
    std::vector<double> row{t_s,
                            p_W.y(),
                            p_W.x(),
                            p_W.z(),
                            v_W.y(),
                            v_W.x(),
                            v_W.z(),
                            json_number(message, "roll"),
                            json_number(message, "pitch"),
                            json_number(message, "yaw"),
                            w_D.x(),
                            w_D.y(),
                            w_D.z()};
    row.insert(row.end(), vehicle.rotors.begin(), vehicle.rotors.end());
    if (rows_ == kMostMcapRows || !all_finite(row)) return;
    ++rows_;
    vehicle.truth.add(row);
  }

  void on_reference(double t_s, const OrderedJson& message, ReplayedVehicle& vehicle) {
    const Vector3d p_W = json_vector(message, "position");
    const std::array row{t_s, p_W.y(), p_W.x(), p_W.z(), json_number(message, "yaw")};
    if (rows_ == kMostMcapRows || !all_finite(row)) return;
    ++rows_;
    vehicle.reference.add(row);
  }

  void show(double t_s, const std::string& topic, std::string_view data) {
    numbers_ += channels_[topic].add(t_s, [&] { return parsed(data); });
    while (numbers_ > kMostMcapNumbers) {
      numbers_ = 0;
      for (auto& [name, channel] : channels_) {
        channel.series().thin();
        numbers_ += channel.series().numbers();
      }
    }
  }

  OrderedJson vehicle_json(const std::string& name, const ReplayedVehicle& vehicle, bool is_first) {
    const double system = json_number(vehicle.facts, "system");
    const int id = system >= 1 && system <= 255 ? static_cast<int>(system) : 1;
    OrderedJson json{{"name", name}, {"system", id}};
    if (const auto* shapes = scene_.in(name)) json["scene"] = scene_json(vehicle.facts, *shapes);
    json["truth"] = vehicle.truth.json();
    json["reference"] = vehicle.reference.json();
    const auto heard = logs_.find(static_cast<std::uint8_t>(id));
    OrderedJson log = heard == logs_.end() ? MessageCollector().json() : heard->second.json();
    log["duration_s"] = newest_s_;
    for (auto& [topic, channel] : channels_) {
      // With several vehicles each shows its own topics; topics without a vehicle go to the first.
      const std::size_t end = topic.find('/', 1);
      const std::string of = end == std::string::npos ? "" : topic.substr(1, end - 1);
      const bool is_own = vehicles_.contains(of) ? of == name : is_first;
      if (is_own) log["messages"].push_back(channel.series().json(topic));
    }
    json["log"] = std::move(log);
    return json;
  }

  /// As a run's record has it. Parts of the rotors' discs are left out: the page turns them itself.
  static OrderedJson scene_json(const OrderedJson& facts, const SceneParts::Parts& shapes) {
    OrderedJson parts = OrderedJson::array();
    for (const OrderedJson& part : shapes.parts) {
      if (!json_word(part, "name").ends_with("/rotors")) parts.push_back(part);
    }
    OrderedJson rotors = OrderedJson::array();
    for (const OrderedJson& rotor : json_list(facts, "rotors")) {
      if (is_rotor(rotor)) rotors.push_back(rotor);
    }
    const double mass_kg = json_number(facts, "mass_kg");
    return {{"name", json_word(facts, "model")}, {"mass_kg", std::isfinite(mass_kg) ? mass_kg : 0},
            {"parts", std::move(parts)},         {"visuals", OrderedJson::array()},
            {"meshes", shapes.meshes},           {"rotors", std::move(rotors)}};
  }

  static bool is_rotor(const OrderedJson& rotor) {
    const auto has_three = [&](const char* key) {
      const OrderedJson& values = json_list(rotor, key);
      return values.size() == 3 && std::ranges::all_of(values, [](const OrderedJson& value) {
               return value.is_number();
             });
    };
    return has_three("p_B") && has_three("axis_B") &&
           all_finite(std::array{json_number(rotor, "radius_m"), json_number(rotor, "spin"),
                                 json_number(rotor, "k_f"), json_number(rotor, "omega_max_rad_s")});
  }

  std::uint64_t first_ns_;
  std::map<std::string, std::string> facts_;
  mav::services::MessageCodec codec_;
  std::map<std::uint8_t, MessageCollector> logs_;  ///< by system
  std::map<std::string, ReplayedVehicle> vehicles_;
  std::map<std::string, ShownChannel> channels_;  ///< by topic
  SceneParts scene_;
  std::map<std::string, std::uint64_t> others_;
  std::uint64_t unreadable_ = 0;
  std::uint64_t shown_ = 0;
  std::size_t rows_ = 0;
  std::size_t numbers_ = 0;
  std::uint8_t autopilot_ = 0;
  double newest_s_ = 0;
};

}  // namespace

std::string McapLoss::sentence() const {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  for (const auto& [encoding, messages] : other_encodings) {
    add(fmt::format("{} message(s) encoded as `{}` left out", messages, base::printable(encoding)));
  }
  if (unreadable > 0) {
    add(fmt::format("{} message(s) that are no JSON object left out", unreadable));
  }
  if (cut_at) add(fmt::format("it ends within the record at byte {}", *cut_at));
  return text;
}

OrderedJson mcap_contents(std::string_view bytes, const std::string& name, McapLoss* loss) {
  FirstMcapTime first;
  const std::optional<std::size_t> cut_at = read_mcap(bytes, first);
  McapContents contents(first.ns());
  if (first.messages() > 0) read_mcap(bytes, contents);
  const McapLoss lost = contents.loss(cut_at);
  if (contents.empty()) {
    const std::string why = lost.sentence();
    throw base::ConfigError("no JSON message is in this file" + (why.empty() ? "" : ": " + why));
  }
  if (loss != nullptr) *loss = lost;
  return contents.take(name);
}

}  // namespace cas::hils
