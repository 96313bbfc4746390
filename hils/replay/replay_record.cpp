// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/replay_record.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>
#include <variant>
#include <vector>

#include "base/config/vehicle.hpp"
#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/read_file.hpp"
#include "base/rpc/base64.hpp"
#include "base/time/clock.hpp"
#include "hils/measure/check_json.hpp"
#include "hils/measure/column.hpp"
#include "hils/measure/csv_file.hpp"
#include "hils/measure/figure_json.hpp"
#include "hils/measure/reference_track.hpp"
#include "hils/measure/struck_object.hpp"
#include "hils/measure/truth_header.hpp"
#include "hils/programs/composition.hpp"
#include "hils/replay/hop_record.hpp"
#include "hils/replay/logged_messages.hpp"
#include "hils/replay/mcap_contents.hpp"
#include "hils/replay/reference_columns.hpp"
#include "hils/replay/truth_columns.hpp"
#include "hils/replay/ulog_messages.hpp"
#include "libsim/core/load/model_loader.hpp"
#include "libsim/core/load/visuals.hpp"

namespace cas::hils {

namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr int kFormat = 1;

std::string dump(const OrderedJson& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// truth.csv at 50 Hz; null where there is none.
OrderedJson truth_json(const std::filesystem::path& file) {
  CsvFile csv(file);
  if (!csv.is_there()) return nullptr;
  const TruthHeader header = TruthHeader::parse(csv.header(), file);
  TruthColumns truth;
  for (auto row = csv.next(header.columns()); !row.empty(); row = csv.next(header.columns())) {
    const std::size_t angles = header.wing ? *header.wing + TruthHeader::kWingColumns : 0;
    truth.add(row.first(TruthHeader::kFirstRotor + header.rotors),
              row.subspan(angles, header.surfaces));
  }
  return truth.json();
}

/// Returns of the lidars; null without one. Scans beyond what a page should carry are left out, the
/// same share of each stretch of the flight.
OrderedJson clouds_json(const std::filesystem::path& file) {
  constexpr std::size_t kMostReturns = 200'000;
  constexpr std::size_t kColumns = 4;
  constexpr std::array<double, kColumns> kSteps{0.001, 0.01, 0.01, 0.01};
  CsvFile csv(file);
  std::array<std::vector<double>, kColumns> columns;
  std::vector<std::size_t> scans;  // where each begins
  for (auto row = csv.next(kColumns); !row.empty(); row = csv.next(kColumns)) {
    if (columns[0].empty() || row[0] != columns[0].back()) scans.push_back(columns[0].size());
    for (std::size_t i = 0; i < kColumns; ++i) columns[i].push_back(row[i]);
  }
  if (scans.empty()) return nullptr;
  const std::size_t every = columns[0].size() / kMostReturns + 1;
  scans.push_back(columns[0].size());
  const auto kept = [&](std::vector<double>& values) {
    std::vector<double> result;
    for (std::size_t scan = 0; scan + 1 < scans.size(); scan += every) {
      result.insert(result.end(), values.begin() + static_cast<std::ptrdiff_t>(scans[scan]),
                    values.begin() + static_cast<std::ptrdiff_t>(scans[scan + 1]));
    }
    return result;
  };
  OrderedJson clouds;
  for (std::size_t i = 0; i < kColumns; ++i) {
    clouds[std::string(1, "tenu"[i])] = column_json(kept(columns[i]), kSteps[i]);
  }
  return clouds;
}

/// The reference that the run is judged by.
OrderedJson reference_json(const RunRecord& record) {
  ReferenceColumns reference;
  for (const PoseSample& sample : reference_track(record, ReferenceColumns::kPeriod_s)) {
    const Pose& pose = sample.pose;
    reference.add(
        {1e-6 * static_cast<double>(sample.time_us), pose.x_m, pose.y_m, pose.z_m, pose.yaw_rad});
  }
  return reference.json();
}

OrderedJson vector_json(const Eigen::Vector3d& v) {
  const auto rounded = [](double x) { return std::round(x * 1e4) / 1e4; };
  return {rounded(v.x()), rounded(v.y()), rounded(v.z())};
}

OrderedJson part_json(const sim::Shape& shape) {
  OrderedJson part;
  if (const auto* box = std::get_if<sim::Box>(&shape.geometry)) {
    part = {{"shape", "box"}, {"size_m", vector_json(box->size_m)}};
  } else if (const auto* ball = std::get_if<sim::Sphere>(&shape.geometry)) {
    part = {{"shape", "sphere"}, {"radius_m", ball->radius_m}};
  } else if (const auto* cylinder = std::get_if<sim::Cylinder>(&shape.geometry)) {
    part = {
        {"shape", "cylinder"}, {"radius_m", cylinder->radius_m}, {"length_m", cylinder->length_m}};
  } else if (std::holds_alternative<sim::Mesh>(shape.geometry)) {
    part = {{"shape", "mesh"}};
  }
  const Eigen::Quaterniond q(shape.pose.rotation());
  part["p"] = vector_json(shape.pose.translation());
  part["q"] = {q.w(), q.x(), q.y(), q.z()};
  return part;
}

/// Shapes as JSON; a mesh is named by its place in `meshes`.
OrderedJson parts_json(const std::vector<sim::Shape>& shapes, OrderedJson& meshes) {
  OrderedJson parts = OrderedJson::array();
  for (const sim::Shape& shape : shapes) {
    OrderedJson part = part_json(shape);
    if (const auto* mesh = std::get_if<sim::Mesh>(&shape.geometry)) {
      part["mesh"] = std::to_string(meshes.size());
      meshes.push_back(base::rpc::to_base64(sim::mesh_bytes(*mesh->triangles)));
    }
    if (part.contains("shape")) parts.push_back(std::move(part));
  }
  return parts;
}

/// The vehicle as sim.scene describes it: shapes, small meshes, rotors.
OrderedJson scene_json(const base::Vehicle& vehicle) {
  constexpr std::size_t kMostTriangles = 10'000;  // a third of a megabyte when it is compressed
  OrderedJson parts = OrderedJson::array();
  OrderedJson visuals = OrderedJson::array();
  OrderedJson meshes = OrderedJson::array();
  if (!vehicle.urdf.empty()) {
    const sim::VehicleModel model = sim::load_vehicle_model(vehicle.urdf, vehicle.parts);
    parts = parts_json(model.shapes, meshes);
    std::vector<std::string> warnings;
    const std::vector<sim::Shape> shapes =
        sim::load_visuals(model, vehicle.aero.has_value(), kMostTriangles, warnings);
    for (const std::string& warning : warnings) base::log::warn(warning);
    visuals = parts_json(shapes, meshes);
    for (const auto& drawn : vehicle.aero ? sim::drawn_surfaces(shapes, *vehicle.aero)
                                          : std::vector<sim::DrawnSurface>()) {
      visuals[drawn.visual]["surface"] = {{"index", drawn.surface}, {"sign", drawn.sign}};
    }
  }
  OrderedJson rotors = OrderedJson::array();
  for (const base::Rotor& rotor : vehicle.rotors) {
    rotors.push_back({{"p_B", vector_json(rotor.position_B_m)},
                      {"axis_B", vector_json(rotor.axis_B)},
                      {"radius_m", rotor.params.radius_m},
                      {"spin", rotor.spin},
                      {"k_f", rotor.params.thrust_coefficient},
                      {"omega_max_rad_s", rotor.params.omega_max_rad_s}});
  }
  return {{"name", vehicle.name},        {"mass_kg", vehicle.mass_kg},
          {"parts", std::move(parts)},   {"visuals", std::move(visuals)},
          {"meshes", std::move(meshes)}, {"rotors", std::move(rotors)}};
}

/// The shapes of the world that does not move, with their names; nothing without a world file.
/// Meshes that together have more triangles than a page should carry are left out.
OrderedJson world_json(const std::filesystem::path& simulator_config) {
  constexpr std::size_t kMostTriangles = 60'000;
  const std::optional<sim::WorldModel> world = flown_world(simulator_config);
  if (!world) return nullptr;
  std::size_t triangles = 0;
  std::map<std::shared_ptr<const sim::TriangleMesh>, std::string> written;  // shapes share them
  OrderedJson parts = OrderedJson::array();
  OrderedJson meshes = OrderedJson::array();
  for (const sim::Shape& shape : sim::drawn_world(*world)) {
    OrderedJson part = part_json(shape);
    if (const auto* mesh = std::get_if<sim::Mesh>(&shape.geometry)) {
      std::string& place = written[mesh->triangles];
      if (place.empty()) {
        const std::size_t all = triangles + mesh->triangles->triangles.size();
        if (all > kMostTriangles) continue;
        triangles = all;
        place = std::to_string(meshes.size());
        meshes.push_back(base::rpc::to_base64(sim::mesh_bytes(*mesh->triangles)));
      }
      part["mesh"] = place;
    }
    part["name"] = shape.name;
    if (part.contains("shape")) parts.push_back(std::move(part));
  }
  return {{"parts", std::move(parts)}, {"meshes", std::move(meshes)}};
}

OrderedJson stage_json(const Stage& stage) {
  return {{"name", phase_of(stage.step)},
          {"step", to_string(stage.step.kind)},
          {"begin_s", base::to_seconds(stage.begin)},
          {"end_s", base::to_seconds(stage.end)},
          {"measured", stage.step.measure}};
}

/// The last one may not have been done.
OrderedJson stages_json(const RunRecord& record) {
  OrderedJson stages = OrderedJson::array();
  for (const Stage& stage : record.stages) {
    if (stage.step.kind == StepKind::kEndTrajectory) continue;  // follows each trajectory by itself
    stages.push_back(stage_json(stage));
  }
  if (record.under_way) {
    stages.push_back(stage_json(*record.under_way));
    stages.back()["finished"] = false;
  }
  return stages;
}

OrderedJson faults_json(const RunRecord& record) {
  OrderedJson faults = OrderedJson::array();
  for (const auto& fault : record.faults) {
    faults.push_back(
        {{"name", fault.name},
         {"begin_s", base::to_seconds(fault.begin)},
         {"end_s", fault.end ? OrderedJson(base::to_seconds(*fault.end)) : OrderedJson(nullptr)}});
  }
  return faults;
}

/// Crashes and their kin, the step that was not done, changed parameters, and commands from
/// outside.
OrderedJson events_json(const Measurement& figures) {
  OrderedJson events = OrderedJson::array();
  if (figures.flight_failure && figures.under_way) {
    events.push_back({{"t_s", base::to_seconds(figures.under_way->end)},
                      {"kind", "incident"},
                      {"text", *figures.flight_failure}});
  }
  for (const Incident& incident : figures.incidents) {
    events.push_back(
        {{"t_s", incident.time_s}, {"kind", "incident"}, {"text", "the vehicle " + incident.what}});
  }
  for (const ParameterChange& change : figures.changes.parameters) {
    OrderedJson event{{"t_s", change.time_s},
                      {"kind", "parameter"},
                      {"text", change.parameter},
                      {"before", number_or_null(change.before)},
                      {"after", number_or_null(change.after)},
                      {"by", change.by}};
    events.push_back(std::move(event));
  }
  for (const OutsideAct& act : figures.changes.acts) {
    events.push_back({{"t_s", act.time_s}, {"kind", "act"}, {"text", act.what}, {"by", act.by}});
  }
  return events;
}

OrderedJson responses_json(const Measurement& figures) {
  OrderedJson responses = OrderedJson::array();
  for (const StepResponse& response : figures.responses) {
    OrderedJson& own = responses.emplace_back(OrderedJson{{"name", response.name}});
    put_figures(response_table(), Figure<StepResponse>::Part::kRun, response, own);
  }
  return responses;
}

/// The mean wind that plugin wind of the scenario blows, m/s; null without it.
OrderedJson mean_wind_json(const Scenario& scenario) {
  for (const base::ConfigNode& plugin : scenario.plugins) {
    if (plugin.get<std::string>("plugin", "") != "wind") continue;
    return plugin.get<double>("mean_m_s", 0);
  }
  return nullptr;
}

OrderedJson vehicle_json(const RunRequest& request, std::size_t i, const VehicleResult& result) {
  const RunRecord& record = result.record;
  OrderedJson vehicle{
      {"name", record.vehicle},
      {"system", record.system},
      {"scene", scene_json(base::Vehicle::load(request.scenario.vehicles.at(i).vehicle))},
      {"passed", result.verdict.passed},
      {"touched", result.figures.changes.from_outside()},
      {"checks", checks_json(result.verdict.checks)},
      {"stages", stages_json(record)},
      {"faults", faults_json(record)},
      {"events", events_json(result.figures)},
      {"responses", responses_json(result.figures)},
      {"truth", truth_json(record.truth_csv)},
      {"clouds", clouds_json(record.clouds_csv)},
      {"reference", reference_json(record)},
      {"link", hop_record(record)}};
  vehicle["log"] = std::filesystem::exists(record.flight_tlog)
                       ? logged_messages(record.flight_tlog, record.system, record.log_clock)
                       : OrderedJson(nullptr);
  return vehicle;
}

/// Lines between casd and the controllers: serial with their rate, if all have one, UDP, or in
/// lockstep none with a speed.
OrderedJson line_json(const RunRequest& request) {
  if (request.scenario.firmware) {
    return {{"type", request.scenario.firmware->on_serial_line ? "serial" : "udp"}};
  }
  if (request.architecture == Architecture::kDirect) return {{"type", "none"}};
  if (request.architecture == Architecture::kSitl) return {{"type", "udp"}};
  if (request.clock == Clock::kLockstep) return {{"type", "lockstep"}};
  std::set<double> bauds;
  for (std::size_t i = 0; i < request.scenario.vehicles.size(); ++i) {
    const FcuDevice* device = request.fcu_device(i);
    bauds.insert(device == nullptr ? static_cast<double>(line_of(request).baud) : device->baud);
  }
  OrderedJson line = OrderedJson::object();
  line["type"] = "serial";
  if (bauds.size() == 1) line["baud"] = *bauds.begin();
  return line;
}

/// The controllers: "fcu_emulator", or for each vehicle that or the port of a real one.
std::string controllers(const RunRequest& request) {
  constexpr const char* kEmulator = "fcu_emulator";
  if (request.scenario.firmware) {
    const FcuDevice* board = request.fcu_device(0);
    return request.scenario.firmware->autopilot + (board == nullptr ? "" : ", " + board->path);
  }
  if (request.fcu_devices.empty()) return kEmulator;
  std::string all;
  for (std::size_t i = 0; i < request.scenario.vehicles.size(); ++i) {
    const FcuDevice* device = request.fcu_device(i);
    all += (all.empty() ? "" : ", ") + (device == nullptr ? kEmulator : device->path);
  }
  return all;
}

/// The record of a log alone. @param vehicle  its data from the log
std::string log_record(const std::filesystem::path& file, const OrderedJson& vehicle) {
  OrderedJson named{{"name", file.stem().string()}};
  named.update(vehicle);
  return dump({{"format", kFormat},
               {"cas", CAS_VERSION},
               {"name", file.filename().string()},
               {"duration_s", named["log"]["duration_s"]},
               {"controller", named.value("controller", "")},
               {"vehicles", OrderedJson::array({named})}});
}

}  // namespace

std::string replay_record(const RunRequest& request, const RunResult& run) {
  const Measurement whole = run.whole();
  OrderedJson record{
      {"format", kFormat},
      {"cas", CAS_VERSION},
      {"name", request.scenario.name},
      {"description", request.scenario.description},
      {"seed", request.seed},
      {"architecture", to_string(request.architecture)},
      {"virtual", whole.virtual_clock},
      {"duration_s", whole.simulated_s},
      {"rate", whole.pace.real_time_factor},
      {"nominal_hz",
       {{"HIL_SENSOR", request.scenario.rates.sensor_hz},
        {"HIL_GPS", request.scenario.rates.gps_hz},
        {"HIL_CONTROLS", request.scenario.rates.controls_hz},
        {"HIL_ACTUATOR_CONTROLS", request.scenario.rates.controls_hz}}},
      {"line", line_json(request)},
      {"world",
       world_json(RunPaths::of(request.scenario, request.out, request.out).simulator_config())},
      {"controller", controllers(request)},
      {"mean_wind_m_s", mean_wind_json(request.scenario)},
      {"verdict",
       {{"valid", run.verdict.valid},
        {"passed", run.verdict.passed},
        {"failures", run.verdict.failures}}},
      {"vehicles", OrderedJson::array()}};
  for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
    record["vehicles"].push_back(vehicle_json(request, i, run.vehicles[i]));
  }
  return dump(record);
}

std::string tlog_record(const std::filesystem::path& tlog) {
  const std::uint8_t system = first_autopilot(tlog);
  if (system == 0) throw base::ConfigError(tlog.string() + ": no autopilot is in this log");
  LoggedLoss loss;
  OrderedJson messages = logged_messages(tlog, system, {}, &loss);
  const std::string lacks = loss.sentence();
  if (!lacks.empty()) fmt::print(stderr, "{}: the log is not whole: {}\n", tlog.string(), lacks);
  return log_record(tlog, {{"system", system}, {"log", std::move(messages)}});
}

std::string ulog_record(const std::filesystem::path& ulog) {
  constexpr std::size_t kMaxUlogBytes = std::size_t{1} << 30U;
  const std::string bytes = base::read_foreign_file(ulog, "log", kMaxUlogBytes);
  try {
    UlogLoss loss;
    const OrderedJson vehicle = ulog_messages(bytes, kMostUlogNumbers, &loss);
    const std::string lacks = loss.sentence();
    if (!lacks.empty()) fmt::print(stderr, "{}: the log is not whole: {}\n", ulog.string(), lacks);
    return log_record(ulog, vehicle);
  } catch (const base::ConfigError& error) {
    throw base::ConfigError(ulog.string() + ": " + error.what());
  }
}

std::string mcap_record(const std::filesystem::path& mcap) {
  constexpr std::size_t kMaxMcapBytes = std::size_t{1} << 30U;
  const std::string bytes = base::read_foreign_file(mcap, "recording", kMaxMcapBytes);
  try {
    McapLoss loss;
    OrderedJson record{{"format", kFormat}, {"cas", CAS_VERSION}};
    record.update(mcap_contents(bytes, mcap.stem().string(), &loss));
    if (record["name"] == "") record["name"] = mcap.filename().string();
    const std::string lacks = loss.sentence();
    if (!lacks.empty()) {
      fmt::print(stderr, "{}: the recording is not whole: {}\n", mcap.string(), lacks);
    }
    return dump(record);
  } catch (const base::ConfigError& error) {
    throw base::ConfigError(mcap.string() + ": " + error.what());
  }
}

}  // namespace cas::hils
