// SPDX-License-Identifier: BSD-3-Clause
#include "hils/mcap/run_mcap.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/config/vehicle.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/geodesy.hpp"
#include "base/time/rate_gate.hpp"
#include "hils/mcap/mcap_scene.hpp"
#include "hils/mcap/mcap_schemas.hpp"
#include "hils/mcap/mcap_writer.hpp"
#include "hils/measure/csv_file.hpp"
#include "hils/measure/record_tracks.hpp"
#include "hils/measure/reference_track.hpp"
#include "hils/measure/struck_object.hpp"
#include "hils/measure/truth_header.hpp"
#include "libsim/core/body/world_model.hpp"
#include "libsim/core/load/model_loader.hpp"
#include "libsim/core/load/visuals.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink/common/attitude.hpp"
#include "mavlink/common/local_position_ned.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/json/message_codec.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::hils {

namespace {

using base::SimTime;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using mav::services::number_json;
using OrderedJson = nlohmann::ordered_json;
using McapRow = std::span<const double>;

constexpr const char* kWorldFrame = "world";
constexpr McapColor kVehicleColor{0.75, 0.77, 0.8, 1};
constexpr McapColor kGhostColor{0.2, 0.6, 1, 0.35};
constexpr McapColor kReferenceColor{1, 0.6, 0.1, 0.8};
constexpr McapColor kWorldColor{0.62, 0.6, 0.56, 1};
constexpr McapColor kObstacleColor{0.8, 0.35, 0.3, 1};

/// Roll, pitch and yaw with what follows from them.
void put_attitude(OrderedJson& message, double roll, double pitch, double yaw,
                  const Vector3d& w_D) {
  message["orientation"] =
      mcap_quaternion(base::q_WB_from_q_ND(base::quaternion_rpy(roll, pitch, yaw)));
  message["angular_velocity"] = mcap_vector(base::swap_BD(w_D));
  message["roll"] = number_json(roll);
  message["pitch"] = number_json(pitch);
  message["yaw"] = number_json(yaw);
}

/// Channels of all vehicles, each made with its first message.
class McapChannels {
 public:
  explicit McapChannels(McapWriter& file) : file_(file) {}

  void write(const std::string& topic, McapSchema (*schema)(), SimTime time,
             const OrderedJson& message) {
    auto channel = channels_.find(topic);
    if (channel == channels_.end()) {
      auto& id = schemas_[schema];
      if (id == 0) {
        const McapSchema own = schema();
        id = file_.add_schema(own.name, own.text);
      }
      channel = channels_.emplace(topic, file_.add_channel(id, topic)).first;
    }
    file_.write(channel->second, time, text_of(message));
  }

  void write_mavlink(SimTime time, const mav::PacketView& packet) {
    OrderedJson message = codec_.to_json(packet);
    if (message.is_null()) return;
    auto channel = mavlink_.find(packet.message_id);
    if (channel == mavlink_.end()) {
      const McapSchema own = mavlink_schema(packet.message_id);
      const std::string topic = "/mavlink/" + message.at("message").get<std::string>();
      const std::uint16_t schema = file_.add_schema(own.name, own.text);
      channel = mavlink_.emplace(packet.message_id, file_.add_channel(schema, topic)).first;
    }
    message.erase("message");
    say_unnamed(packet.message_id, message);
    message["system"] = packet.source.system;
    message["component"] = packet.source.component;
    file_.write(channel->second, time, text_of(message));
  }

 private:
  static std::string text_of(const OrderedJson& message) {
    return message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  }

  /// A number in a field of words, as text: the schema has one type for a field.
  static void say_unnamed(std::uint32_t message_id, OrderedJson& message) {
    const auto say = [](OrderedJson& value) {
      if (value.is_number()) value = value.dump();
    };
    for (const mav::FieldInfo& field : mavlink::common::fields_of(message_id)) {
      if (std::string_view(field.enum_name).empty()) continue;
      OrderedJson& value = message.at(std::string(std::string_view(field.name)));
      if (!value.is_array()) {
        say(value);
        continue;
      }
      for (OrderedJson& element : value) say(element);
    }
  }

  McapWriter& file_;
  mav::services::MessageCodec codec_;
  std::map<McapSchema (*)(), std::uint16_t> schemas_;
  std::map<std::string, std::uint16_t> channels_;   ///< by topic
  std::map<std::uint32_t, std::uint16_t> mavlink_;  ///< by message
};

/// Samples that are in memory, as a track.
class SampleTrack final : public RecordTrack {
 public:
  using Use = std::function<void(SimTime, const PoseSample&)>;
  SampleTrack(std::vector<PoseSample> samples, Use use)
      : samples_(std::move(samples)), use_(std::move(use)) {}

  std::optional<SimTime> next() const override {
    if (at_ == samples_.size()) return std::nullopt;
    return SimTime(std::chrono::microseconds(samples_[at_].time_us));
  }
  void use_next() override {
    const SimTime time = *next();
    use_(time, samples_[at_++]);
  }

 private:
  std::vector<PoseSample> samples_;
  Use use_;
  std::size_t at_ = 0;
};

/// Turns the records of one vehicle into messages.
class VehicleMcap {
 public:
  /// @param prefix  of its topics: "/", or "/NAME/" of several vehicles
  /// @param home    the world's origin on earth; nullopt: it has none
  VehicleMcap(McapChannels& to, const RunRequest& request, std::size_t place,
              const RunRecord& record, std::string prefix,
              const std::optional<base::Geodetic>& home)
      : to_(to),
        record_(record),
        vehicle_(base::Vehicle::load(request.scenario.vehicles.at(place).vehicle)),
        header_(TruthHeader::parse(CsvFile(record.truth_csv).header(), record.truth_csv)),
        prefix_(std::move(prefix)) {
    if (home) earth_.emplace(*home);
  }

  /// What stands from the begin on.
  void begin(OrderedJson& entities) {
    to_.write(topic("vehicle"), vehicle_schema, {}, facts());
    add_shapes(entities);
    const std::vector<PoseSample>& truth = record_.truth();
    const Pose start = truth.empty() ? Pose{} : truth.front().pose;
    write_transform({}, kWorldFrame, local_frame(), {start.y_m, start.x_m, start.z_m},
                    Quaterniond::Identity());
    reference_ = reference_track(record_, kReferencePeriod_s);
    std::vector<Vector3d> points;
    for (const PoseSample& sample : reference_) {
      const Vector3d p_W(sample.pose.y_m, sample.pose.x_m, sample.pose.z_m);
      if (points.empty() || p_W != points.back()) points.push_back(p_W);
    }
    entities.push_back(mcap_line(frame() + "/reference", kWorldFrame, points, kReferenceColor));
  }

  void add_tracks(RecordTracks& tracks) {
    tracks.add_csv(record_.truth_csv, header_.columns(),
                   [this](SimTime time, McapRow row) { on_truth(time, row); });
    tracks.add_csv(record_.sensors / "motor_command.csv", kCommandValues,
                   [this](SimTime time, McapRow row) { on_command(time, row); });
    tracks.add(std::make_unique<SampleTrack>(
        std::move(reference_),
        [this](SimTime time, const PoseSample& s) { on_reference(time, s); }));
  }

  void on_packet(SimTime time, const mav::PacketView& packet) {
    if (packet.source.system != record_.system) return;
    if (const auto newer = mav::decode<mavlink::common::Attitude>(packet)) attitude_ = newer;
    const auto position = mav::decode<mavlink::common::LocalPositionNed>(packet);
    if (!position || !attitude_) return;
    const Vector3d p_W = base::swap_WN({position->x, position->y, position->z});
    OrderedJson message = begin_message(time);
    message["position"] = mcap_vector(p_W);
    message["velocity"] = mcap_vector(base::swap_WN({position->vx, position->vy, position->vz}));
    put_attitude(message, attitude_->roll, attitude_->pitch, attitude_->yaw,
                 {attitude_->rollspeed, attitude_->pitchspeed, attitude_->yawspeed});
    to_.write(topic("estimate"), estimate_schema, time, message);
    write_transform(time, local_frame(), estimate_frame(), p_W,
                    base::q_WB_from_q_ND(
                        base::quaternion_rpy(attitude_->roll, attitude_->pitch, attitude_->yaw)));
  }

 private:
  static constexpr double kReferencePeriod_s = 0.05;
  static constexpr std::size_t kCommandValues = 4;  ///< column

  std::string topic(const char* name) const { return prefix_ + name; }
  const std::string& frame() const { return record_.vehicle; }
  std::string local_frame() const { return record_.vehicle + "_local"; }
  std::string estimate_frame() const { return record_.vehicle + "_estimate"; }

  OrderedJson begin_message(SimTime time) const {
    return {{"timestamp", mcap_time(time)}, {"vehicle", record_.vehicle}};
  }

  void write_transform(SimTime time, const std::string& parent, const std::string& child,
                       const Vector3d& translation, const Quaterniond& rotation) {
    to_.write("/tf", frame_transform_schema, time,
              {{"timestamp", mcap_time(time)},
               {"parent_frame_id", parent},
               {"child_frame_id", child},
               {"translation", mcap_vector(translation)},
               {"rotation", mcap_quaternion(rotation)}});
  }

  OrderedJson facts() const {
    const auto three = [](const Vector3d& v) -> OrderedJson {
      return {number_json(v.x()), number_json(v.y()), number_json(v.z())};
    };
    OrderedJson rotors = OrderedJson::array();
    for (const base::Rotor& rotor : vehicle_.rotors) {
      rotors.push_back({{"p_B", three(rotor.position_B_m)},
                        {"axis_B", three(rotor.axis_B)},
                        {"radius_m", rotor.params.radius_m},
                        {"spin", rotor.spin},
                        {"k_f", rotor.params.thrust_coefficient},
                        {"omega_max_rad_s", rotor.params.omega_max_rad_s}});
    }
    return {{"vehicle", record_.vehicle},
            {"model", vehicle_.name},
            {"system", record_.system},
            {"mass_kg", vehicle_.mass_kg},
            {"rotors", std::move(rotors)}};
  }

  /// The vehicle as its makers draw it, else its collision shapes; its estimate as a ghost of
  /// these.
  void add_shapes(OrderedJson& entities) const {
    constexpr std::size_t kMostTriangles = 10'000;
    std::vector<sim::Shape> shapes;
    std::vector<sim::Shape> drawn;
    if (!vehicle_.urdf.empty()) {
      const sim::VehicleModel model = sim::load_vehicle_model(vehicle_.urdf, vehicle_.parts);
      shapes = model.shapes;
      std::vector<std::string> warnings;  // the replay tells them
      drawn = sim::load_visuals(model, vehicle_.aero.has_value(), kMostTriangles, warnings);
    }
    entities.push_back(
        mcap_entity(frame(), frame(), drawn.empty() ? shapes : drawn, kVehicleColor));
    entities.push_back(mcap_rotors(frame() + "/rotors", frame(), vehicle_.rotors));
    entities.push_back(mcap_entity(estimate_frame(), estimate_frame(), shapes, kGhostColor));
  }

  void on_truth(SimTime time, McapRow row) {
    const Vector3d p_W(row[2], row[1], row[3]);
    OrderedJson motors = begin_message(time);
    OrderedJson& speeds = motors["speeds_rad_s"] = OrderedJson::array();
    for (const double speed : row.subspan(TruthHeader::kFirstRotor, header_.rotors)) {
      speeds.emplace_back(number_json(speed));
    }
    to_.write(topic("motors"), motors_schema, time, motors);
    OrderedJson message = begin_message(time);
    message["position"] = mcap_vector(p_W);
    message["velocity"] = mcap_vector({row[5], row[4], row[6]});
    put_attitude(message, row[7], row[8], row[9], {row[10], row[11], row[12]});
    if (header_.airspeed) message["airspeed_m_s"] = number_json(row[*header_.airspeed]);
    if (header_.wing) message["wing"] = wing_json(row.subspan(*header_.wing));
    to_.write(topic("truth"), truth_schema, time, message);
    write_transform(time, kWorldFrame, frame(), p_W,
                    base::q_WB_from_q_ND(base::quaternion_rpy(row[7], row[8], row[9])));
    if (!earth_ || !fix_.due(time)) return;
    const base::Geodetic place = earth_->to_geodetic(base::swap_WN(p_W));
    to_.write(topic("location"), location_fix_schema, time,
              {{"timestamp", mcap_time(time)},
               {"frame_id", frame()},
               {"latitude", place.lat_deg},
               {"longitude", place.lon_deg},
               {"altitude", number_json(place.alt_m)},
               {"position_covariance", std::vector<int>(9, 0)},
               {"position_covariance_type", 0}});
  }

  OrderedJson wing_json(McapRow row) const {
    OrderedJson deflections = OrderedJson::array();
    for (const double value : row.subspan(TruthHeader::kWingColumns, header_.surfaces)) {
      deflections.emplace_back(number_json(value));
    }
    return {{"alpha_rad", number_json(row[0])},
            {"beta_rad", number_json(row[1])},
            {"load_factor", number_json(row[2])},
            {"deflections_rad", std::move(deflections)}};
  }

  void on_command(SimTime time, McapRow row) {
    OrderedJson message = begin_message(time);
    message["armed"] = row[3] != 0;
    message["kind"] = row[2] == 0 ? "control_inputs" : "outputs";
    OrderedJson& values = message["values"] = OrderedJson::array();
    for (const double value : row.subspan(kCommandValues)) values.emplace_back(number_json(value));
    to_.write(topic("motor_command"), motor_command_schema, time, message);
  }

  void on_reference(SimTime time, const PoseSample& sample) {
    OrderedJson message = begin_message(time);
    message["position"] = mcap_vector({sample.pose.y_m, sample.pose.x_m, sample.pose.z_m});
    message["yaw"] = number_json(sample.pose.yaw_rad);
    to_.write(topic("reference"), reference_schema, time, message);
  }

  McapChannels& to_;
  const RunRecord& record_;
  base::Vehicle vehicle_;
  TruthHeader header_;
  std::string prefix_;
  std::optional<base::LocalProjection> earth_;
  base::RateGate fix_{10};
  std::vector<PoseSample> reference_;
  std::optional<mavlink::common::Attitude> attitude_;
};

/// What moves in the world by itself.
class ObstacleMcap {
 public:
  ObstacleMcap(McapChannels& to, std::optional<sim::WorldModel> world)
      : to_(to), world_(std::move(world)) {}

  /// Shapes of the world: those at rest, an entity for each, and those that move.
  void begin(OrderedJson& entities) const {
    if (!world_) return;
    std::map<std::string, int> names;
    std::size_t triangles = 0;
    for (const sim::Shape& shape : world_->statics) {
      if (std::holds_alternative<sim::Plane>(shape.geometry)) continue;
      if (const auto* mesh = std::get_if<sim::Mesh>(&shape.geometry)) {
        constexpr std::size_t kMostTriangles = 60'000;  // as the replay
        if (triangles + mesh->triangles->triangles.size() > kMostTriangles) continue;
        triangles += mesh->triangles->triangles.size();
      }
      const int again = names[shape.name]++;
      const std::string id =
          "world/" + shape.name + (again == 0 ? "" : "#" + std::to_string(again));
      entities.push_back(mcap_entity(id, kWorldFrame, {&shape, 1}, kWorldColor));
    }
    for (const sim::MovingObstacle& obstacle : world_->moving) {
      entities.push_back(
          mcap_entity(frame_of(obstacle), frame_of(obstacle), obstacle.shapes, kObstacleColor));
    }
  }

  bool move() const { return world_ && !world_->moving.empty(); }
  /// @param time  of the truth, row by row; only of a world in which something moves
  void on_time(SimTime time) {
    if (!first_ && !gate_.due(time)) return;
    first_ = false;
    for (const sim::MovingObstacle& obstacle : world_->moving) {
      const sim::BodyState state = obstacle.path.at(base::to_seconds(time));
      to_.write("/tf", frame_transform_schema, time,
                {{"timestamp", mcap_time(time)},
                 {"parent_frame_id", kWorldFrame},
                 {"child_frame_id", frame_of(obstacle)},
                 {"translation", mcap_vector(state.p_WB)},
                 {"rotation", mcap_quaternion(state.q_WB)}});
    }
  }

 private:
  static std::string frame_of(const sim::MovingObstacle& obstacle) {
    return "obstacle/" + obstacle.name;
  }

  McapChannels& to_;
  std::optional<sim::WorldModel> world_;
  base::RateGate gate_{20};
  bool first_ = true;
};

std::map<std::string, std::string> facts_of(const RunRequest& request) {
  return {{"cas_version", CAS_VERSION},
          {"scenario", request.scenario.name},
          {"description", request.scenario.description},
          {"architecture", std::string(to_string(request.architecture))},
          {"seed", std::to_string(request.seed)}};
}

}  // namespace

void write_mcap(const RunRequest& request, const RunResult& run) {
  const RunPaths paths = RunPaths::of(request.scenario, request.out, request.out / "run");
  McapWriter file({paths.out, paths.flight_mcap()}, "CAS " CAS_VERSION);
  file.write_metadata("cas", facts_of(request));
  McapChannels channels(file);
  const std::optional<sim::WorldModel> world = flown_world(paths.simulator_config());
  std::optional<base::Geodetic> home = request.scenario.home;
  if (!home && world) home = world->home;
  ObstacleMcap obstacles(channels, world);
  std::vector<std::unique_ptr<VehicleMcap>> vehicles;
  OrderedJson entities = OrderedJson::array();
  obstacles.begin(entities);
  RecordTracks tracks;
  for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
    const RunRecord& record = run.vehicles[i].record;
    vehicles.push_back(std::make_unique<VehicleMcap>(
        channels, request, i, record, run.has_several() ? "/" + record.vehicle + "/" : "/", home));
    vehicles.back()->begin(entities);
    vehicles.back()->add_tracks(tracks);
  }
  channels.write("/scene", scene_update_schema, {},
                 {{"deletions", OrderedJson::array()}, {"entities", std::move(entities)}});
  if (obstacles.move()) {
    tracks.add_csv(run.vehicles.front().record.truth_csv, 1,
                   [&](SimTime time, McapRow) { obstacles.on_time(time); });
  }
  // One log has the messages of all vehicles.
  tracks.add_tlog(run.vehicles.front().record, [&](SimTime time, const mav::PacketView& packet) {
    channels.write_mavlink(time, packet);
    for (const auto& vehicle : vehicles) vehicle->on_packet(time, packet);
  });
  tracks.run();
  file.close();
}

}  // namespace cas::hils
